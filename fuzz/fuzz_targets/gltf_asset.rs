//! Any bytes as a glTF asset: written as it is, it opens again with as many parts; or one line.

#![no_main]

use neural_mesh::io::{Asset, Format, LighterPart, Place, ReadError};

fn nothing(_: &str) -> Result<Vec<u8>, ReadError> {
    Err(ReadError { format: None, place: Place::File, what: "no files".into(), remedy: "none".into() })
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let asset = match Asset::from_bytes(bytes, &nothing) {
        Ok(asset) => asset,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    let parts: Vec<LighterPart> = asset.parts().iter().map(LighterPart::of).collect();
    match asset.write(&parts, Format::Glb, "a.glb") {
        Ok(files) => assert_eq!(Asset::from_bytes(&files[0].bytes, &nothing).unwrap().parts().len(), parts.len()),
        Err(error) => assert!(!error.to_string().contains(['\n', '\r'])),
    }
});
