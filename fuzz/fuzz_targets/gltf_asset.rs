//! Arbitrary bytes as a glTF asset: an error, or an asset that survives writing and whose scene is a valid mesh.

#![no_main]

use neural_mesh::io::{Asset, Format, ReadError, SimplifiedPart};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::picture::SurfaceMaterials;

fn nothing(_: &str) -> Result<Vec<u8>, ReadError> {
    Err(ReadError::file("no files", "none"))
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let asset = match Asset::from_bytes(bytes, &nothing) {
        Ok(asset) => asset,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    match asset.write(&parts, Format::Glb, "a.glb") {
        Ok(files) => {
            // An emptied mesh keeps one face without area, unless it has other primitives.
            let n_drawn = parts.iter().filter(|part| !part.faces.is_empty()).count();
            let n_back = Asset::from_bytes(&files[0].bytes, &nothing).unwrap().parts().len();
            assert!((n_drawn..=parts.len()).contains(&n_back), "{n_drawn} <= {n_back} <= {}", parts.len());
        }
        Err(error) => assert!(!error.to_string().contains(['\n', '\r'])),
    }
    check_scene(&asset);
    match asset.poses() {
        Ok(poses) => {
            assert_eq!(poses.len(), asset.parts().len());
            for (channels, part) in poses.iter().zip(asset.parts()) {
                let n = 3 * part.mesh.attributes.n_wedges();
                assert!(channels.iter().all(|channel| channel.values.len() == n));
                assert!(channels.iter().flat_map(|channel| &channel.values).all(|x| x.is_finite()));
            }
        }
        Err(error) => assert!(!error.to_string().contains(['\n', '\r'])),
    }
});

fn check_scene(asset: &Asset) {
    let meshes: Vec<_> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
    let Ok(scene) = asset.scene_mesh(&meshes) else { return };
    let (looks, _) = asset.scene_looks();
    let Ok(Cleaned { mesh, attributes, .. }) = clean(scene, &CleanOptions::default()) else { return };
    assert!(attributes.groups.iter().all(|&group| (group as usize) < looks.of_groups.len()));
    assert!(attributes.is_valid_for(mesh.faces().len()));
    if let Some(cover) = SurfaceMaterials::new(&attributes, &looks) {
        for face in 0..mesh.faces().len() as u32 {
            let _ = (cover.texture(face), cover.corners(face));
        }
    }
}
