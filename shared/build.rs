//! Passes the folder of the sources to the build script of `relievo-shared-f64`,
//! which compiles them in f64.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let package = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    println!("cargo::metadata=sources={package}/src");
}
