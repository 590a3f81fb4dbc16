//! Compiles xatlas and the functions that Rust calls.

fn main() {
    let files = ["src/shim.cpp", "vendor/xatlas.cpp"];
    // C++ 14: without threads it needs aggregates with initialisers. One thread: the caller decides how many there are, and charts come out the same.
    cc::Build::new()
        .cpp(true)
        .std("c++14")
        .include("vendor")
        .define("NDEBUG", None)
        .define("XA_MULTITHREADED", "0")
        .opt_level(2)
        .warnings(false)
        .files(files)
        .compile("neural_mesh_xatlas");
    println!("cargo::rerun-if-changed=src/shim.cpp");
    println!("cargo::rerun-if-changed=vendor");
}
