//! Compiles the C part of the interface, which Rust cannot express.

fn main() {
    println!("cargo:rerun-if-changed=src/shim.c");
    println!("cargo:rerun-if-changed=include");
    cc::Build::new()
        .file("src/shim.c")
        .include("include")
        .define("RTAPI", None)
        .define("_GNU_SOURCE", None)
        .std("gnu11")
        .warnings(true)
        .extra_warnings(true)
        .compile("ferrule_shim");
}
