//! Assets with spoilt bytes or numbers give an error of one line, or can be written and opened again.

use neural_mesh::io::{Asset, Format};
use proptest::prelude::*;
use serde_json::Value;

use super::builder::{Builder, refuse_uri, reopen, unchanged_parts};
use super::{skinned_squares, two_materials};

fn check(bytes: &[u8]) {
    let asset = match Asset::from_bytes(bytes, &refuse_uri) {
        Ok(asset) => asset,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r']), "{error}"),
    };
    for format in [Format::Glb, Format::Gltf] {
        match asset.write(&unchanged_parts(&asset), format, "a.glb") {
            Ok(files) => assert_eq!(reopen(&files).parts().len(), asset.parts().len()),
            Err(error) => assert!(!error.to_string().contains(['\n', '\r']), "{error}"),
        }
    }
}

fn asset(which: usize) -> Builder {
    if which == 0 { skinned_squares() } else { two_materials() }
}

// Puts a value at the `at`-th value of a document.
fn spoil(value: &mut Value, at: &mut usize, with: &Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| spoil(value, at, with)),
        Value::Object(members) => members.values_mut().for_each(|value| spoil(value, at, with)),
        _ => {}
    }
    if *at == 0 {
        *value = with.clone();
    }
    *at = at.wrapping_sub(1);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn spoilt_bytes(which in 0usize..2, spots in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)) {
        let mut bytes = asset(which).glb();
        for (spot, byte) in spots {
            let at = spot.index(bytes.len());
            bytes[at] = byte;
        }
        check(&bytes);
    }

    #[cfg(feature = "meshopt")]
    #[test]
    fn spoilt_compression(spots in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(b"0123456789\x00\xff".to_vec())), 1..4)) {
        let mut bytes = super::compressed_asset("EXT_meshopt_compression");
        for (spot, byte) in spots {
            // Only the descriptions of the views and the compressed bytes are spoilt here; earlier bytes are spoilt
            // elsewhere.
            let at = bytes.len() / 3 + spot.index(bytes.len() - bytes.len() / 3);
            bytes[at] = byte;
        }
        check(&bytes);
    }

    #[test]
    fn spoilt_numbers(which in 0usize..2, at in 0usize..400, number in prop::sample::select(vec![0i64, 1, 2, 3, 5, 7, 255, 5121, 5123, 5125, 65_536, 1 << 40, -1]), word in any::<bool>()) {
        let mut asset = asset(which);
        let with = if word { Value::from("VEC4") } else { number.into() };
        spoil(&mut asset.document, &mut at.clone(), &with);
        if asset.document.is_object() {
            check(&asset.glb());
        }
    }
}
