//! Arbitrary bytes as a hierarchy of clusters: an error, or a hierarchy that is written and read again.

#![no_main]

use neural_mesh::clusters::Clusters;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let clusters = match Clusters::from_bytes(bytes) {
        Ok(clusters) => clusters,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    let all: Vec<u32> = (0..clusters.clusters.len() as u32).collect();
    for cut in [clusters.roots(), clusters.cut_at_error(0.0), clusters.cut_at_error(f64::NAN), all] {
        clusters.mesh_of(&cut);
    }
    let again = Clusters::from_bytes(&clusters.to_bytes()).unwrap();
    assert_eq!(again.clusters.len(), clusters.clusters.len());
});
