//! Textures that store the look of the original for a simplified surface.
//!
//! ```text
//! unfold              charts of the simplified surface on a square (xatlas)
//! frames              its normals and tangents (MikkTSpace)
//! raster              texels of the charts, and their points on the surface
//! fine                the point of the original for each: along the normal, else the nearest
//! original_materials  the original's materials there
//! dilate              texels beyond the borders of charts
//! maps                textures from the texels, or factors for uniform values
//! ```
//!
//! The result does not depend on the number of threads. Opacity is not baked.

mod dilate;
mod fine;
mod frames;
mod maps;
mod original_materials;
mod raster;
mod request;
mod texel;
mod unfold;

use crate::mesh::{Attributes, Look, TriMesh};
use fine::FineSurface;
use frames::Frames;
use unfold::Charts;

pub use request::{BakeError, BakeOptions, BakeSource, SIZES};

/// Attributes and material for a simplified mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakedMesh {
    /// Texture coordinates (v upwards), normals, and tangents on request.
    pub attributes: Attributes,
    /// Material.
    pub look: Look,
    /// Number of charts.
    pub n_charts: usize,
    /// Share of the texels inside charts.
    pub covered: f64,
    /// Messages on lost content, one line each.
    pub notes: Vec<String>,
}

/// Bakes the look and shape of an original into textures for a simplified mesh.
///
/// # Errors
/// [`BakeError`] names the obstacle in one line.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::bake::{BakeOptions, BakeSource, bake};
/// use neural_mesh::mesh::{Attributes, Look, Looks, shapes};
/// let (fine, coarse) = (shapes::icosphere(4), shapes::icosphere(1));
/// let mut red = Look::default();
/// red.colour = [1.0, 0.0, 0.0];
/// let looks = Looks::new(vec![red]);
/// let original = BakeSource::new(&fine, Attributes::NONE, &looks);
/// let baked = bake(&original, &coarse, &BakeOptions::new(64)).unwrap();
/// assert_eq!((baked.look.colour, baked.look.texture), ([1.0, 0.0, 0.0], None));
/// assert!(baked.look.finish.normal_texture.is_some() && baked.covered > 0.3);
/// ```
pub fn bake(original: &BakeSource, mesh: &TriMesh, options: &BakeOptions) -> Result<BakedMesh, BakeError> {
    let size = options.size;
    if !SIZES.contains(&size) {
        return Err(BakeError::BadSize(size));
    }
    // This is checked before unfolding, which is slow.
    if original.mesh.faces().is_empty() {
        return Err(BakeError::Empty);
    }
    let charts = Charts::unfold(mesh, size)?;
    let frames = Frames::new(mesh, &charts);
    let (fine, notes) = FineSurface::new(original, mesh);
    let mut texels = raster::draw_texels(mesh, &charts, &frames, &fine);
    let n_inside = texels.iter().filter(|texel| texel.place == texel::TexelPlace::Inside).count();
    let covered = n_inside as f64 / texels.len() as f64;
    dilate::dilate(&mut texels, size);
    let look = maps::look(&texels, original.looks, options);
    let attributes = frames.attributes(&charts, options.with_tangents);
    Ok(BakedMesh { attributes, look, n_charts: charts.n_charts, covered, notes })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec3, Vec4};

    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use crate::mesh::{BaseTexture, Channel, Finish, Looks, Role, Wrap, linear_light, shapes};
    use crate::picture::{DecodedMaterials, Image, decode_image, encode_png};

    const OPTIONS: BakeOptions = BakeOptions { size: 128, separate_maps: false, with_tangents: true };

    fn sheet(n: usize, height: impl Fn(f32, f32) -> f32) -> TriMesh {
        let place = |i: usize| [i % (n + 1), i / (n + 1)].map(|x| x as f32 / n as f32);
        let point = |i: usize| {
            let [x, y] = place(i);
            [x, y, height(x, y)]
        };
        let square = |i: usize| {
            let low = (i % n + (i / n) * (n + 1)) as u32;
            let high = low + n as u32 + 1;
            [[low, low + 1, high + 1], [low, high + 1, high]]
        };
        let faces = (0..n * n).flat_map(square).collect();
        TriMesh::new((0..(n + 1) * (n + 1)).map(point).collect(), faces).unwrap()
    }

    fn of_vertices(mesh: &TriMesh, role: Role, width: usize, value: impl Fn([f32; 3]) -> Vec<f32>) -> Attributes {
        let values = mesh.positions().iter().flat_map(|&p| value(p)).collect();
        let channels = vec![Channel { name: "x".into(), role, width, values }];
        Attributes { wedges: mesh.faces().to_vec(), channels, groups: Vec::new() }
    }

    fn uvs(mesh: &TriMesh) -> Attributes {
        of_vertices(mesh, Role::Uv, 2, |[x, y, _]| vec![x, y])
    }

    fn looks(look: Look) -> Looks {
        Looks { of_groups: vec![look], v_is_up: true, linear_colours: false }
    }

    fn texture(size: usize, pixel: impl Fn(f32, f32) -> [u8; 3]) -> Option<BaseTexture> {
        let rgba = (0..size * size).flat_map(|i| {
            let [x, y] = [i % size, size - 1 - i / size].map(|x| (x as f32 + 0.5) / size as f32);
            let [r, g, b] = pixel(x, y);
            [r, g, b, 255]
        });
        let image = Image { width: size, height: size, rgba: rgba.collect() };
        Some(BaseTexture { image: encode_png(&image).into(), channel: String::new(), wrap: [Wrap::Clamp; 2] })
    }

    fn places(mesh: &TriMesh) -> impl Iterator<Item = (u32, [f32; 3], Vec3)> {
        let weights = [[0.4, 0.3, 0.3], [0.1, 0.2, 0.7], [0.8, 0.1, 0.1]];
        let all = (0..mesh.faces().len() as u32).flat_map(move |face| weights.map(|weights| (face, weights)));
        all.map(move |(face, weights)| {
            let corners = mesh.faces()[face as usize].map(|v| Vec3::from(mesh.positions()[v as usize]));
            (face, weights, corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2])
        })
    }

    const NO_STEPS: [[f32; 3]; 2] = [[0.0; 3]; 2];

    fn seen_normals(mesh: &TriMesh, baked: &BakedMesh) -> Vec<(Vec3, Vec3)> {
        let map = baked.look.finish.normal_texture.clone();
        let materials =
            DecodedMaterials::of_numbers(&baked.attributes, &looks(Look { texture: map, ..Look::default() }))
                .0
                .unwrap();
        let [normals, tangents] = [1, 2].map(|i| &baked.attributes.channels[i]);
        let normal = |(face, weights, at): (u32, [f32; 3], Vec3)| {
            let wedges = baked.attributes.wedges[face as usize];
            let term = |i: usize| Vec3::from_slice(normals.value(wedges[i])) * weights[i];
            let normal = term(0) + term(1) + term(2);
            let term = |i: usize| Vec4::from_slice(tangents.value(wedges[i])) * weights[i];
            let tangent = term(0) + term(1) + term(2);
            let across = tangent.w.signum() * normal.cross(tangent.truncate());
            let [x, y, z] = materials.value(face, weights, NO_STEPS).map(|x| 2.0 * x - 1.0);
            ((tangent.truncate() * x + across * y + normal * z).normalize(), at)
        };
        places(mesh).map(normal).collect()
    }

    fn bake_all(mesh: &TriMesh, attributes: &Attributes, look: Look, onto: &TriMesh) -> BakedMesh {
        bake(&BakeSource { mesh, attributes, looks: &looks(look) }, onto, &OPTIONS).unwrap()
    }

    #[test]
    fn a_coloured_sheet_baked_on_itself_keeps_its_colours() {
        let mesh = sheet(4, |_, _| 0.0);
        let colours = of_vertices(&mesh, Role::Colour, 3, |[x, y, _]| vec![x, y, 0.5]);
        let painted = texture(64, |x, y| [(255.0 * y) as u8, 90, (255.0 * x) as u8]);
        for (attributes, texture) in [(colours, None), (uvs(&mesh), painted)] {
            let look = Look { texture, colour: [1.0, 0.5, 0.25], ..Look::default() };
            let baked = bake_all(&mesh, &attributes, look.clone(), &mesh);
            assert_eq!((baked.n_charts, baked.look.finish.normal_texture.is_some()), (1, false));
            let before = DecodedMaterials::new(&attributes, &looks(look)).0.unwrap();
            let after = DecodedMaterials::new(&baked.attributes, &looks(baked.look)).0.unwrap();
            for (face, weights, _) in places(&mesh) {
                let [before, after] =
                    [&before, &after].map(|materials| Vec3::from(materials.value(face, weights, NO_STEPS)));
                assert!((before - after).abs().max_element() < 0.02, "{face} {weights:?}: {before} {after}");
            }
        }
    }

    #[test]
    fn bumps_become_a_normal_map_with_the_normals_of_the_fine_surface() {
        let height = |x: f32, y: f32| 0.02 * (9.0 * x).sin() * (7.0 * y).cos();
        let (fine, coarse) = (sheet(100, height), sheet(1, |_, _| 0.0));
        let baked = bake_all(&fine, &Attributes::default(), Look::default(), &coarse);
        for (normal, at) in seen_normals(&coarse, &baked) {
            let slopes =
                [0.18 * (9.0 * at.x).cos() * (7.0 * at.y).cos(), -0.14 * (9.0 * at.x).sin() * (7.0 * at.y).sin()];
            let wanted = Vec3::new(-slopes[0], -slopes[1], 1.0).normalize();
            assert!(normal.angle_between(wanted) < 0.03, "{at}: {normal} {wanted}");
        }
    }

    #[test]
    fn a_coarse_ball_is_as_round_as_the_fine_one() {
        let (fine, coarse) = (shapes::icosphere(5), shapes::icosphere(1));
        let baked = bake_all(&fine, &Attributes::default(), Look::default(), &coarse);
        let angles = seen_normals(&coarse, &baked).into_iter().map(|(normal, at)| normal.angle_between(at));
        let largest = angles.fold(0.0, f32::max);
        assert!(largest < 0.05, "{largest}");
    }

    #[test]
    fn a_normal_map_of_the_original_is_taken_along() {
        let mesh = sheet(3, |_, _| 0.0);
        let map = texture(64, |x, _| if x < 0.5 { [228, 128, 207] } else { [128, 228, 207] });
        let finish = Finish { normal_texture: map, normal_scale: 1.0, ..Finish::default() };
        let baked = bake_all(&mesh, &uvs(&mesh), Look { finish, ..Look::default() }, &mesh);
        for (normal, at) in seen_normals(&mesh, &baked).iter().filter(|(_, at)| (at.x - 0.5).abs() > 0.05) {
            let wanted = if at.x < 0.5 { Vec3::new(0.79, 0.0, 0.62) } else { Vec3::new(0.0, 0.79, 0.62) };
            assert!(normal.angle_between(wanted) < 0.05, "{at}: {normal}");
        }
    }

    #[test]
    fn what_a_material_does_with_light_is_baked_or_stays_a_factor() {
        let mesh = sheet(2, |_, _| 0.0);
        let finish = Finish { emission: [0.25, 0.5, 0.0], roughness: 0.7, metal: 0.3, ..Finish::default() };
        let look = Look { colour: [0.3, 0.6, 0.9], finish, ..Look::default() };
        let plain = bake_all(&mesh, &uvs(&mesh), look.clone(), &mesh).look;
        assert_eq!(plain, Look { uses_corner_colours: false, ..look.clone() });
        let (rough, glow) =
            (texture(32, |x, _| [9, (255.0 * x) as u8, 51]), texture(32, |_, y| [(255.0 * y) as u8; 3]));
        let metal_texture = rough.clone();
        let finish = Finish { roughness_texture: rough, metal_texture, emission_texture: glow, ..look.finish };
        let look = Look { finish, ..look };
        let original = BakeSource { mesh: &mesh, attributes: &uvs(&mesh), looks: &looks(look) };
        let packed = bake(&original, &mesh, &OPTIONS).unwrap();
        let Finish { roughness_texture, metal_texture, emission_texture, .. } = packed.look.finish;
        assert!(roughness_texture == metal_texture && packed.look.colour == [0.3, 0.6, 0.9]);
        let value = |texture: Option<BaseTexture>, numbers: bool| {
            let make = if numbers { DecodedMaterials::of_numbers } else { DecodedMaterials::new };
            let materials = make(&packed.attributes, &looks(Look { texture, ..Look::default() })).0.unwrap();
            places(&mesh).map(move |(face, weights, at)| (Vec3::from(materials.value(face, weights, NO_STEPS)), at))
        };
        for (value, at) in value(roughness_texture, true) {
            assert!((value.y - 0.7 * at.x).abs() < 0.02 && (value.z - 0.3 * 0.2).abs() < 0.01, "{value} {at}");
        }
        for (value, at) in value(emission_texture, false) {
            let wanted = linear_light(at.y) * Vec3::new(0.25, 0.5, 0.0);
            assert!((value - wanted).abs().max_element() < 0.02, "{value} {wanted}");
        }
        let apart = bake(&original, &mesh, &BakeOptions { separate_maps: true, ..OPTIONS }).unwrap().look.finish;
        assert!(apart.roughness_texture.is_some() && apart.metal_texture.is_none());
        assert!((apart.metal - 0.06).abs() < 0.003 && apart.roughness == 1.0, "{}", apart.metal);
    }

    #[test]
    fn an_original_wound_the_other_way_is_found_too() {
        let fine = sheet(20, |x, y| 0.01 * (x - y));
        let turned = fine.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let turned = TriMesh::new(fine.positions().to_vec(), turned).unwrap();
        let colours = of_vertices(&turned, Role::Colour, 3, |[x, ..]| vec![x; 3]);
        let baked = bake_all(&turned, &colours, Look::default(), &sheet(1, |_, _| 0.0));
        assert!(seen_normals(&sheet(1, |_, _| 0.0), &baked).iter().all(|(normal, _)| normal.z > 0.99));
        assert!(baked.look.texture.is_some());
    }

    #[test]
    fn two_sheets_that_nearly_touch_get_their_own_texels() {
        let sides = |n: usize, gap: f32| {
            let (up, down) = (sheet(n, |_, _| gap), sheet(n, |_, _| -gap));
            let shift = up.positions().len() as u32;
            let turned = down.faces().iter().map(|&[a, b, c]| [a + shift, c + shift, b + shift]);
            TriMesh::new(
                [up.positions(), down.positions()].concat(),
                up.faces().iter().copied().chain(turned).collect(),
            )
        };
        let (fine, coarse) = (sides(8, 0.001).unwrap(), sides(1, 0.003).unwrap());
        let colours = of_vertices(&fine, Role::Colour, 3, |p| vec![if p[2] > 0.0 { 1.0 } else { 0.0 }; 3]);
        let baked = bake_all(&fine, &colours, Look::default(), &coarse);
        let materials = DecodedMaterials::new(&baked.attributes, &looks(baked.look)).0.unwrap();
        for (face, weights, at) in places(&coarse) {
            let found = materials.value(face, weights, NO_STEPS)[0];
            assert_eq!(found, if at.z > 0.0 { 1.0 } else { 0.0 }, "{face} {at}");
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bytes() {
        let (fine, coarse) = (shapes::wavy_sphere(4, 20.0), shapes::wavy_sphere(2, 20.0));
        let colours = of_vertices(&fine, Role::Colour, 3, |p| p.map(f32::abs).to_vec());
        let baked = |n| run_on_threads(n, || bake_all(&fine, &colours, Look::default(), &coarse));
        let one = baked(1);
        assert_eq!(one, baked(3));
        let image = decode_image(&one.look.texture.unwrap().image).unwrap();
        assert_eq!((image.width, image.height), (128, 128));
        assert!(one.covered > 0.3 && one.n_charts > 1, "{} {}", one.covered, one.n_charts);
    }

    #[test]
    fn what_cannot_be_baked_is_said() {
        let mesh = sheet(1, |_, _| 0.0);
        let try_bake = |mesh: &TriMesh, onto: &TriMesh, size| {
            let original = BakeSource { mesh, attributes: Attributes::NONE, looks: &Looks::default() };
            bake(&original, onto, &BakeOptions { size, ..OPTIONS }).map(|_| ())
        };
        for size in [0, 15, 8193] {
            assert_eq!(try_bake(&mesh, &mesh, size), Err(BakeError::BadSize(size)));
        }
        let line = TriMesh::new(vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]).unwrap();
        assert_eq!(try_bake(&mesh, &line, 64), Err(BakeError::Empty));
        assert_eq!(try_bake(&TriMesh::default(), &mesh, 64), Err(BakeError::Empty));
        assert_eq!(try_bake(&line, &mesh, 64), Ok(()));
        let crumbs = (0..300).flat_map(|i| [[i as f32; 3], [i as f32 + 0.1, i as f32, 0.0], [i as f32, 1.0, i as f32]]);
        let faces = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let crumbs = TriMesh::new(crumbs.collect(), faces).unwrap();
        assert_eq!(try_bake(&crumbs, &crumbs, 16), Err(BakeError::NoRoom(16)));
        let no_image = BaseTexture { image: Arc::from(&b"x"[..]), channel: String::new(), wrap: [Wrap::Clamp; 2] };
        let finish = Finish { is_opaque: false, ..Finish::default() };
        let look = Look { texture: Some(no_image), finish, ..Look::default() };
        let baked = bake_all(&mesh, &uvs(&mesh), look, &mesh);
        assert_eq!(baked.notes.len(), 2, "{:?}", baked.notes);
    }
}
