//! Connected components of a Laplacian.

use rustc_hash::FxHashMap;

use crate::along_surface::laplacian::Laplacian;

#[derive(Default)]
pub struct Component {
    // Vertices of the component as indices into `Laplacian::vertices`, ascending, n.
    pub vertices: Vec<u32>,
    pub mass: Vec<f64>,
    pub edges: Vec<([u32; 2], f64)>,
}

impl Component {
    pub fn area(&self) -> f64 {
        self.mass.iter().sum()
    }
}

pub fn components(laplacian: &Laplacian) -> Vec<Component> {
    let mut components: Vec<Component> = Vec::new();
    let mut at: FxHashMap<u32, usize> = FxHashMap::default();
    let mut within = Vec::with_capacity(laplacian.mass.len());
    for (place, (&name, &mass)) in laplacian.component.iter().zip(&laplacian.mass).enumerate() {
        let index = *at.entry(name).or_insert(components.len());
        if index == components.len() {
            components.push(Component::default());
        }
        within.push(components[index].vertices.len() as u32);
        components[index].vertices.push(place as u32);
        components[index].mass.push(mass);
    }
    for &(ends, weight) in &laplacian.edges {
        let component = &mut components[at[&laplacian.component[ends[0] as usize]]];
        component.edges.push((ends.map(|end| within[end as usize]), weight));
    }
    // A stable sort keeps components of equal area in order.
    components.sort_by(|a, b| b.area().total_cmp(&a.area()));
    components
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn components_partition_vertices_and_edges() {
        let small = shapes::icosphere(0);
        let large = shapes::grid(5, 4);
        let both = shapes::unite([&small, &shapes::place(&large, |[x, y, _]| [20.0 * x, 20.0 * y, 9.0])]);
        let laplacian = Laplacian::new(&both).unwrap();
        let components = components(&laplacian);
        assert_eq!(components.iter().map(|component| component.vertices.len()).collect::<Vec<_>>(), [30, 12]);
        assert!((components[0].area() - 400.0).abs() < 0.1 && components[1].vertices == (0..12).collect::<Vec<u32>>());
        assert_eq!(components.iter().map(|component| component.edges.len()).sum::<usize>(), laplacian.edges.len());
        for component in components {
            for ([i, j], weight) in component.edges {
                let ends = [i, j].map(|end| component.vertices[end as usize]);
                assert!(laplacian.edges.contains(&(ends, weight)));
            }
        }
    }
}
