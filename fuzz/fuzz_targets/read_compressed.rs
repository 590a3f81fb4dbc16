//! Arbitrary bytes as a compressed buffer view of a glTF: the first four choose its mode, filter, stride and count.

#![no_main]

use neural_mesh::io::{Asset, ReadError};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&[mode, filter, stride, count], data)) = bytes.split_first_chunk() else { return };
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(mode % 3)];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][usize::from(filter % 5)];
    let (stride, count) = (2 * usize::from(stride), 3 * usize::from(count));
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {}, "uri": "a.bin"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {}, "extensions": {{"EXT_meshopt_compression": {{"buffer": 0, "byteLength": {},
        "byteStride": {stride}, "count": {count}, "mode": "{mode}", "filter": "{filter}"}}}}}}]}}"#,
        data.len(),
        stride * count,
        data.len(),
    );
    if let Err(ReadError { what, .. }) = Asset::from_bytes(text.as_bytes(), &|_| Ok(data.to_vec())) {
        assert!(!what.contains(['\n', '\r']));
    }
});
