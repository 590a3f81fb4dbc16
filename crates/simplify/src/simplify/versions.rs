//! Versions of the assemblies' results.

/// Version of the closed assembly; changes whenever a result has other bits.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// assert!(neural_mesh::simplify::CLOSED_VERSION >= 1);
/// ```
pub const CLOSED_VERSION: u32 = 19;

/// Version of the closed assembly with constraints or attributes; changes whenever such a result has other bits.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// assert!(neural_mesh::simplify::CARRIED_VERSION >= 1);
/// ```
pub const CARRIED_VERSION: u32 = 21;

/// Version of the paper's assembly.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// assert!(neural_mesh::simplify::PAPER_VERSION >= 1);
/// ```
pub const PAPER_VERSION: u32 = 2;

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::linalg::golden::{GoldenCheck, Hash, Results, check};
    use crate::mesh::{Attributes, Channel, Role, TriMesh, shapes, vertex_normals, with_flat_normals};
    use crate::simplify::{
        ClosedOptions, Effort, Input, Options, PaperOptions, Purpose, ScoreSource, Simplified, Size, simplify,
        simplify_levels_of_detail, simplify_recorded,
    };

    #[test]
    fn the_closed_assembly_keeps_its_bits() {
        let test = concat!(module_path!(), "::the_closed_assembly_keeps_its_bits");
        check(&golden_check("closed", CLOSED_VERSION, "CLOSED_VERSION", test), closed_results);
    }

    #[test]
    fn attributes_and_maps_keep_their_bits() {
        let test = concat!(module_path!(), "::attributes_and_maps_keep_their_bits");
        check(&golden_check("carried", CARRIED_VERSION, "CARRIED_VERSION", test), carried_results);
    }

    #[test]
    fn the_papers_assembly_keeps_its_bits() {
        let test = concat!(module_path!(), "::the_papers_assembly_keeps_its_bits");
        check(&golden_check("paper", PAPER_VERSION, "PAPER_VERSION", test), paper_results);
    }

    fn golden_check(part: &'static str, version: u32, constant: &'static str, test: &'static str) -> GoldenCheck {
        let test = test.split_once("::").unwrap().1;
        GoldenCheck { part, version, constant, test }
    }

    fn closed_results() -> Results {
        let mut results = Vec::new();
        for (name, mesh) in shapes_and_files() {
            for ratio in [0.05, 0.2, 0.5] {
                let target = Size::Ratio(ratio);
                results.push((format!("{name} at {ratio}"), hash_of(&mesh, &Options::new(target))));
                let geometry = ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() };
                let geometry = Options::with_closed(target, geometry);
                results.push((format!("{name} at {ratio} by geometry"), hash_of(&mesh, &geometry)));
            }
        }
        results.extend(with_options());
        results.push(("levels of detail".into(), hash_levels()));
        results.push(("derivative".into(), hash_derivative()));
        results
    }

    fn with_options() -> Results {
        let plain = ClosedOptions::default();
        let fast = ClosedOptions { effort: Effort::Fast, ..plain.clone() };
        let cases = [
            ("fast", shapes::wavy_sphere(5, 8.0), fast.clone()),
            ("fast open", shapes::grid(60, 60), fast.clone()),
            ("fast components", shapes::chain_of_tori(3), fast.clone()),
            ("fast subset", shapes::wavy_sphere(4, 8.0), ClosedOptions { subset: true, ..fast }),
            ("subset", shapes::wavy_sphere(4, 8.0), ClosedOptions { subset: true, ..plain.clone() }),
            ("poses unknown", shapes::wavy_sphere(4, 8.0), ClosedOptions { purpose: Purpose::Poses, ..plain }),
        ];
        let hash = |mesh, options| hash_of(&mesh, &Options::with_closed(Size::Ratio(0.2), options));
        cases.into_iter().map(|(name, mesh, options)| (name.into(), hash(mesh, options))).collect()
    }

    fn carried_results() -> Results {
        let creases = ClosedOptions { crease_angle: Some(30.0), ..ClosedOptions::default() };
        let locked = ClosedOptions { lock_boundaries: true, ..ClosedOptions::default() };
        let fast = ClosedOptions { effort: Effort::Fast, ..locked.clone() };
        let [creases, locked, fast] =
            [creases, locked, fast].map(|options| Options::with_closed(Size::Ratio(0.2), options));
        vec![
            ("creases kept".into(), hash_of(&shapes::bolt(24), &creases)),
            ("boundary locked".into(), hash_of(&shapes::grid(30, 20), &locked)),
            ("boundary locked fast".into(), hash_of(&shapes::grid(60, 40), &fast)),
            ("attributes".into(), hash_attributes()),
            ("charts".into(), hash_charts()),
            ("hard edges".into(), hash_hard_edges()),
            ("poses".into(), hash_poses()),
            ("normals".into(), hash_normals()),
        ]
    }

    fn paper_results() -> Results {
        let mut results = Vec::new();
        for (name, mesh) in shapes_and_files().into_iter().filter(|(_, mesh)| mesh.positions().len() < 5000) {
            for ratio in [0.1, 0.3] {
                let options = Options::with_paper(Size::Ratio(ratio), PaperOptions::default());
                results.push((format!("{name} at {ratio}"), hash_of(&mesh, &options)));
            }
        }
        results
    }

    fn shapes_and_files() -> Vec<(&'static str, TriMesh)> {
        let shapes = [
            ("sphere", shapes::icosphere(4)),
            ("wavy sphere", shapes::wavy_sphere(4, 8.0)),
            ("torus", shapes::torus(60, 30, 2.0, 0.5)),
            ("bolt", shapes::bolt(32)),
            ("sheet", shapes::grid(30, 30)),
            ("strip", shapes::moebius_strip(60, 9)),
            ("chain", shapes::chain_of_tori(3)),
        ];
        shapes.into_iter().chain(files()).collect()
    }

    fn files() -> Vec<(&'static str, TriMesh)> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/meshes/");
        let read = |name: &'static str| {
            let raw = crate::io::read_path(format!("{folder}{name}.ply").as_ref(), None).unwrap();
            (name, crate::mesh::cleanup::clean(raw, &Default::default()).unwrap().mesh)
        };
        ["nefertiti", "spot", "suzanne"].map(read).into()
    }

    fn hash_of(mesh: &TriMesh, options: &Options) -> u64 {
        let result = simplify(mesh, options, &mut |_| ControlFlow::Continue(())).unwrap();
        hash(&result).value()
    }

    fn hash(result: &Simplified) -> Hash {
        let Simplified { mesh, attributes, .. } = result;
        let hash = Hash::new().floats(mesh.positions().as_flattened()).indices(mesh.faces().as_flattened());
        let hash = hash.indices(attributes.wedges.as_flattened()).indices(&attributes.groups);
        attributes.channels.iter().fold(hash, |hash, channel| hash.floats(&channel.values))
    }

    fn hash_attributes() -> u64 {
        let mesh = shapes::icosphere(4);
        let is_north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
        let n = mesh.positions().len() as u32;
        let groups: Vec<u32> = mesh.faces().iter().map(|face| u32::from(is_north(face))).collect();
        let wedges = mesh.faces().iter().zip(&groups).map(|(face, group)| face.map(|v| v + n * group)).collect();
        let corners = || (0..2).flat_map(|group| mesh.positions().iter().map(move |p| (group as f32, *p)));
        let uvs = corners().flat_map(|(group, [x, y, _])| [0.25 * x + 0.5 * group, 0.25 * y]).collect();
        let colours = corners().flat_map(|(_, [x, y, z])| [x * x, 0.5 + 0.5 * y, (3.0 * z).abs().min(1.0)]).collect();
        let channels = vec![
            Channel { name: "uv".into(), role: Role::Uv, width: 2, values: uvs },
            Channel { name: "colour".into(), role: Role::Colour, width: 3, values: colours },
        ];
        let attributes = Attributes { groups, wedges, channels };
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = Options::new(Size::Vertices(200));
        hash(&simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()).value()
    }

    fn hash_charts() -> u64 {
        let mesh = shapes::torus(60, 30, 2.0, 0.5);
        let quarter = |face: &[u32; 3]| {
            let sum = |axis: usize| face.iter().map(|&v| mesh.positions()[v as usize][axis]).sum::<f32>();
            f32::from(sum(0) > 0.0) + 2.0 * f32::from(sum(1) > 0.0)
        };
        let uv = |face: &[u32; 3], v: u32| {
            let [x, y, z] = mesh.positions()[v as usize];
            [0.1 * (x + z) + quarter(face), 0.1 * (y - z)]
        };
        let corners = mesh.faces().iter().flat_map(|face| face.map(|v| uv(face, v)));
        let values = corners.flatten().collect();
        let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
        let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let attributes = Attributes { groups: Vec::new(), wedges, channels };
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = Options::new(Size::Vertices(150));
        hash(&simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()).value()
    }

    fn hash_hard_edges() -> u64 {
        let mesh = shapes::bolt(24);
        let attributes = with_flat_normals(&mesh, &Attributes::default(), "normal");
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = Options::new(Size::Ratio(0.2));
        hash(&simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()).value()
    }

    fn hash_normals() -> u64 {
        let mesh = shapes::torus(60, 30, 2.0, 0.5);
        let normals = vertex_normals(&mesh);
        let n = mesh.positions().len() as u32;
        let is_north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
        let wedges = mesh.faces().iter().map(|face| face.map(|v| v + n * u32::from(is_north(face)))).collect();
        let rows = || (0..2 * n as usize).map(|row| (row / n as usize, row % n as usize));
        let uvs = rows()
            .flat_map(|(chart, v)| [mesh.positions()[v][0], mesh.positions()[v][1] + 9.0 * chart as f32])
            .collect();
        let normals_of_rows = rows().flat_map(|(_, v)| normals[v]).collect();
        let tangents = rows().flat_map(|(_, v)| [-normals[v][1], normals[v][0], 0.0, 1.0]).collect();
        let channels = vec![
            Channel { name: "uv".into(), role: Role::Uv, width: 2, values: uvs },
            Channel { name: "normal".into(), role: Role::Normal, width: 3, values: normals_of_rows },
            Channel { name: "tangent".into(), role: Role::Tangent, width: 4, values: tangents },
        ];
        let attributes = Attributes { groups: Vec::new(), wedges, channels };
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = Options::new(Size::Vertices(150));
        hash(&simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()).value()
    }

    fn hash_poses() -> u64 {
        let mesh = shapes::grid(30, 20);
        let step = |&[x, _, _]: &[f32; 3]| [0.3 * (5.0 * x).sin() - x, 0.0, 0.3 - 0.3 * (5.0 * x).cos()];
        let values = mesh.positions().iter().flat_map(step).collect();
        let target = Channel { name: "TARGET_0/POSITION".into(), role: Role::MorphPosition, width: 3, values };
        let attributes = Attributes { groups: Vec::new(), wedges: mesh.faces().to_vec(), channels: vec![target] };
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let poses = ClosedOptions { purpose: Purpose::Poses, ..ClosedOptions::default() };
        let options = Options::with_closed(Size::Ratio(0.2), poses);
        hash(&simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()).value()
    }

    fn hash_levels() -> u64 {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let sizes = [Size::Ratio(0.5), Size::Ratio(0.25), Size::Vertices(100)];
        let options = ClosedOptions::default();
        let go_on = &mut |_| ControlFlow::Continue(());
        let levels = simplify_levels_of_detail(&mesh, &options, &sizes, go_on).unwrap();
        levels.iter().fold(Hash::new(), |all, level| all.bytes(&hash(level).value().to_le_bytes())).value()
    }

    fn hash_derivative() -> u64 {
        let mesh = shapes::wavy_sphere(3, 8.0);
        let go_on = &mut |_| ControlFlow::Continue(());
        let (result, record) = simplify_recorded(&mesh, &Options::new(Size::Vertices(100)), go_on).unwrap();
        let gradient: Vec<[f32; 3]> = (0..result.mesh.positions().len()).map(|v| [v as f32, 1.0, -0.5]).collect();
        hash(&result).floats(record.backward(mesh.positions(), &gradient).as_flattened()).value()
    }
}
