//! Deformations that the components of a surface may still have.

/// Allowed deformations of the components of a surface, at unit size.
#[derive(Clone, Default)]
pub struct Ceilings {
    /// Deformation still allowed at each surface vertex; empty for no limits.
    pub left: Vec<f32>,
    pub component_of_vertex: Vec<u32>,
    components: Vec<Ceiling>,
    /// Diagonal of all that a viewer sees.
    whole: f64,
}

/// Allowed deformation of one component.
#[derive(Clone, Copy)]
pub struct Ceiling {
    pub allowed: f64,
    /// Largest scale at which the component is placed in the scene.
    pub stretch: f64,
}

impl Ceilings {
    pub fn new(component_of_vertex: Vec<u32>, components: Vec<Ceiling>, whole: f64) -> Self {
        let left = component_of_vertex.iter().map(|&c| components[c as usize].allowed as f32).collect();
        Self { left, component_of_vertex, components, whole }
    }

    /// Raises all lower ceilings to a share of the scene's diagonal; returns by how much, for each component.
    pub fn raise_to(&mut self, share: f64) -> Vec<f32> {
        let raise = |ceiling: &mut Ceiling| {
            let before = ceiling.allowed;
            ceiling.allowed = before.max(share * self.whole / ceiling.stretch);
            // Infinity stays: it cannot be raised.
            if before < f64::INFINITY { (ceiling.allowed - before) as f32 } else { 0.0 }
        };
        let by: Vec<f32> = self.components.iter_mut().map(raise).collect();
        self.left.iter_mut().zip(&self.component_of_vertex).for_each(|(left, &c)| *left += by[c as usize]);
        by
    }
}
