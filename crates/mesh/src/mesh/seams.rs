//! Feature edges: seams, where attributes are discontinuous, and creases.

use glam::{Vec2, Vec3};

use super::half_edges::{HalfEdge, for_each_edge, next, start};
use super::{Attributes, Channel, Role, TriMesh};

/// Least angle between corner normals, in degrees, at a hard edge.
const HARD: f32 = 15.0;
const SAME: f32 = 1e-5;
const MOST_FACES: usize = 16;
const SAME_COLOUR: f32 = 1.0 / 64.0;

/// A seam edge and how it may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureEdge {
    /// Vertices, ascending.
    pub ends: [u32; 2],
    /// Distance, in the mesh's unit, within which merges may move the seam at a low price.
    pub slack: f32,
    /// True if stored normals on the two sides differ by at least 15 degrees.
    pub is_hard: bool,
}

/// Lists the edges, ascending, between faces of different groups or with different attributes along the edge.
///
/// Normals count as different from 15 degrees on, colours from 1/64; joints and morph targets never do. The slack is
/// above 0 only if nothing but texture coordinates and normals is discontinuous, and not between faces that each show a
/// single place of a texture, as of a palette. It is the distance at which the error
/// reaches `seam_error`: a share of the texture's side, or the normals' difference times the distance over the mesh's
/// diagonal.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{Attributes, TriMesh, seams};
/// let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriMesh::new(square, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
/// let attributes = Attributes { groups: vec![1, 2], ..Attributes::default() };
/// let seams = seams(&mesh, &attributes, 0.002);
/// assert_eq!((seams.len(), seams[0].ends, seams[0].slack), (1, [0, 2], 0.0));
/// ```
pub fn seams(mesh: &TriMesh, attributes: &Attributes, seam_error: f32) -> Vec<FeatureEdge> {
    let mut seams = Vec::new();
    if attributes.is_empty() {
        return seams;
    }
    let diagonal = mesh.diagonal() as f32;
    for_each_edge(mesh.positions().len(), mesh.faces(), |ends, half_edges| {
        let faces = &half_edges[..half_edges.len().min(MOST_FACES)];
        let join = |x: &HalfEdge, y: &HalfEdge| joins(mesh, attributes, [x.half_edge, y.half_edge], |_| true);
        if faces[1..].iter().all(|face| join(&faces[0], face)) {
            return;
        }
        // At an edge with more than two faces, those that join no other are the sides of a seam. A single such face is
        // at a boundary.
        let goes_on = |x: &HalfEdge| faces.iter().any(|y| x.half_edge != y.half_edge && join(x, y));
        let mut alone = faces.iter().filter(|face| !goes_on(face)).map(|face| face.half_edge);
        let Some(first) = alone.next() else { return };
        let seam = |other: u32| seam(mesh, attributes, [first, other], seam_error, diagonal);
        let worst = alone.map(seam).reduce(|x, y| (x.0.min(y.0), x.1 || y.1));
        seams.extend(worst.map(|(slack, is_hard)| FeatureEdge { ends, slack, is_hard }));
    });
    seams
}

fn seam(mesh: &TriMesh, attributes: &Attributes, pair: [u32; 2], seam_error: f32, diagonal: f32) -> (f32, bool) {
    let may_move = |role| is_texture(role) || role == Role::Normal;
    let is_soft = seam_error > 0.0 && joins(mesh, attributes, pair, |role| !may_move(role));
    let slack = if is_soft { slack(mesh, attributes, pair, seam_error, diagonal) } else { 0.0 };
    (slack, !carries_same(mesh, attributes, pair, |role| role == Role::Normal))
}

/// Lists the edges between two faces whose normals differ by more than `degrees`, ascending.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{creases, shapes};
/// assert_eq!(creases(&shapes::cuboid([1.0; 3], 4), 40.0).len(), 12 * 4);
/// ```
pub fn creases(mesh: &TriMesh, degrees: f32) -> Vec<[u32; 2]> {
    let least_cosine = degrees.to_radians().cos();
    let mut creases = Vec::new();
    for_each_edge(mesh.positions().len(), mesh.faces(), |ends, half_edges| {
        if let &[a, b] = half_edges {
            let [m, n] = [a, b].map(|half_edge| normal(mesh, half_edge.face()));
            let is_sharp = m.dot(n) < least_cosine * m.length() * n.length();
            creases.extend(is_sharp.then_some(ends));
        }
    });
    creases
}

fn normal(mesh: &TriMesh, face: u32) -> Vec3 {
    crate::geometry::triangle::area_normal(
        mesh.faces()[face as usize].map(|v| Vec3::from(mesh.positions()[v as usize])),
    )
}

fn is_texture(role: Role) -> bool {
    matches!(role, Role::Uv | Role::Tangent)
}

/// Returns how far the edge may move until its error, as defined at [`seams`], reaches `seam_error`.
fn slack(mesh: &TriMesh, attributes: &Attributes, half_edges: [u32; 2], seam_error: f32, diagonal: f32) -> f32 {
    let is_smooth = joins(mesh, attributes, half_edges, |role| role == Role::Normal);
    let of_normals = if is_smooth { f32::INFINITY } else { seam_error * diagonal / bend(mesh, attributes, half_edges) };
    let is_whole = joins(mesh, attributes, half_edges, is_texture);
    let of_texture = if is_whole { f32::INFINITY } else { slack_of_texture(mesh, attributes, half_edges, seam_error) };
    of_normals.min(of_texture).min(diagonal)
}

fn bend(mesh: &TriMesh, attributes: &Attributes, [first, second]: [u32; 2]) -> f32 {
    let channels = || attributes.channels.iter().filter(|channel| channel.role == Role::Normal);
    let normals = |corner: u32| channels().map(move |channel| channel.value(wedge(attributes, corner)));
    let at_end = |corner: u32| {
        let other = partner(mesh, corner, second);
        let apart =
            normals(corner).zip(normals(other)).map(|(m, n)| m.iter().zip(n).map(|(x, y)| (x - y).powi(2)).sum());
        apart.fold(0.0, |most: f32, squared: f32| most.max(squared.sqrt()))
    };
    at_end(first).max(at_end(next(first)))
}

fn slack_of_texture(mesh: &TriMesh, attributes: &Attributes, half_edges: [u32; 2], seam_error: f32) -> f32 {
    let ends = half_edges.map(|half_edge| [half_edge, next(half_edge)]);
    let mut on_texture = 0.0_f32;
    for channel in attributes.channels.iter().filter(|channel| channel.role == Role::Uv) {
        if separates_colours(attributes, channel, half_edges) {
            return 0.0;
        }
        let uv = |corner| match channel.value(wedge(attributes, corner)) {
            [u, v, ..] => Vec2::new(*u, *v),
            _ => Vec2::ZERO,
        };
        on_texture = ends.iter().fold(on_texture, |most, &[a, b]| most.max(uv(a).distance(uv(b))));
    }
    let [a, b] = ends[0].map(|corner| Vec3::from(mesh.positions()[start(mesh.faces(), corner) as usize]));
    let on_surface = a.distance(b);
    if on_texture > 0.0 { seam_error * on_surface / on_texture } else { on_surface }
}

/// Returns whether each of two faces shows one place of a texture, and not the same, as where it is a palette.
fn separates_colours(attributes: &Attributes, channel: &Channel, half_edges: [u32; 2]) -> bool {
    let [first, second] = half_edges.map(|half_edge| {
        let start = 3 * (half_edge / 3);
        [start, start + 1, start + 2].map(|corner| channel.value(wedge(attributes, corner)))
    });
    let are_same = |x: &[f32], y: &[f32]| same_values(Role::Uv, x, y);
    let shows_one = |[a, b, c]: [&[f32]; 3]| are_same(a, b) && are_same(a, c);
    shows_one(first) && shows_one(second) && !are_same(first[0], second[0])
}

fn joins(mesh: &TriMesh, attributes: &Attributes, pair: [u32; 2], counts: impl Fn(Role) -> bool) -> bool {
    attributes.group(pair[0] / 3) == attributes.group(pair[1] / 3) && carries_same(mesh, attributes, pair, counts)
}

fn carries_same(
    mesh: &TriMesh,
    attributes: &Attributes,
    [first, second]: [u32; 2],
    counts: impl Fn(Role) -> bool,
) -> bool {
    // Faces wound against each other have the opposite normals.
    let is_opposed = start(mesh.faces(), first) == start(mesh.faces(), second);
    let same_wedge = |corner: u32| {
        let other = partner(mesh, corner, second);
        has_same_values(attributes, wedge(attributes, corner), wedge(attributes, other), &counts, is_opposed)
    };
    [first, next(first)].into_iter().all(same_wedge)
}

/// Returns the corner at the vertex of `corner` in the face of `half_edge`.
fn partner(mesh: &TriMesh, corner: u32, half_edge: u32) -> u32 {
    let vertex = |corner: u32| start(mesh.faces(), corner);
    [half_edge, next(half_edge)].into_iter().find(|&other| vertex(other) == vertex(corner)).unwrap_or(corner)
}

fn wedge(attributes: &Attributes, corner: u32) -> u32 {
    attributes.wedges.as_flattened().get(corner as usize).copied().unwrap_or(0)
}

fn has_same_values(attributes: &Attributes, x: u32, y: u32, counts: &impl Fn(Role) -> bool, is_opposed: bool) -> bool {
    let same_in = |channel: &Channel| {
        let (role, x, y) = (channel.role, channel.value(x), channel.value(y));
        let turns = is_opposed && matches!(role, Role::Normal | Role::Tangent);
        let opposite = || y.iter().map(|y| -y).collect::<Vec<f32>>();
        !counts(role) || same_values(role, x, y) || turns && same_values(role, x, &opposite())
    };
    x == y || attributes.channels.iter().all(same_in)
}

#[doc(hidden)]
pub fn same_values(role: Role, x: &[f32], y: &[f32]) -> bool {
    let within = |most: &dyn Fn(f32, f32) -> f32| {
        x.iter().zip(y).all(|(&x, &y)| (x.is_nan() && y.is_nan()) || x == y || (x - y).abs() <= most(x, y))
    };
    match role {
        Role::Normal => {
            let dot: f32 = x.iter().zip(y).map(|(x, y)| x * y).sum();
            let squared = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>();
            let lengths = (squared(x) * squared(y)).sqrt();
            lengths == 0.0 || dot.is_nan() || dot >= HARD.to_radians().cos() * lengths
        }
        Role::Tangent => x.last().is_none_or(|sign| sign * y[y.len() - 1] >= 0.0),
        Role::Uv | Role::Other => within(&|x, y| SAME * x.abs().max(y.abs()).max(1.0)),
        Role::Colour => within(&|_, _| SAME_COLOUR),
        Role::Label => x == y,
        Role::Skin | Role::MorphPosition | Role::MorphDirection => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn paint_sphere(role: Role, value: impl Fn(Vec3, Vec3) -> Vec<f32>) -> (TriMesh, Attributes) {
        let mesh = shapes::icosphere(3);
        let corners = |face: &[u32; 3]| face.map(|v| Vec3::from(mesh.positions()[v as usize]));
        let values: Vec<Vec<f32>> = mesh
            .faces()
            .iter()
            .flat_map(|face| corners(face).map(|p| value(p, corners(face).iter().sum::<Vec3>() / 3.0)))
            .collect();
        let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let channel = Channel { name: "x".into(), role, width: values[0].len(), values: values.concat() };
        (mesh, Attributes { wedges, channels: vec![channel], groups: Vec::new() })
    }

    #[test]
    fn seams_at_non_manifold_edges_are_those_without_a_continuation() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -1.0, 0.0], [0.5, 0.0, 1.0]];
        let [left, right, front, back] = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 4]];
        let up = [0.0, 0.0, 1.0];
        let normals = |of: &[[f32; 3]]| {
            let values = of.iter().flat_map(|n| n.repeat(3)).collect();
            let channels = vec![Channel { name: "normal".into(), role: Role::Normal, width: 3, values }];
            let wedges = (0..of.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
            Attributes { wedges, channels, groups: Vec::new() }
        };
        let slabs = TriMesh::new(positions.clone(), vec![left, right, front, back]).unwrap();
        let found = seams(&slabs, &normals(&[up, up, [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]), 0.0);
        let middle = found.iter().find(|seam| seam.ends == [0, 1]).unwrap();
        assert!(middle.is_hard && middle.slack == 0.0);
        let stands = TriMesh::new(positions, vec![left, right, front]).unwrap();
        let found = seams(&stands, &normals(&[up, up, [0.0, -1.0, 0.0]]), 0.0);
        assert!(found.iter().all(|seam| seam.ends != [0, 1]));
    }

    #[test]
    fn normals_that_follow_opposed_windings_are_no_seam() {
        let (mesh, attributes) = paint_sphere(Role::Normal, |p, _| p.to_array().to_vec());
        let is_turned = |f: usize| f.is_multiple_of(3);
        let turn = |(f, &[a, b, c]): (usize, &[u32; 3])| if is_turned(f) { [a, c, b] } else { [a, b, c] };
        let faces = mesh.faces().iter().enumerate().map(turn).collect();
        let opposed = TriMesh::new(mesh.positions().to_vec(), faces).unwrap();
        // Wedges are numbered by corner, so those of a turned face are exchanged with its corners.
        let mut normals = attributes.channels[0].values.clone();
        for (_, values) in normals.chunks_exact_mut(9).enumerate().filter(|(f, _)| is_turned(*f)) {
            (3..6).for_each(|i| values.swap(i, i + 3));
        }
        let with = |values: Vec<f32>| Attributes {
            channels: vec![Channel { values, ..attributes.channels[0].clone() }],
            ..attributes.clone()
        };
        assert!(seams(&opposed, &with(normals.clone()), 0.0).is_empty());
        let following = normals.chunks_exact(9).enumerate().flat_map(|(f, values)| {
            let sign = if is_turned(f) { -1.0 } else { 1.0 };
            values.iter().map(move |x| sign * x)
        });
        let following: Vec<f32> = following.collect();
        assert!(seams(&opposed, &with(following.clone()), 0.0).is_empty());
        // Where the windings agree, opposite normals are a seam.
        assert!(!seams(&mesh, &with(following), 0.0).is_empty());
    }

    #[test]
    fn a_seam_runs_where_two_charts_meet() {
        let (mesh, attributes) = paint_sphere(Role::Uv, |p, centre| vec![p.x + f32::from(centre.z > 0.0), p.y]);
        let seams: Vec<[u32; 2]> = seams(&mesh, &attributes, 0.0).into_iter().map(|seam| seam.ends).collect();
        let is_up = |f: usize| mesh.faces()[f].iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
        let edges = crate::mesh::edges(&mesh);
        let between = edges.iter().filter(|edge| {
            let beside = |f: &usize| mesh.faces()[*f].iter().filter(|v| edge.ends.contains(v)).count() == 2;
            let mut faces = (0..mesh.faces().len()).filter(beside);
            is_up(faces.next().unwrap()) != is_up(faces.next().unwrap())
        });
        assert!(!seams.is_empty() && between.map(|edge| edge.ends).eq(seams));
    }

    #[test]
    fn edges_between_colours_of_a_palette_have_no_slack() {
        let side = |centre: Vec3| f32::from(centre.z > 0.0);
        let least_slack = |uv: &dyn Fn(Vec3, Vec3) -> Vec<f32>| {
            let (mesh, attributes) = paint_sphere(Role::Uv, uv);
            let seams = seams(&mesh, &attributes, 1.0 / 64.0);
            assert!(!seams.is_empty());
            seams.iter().map(|seam| seam.slack).fold(f32::INFINITY, f32::min)
        };
        assert_eq!(least_slack(&|_, centre| vec![0.25 + 0.5 * side(centre), 0.5]), 0.0);
        // Of two charts, one may be a single place.
        assert!(least_slack(&|p, centre| vec![p.x + side(centre), p.y]) > 0.0);
        assert!(least_slack(&|p, centre| vec![p.x * side(centre), p.y * side(centre)]) > 0.0);
    }

    #[test]
    fn equal_values_in_other_wedges_are_no_seam() {
        for role in [Role::Uv, Role::Colour, Role::Other, Role::Skin, Role::Tangent] {
            let (mesh, attributes) = paint_sphere(role, |p, _| vec![p.x, f32::NAN, p.y, 1.0]);
            assert!(seams(&mesh, &attributes, 0.0).is_empty(), "{role:?}");
        }
    }

    #[test]
    fn facets_are_smooth_and_a_hard_edge_is_none() {
        let (mesh, facets) = paint_sphere(Role::Normal, |_, centre| centre.normalize().to_array().to_vec());
        assert!(seams(&mesh, &facets, 0.0).is_empty());
        let (mesh, halves) =
            paint_sphere(Role::Normal, |_, centre| vec![0.0, 0.0, if centre.z > 0.0 { 1.0 } else { -1.0 }]);
        let between_halves = seams(&mesh, &halves, 0.0);
        assert!(!between_halves.is_empty() && between_halves.iter().all(|seam| seam.is_hard));
        let (mesh, charts) = paint_sphere(Role::Uv, |_, centre| vec![f32::from(centre.z > 0.0), 0.0]);
        assert!(seams(&mesh, &charts, 0.0).iter().all(|seam| !seam.is_hard));
    }
}
