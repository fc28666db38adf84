//! Compiles the library that stands in every exported unit: one file of Rust's standard library alone, so that the
//! program holds it and needs no compiler when it exports.

use std::env::var;
use std::process::Command;

fn main() {
    let source = "library/unit.rs";
    println!("cargo:rerun-if-changed={source}");
    let of_cargo = |name: &str| var(name).unwrap_or_else(|_| panic!("cargo sets {name}"));
    let library = format!("{}/unit.so", of_cargo("OUT_DIR"));
    let mut compiler = Command::new(of_cargo("RUSTC"));
    compiler.args(["--edition=2024", "--crate-type=cdylib", "--crate-name=unit"]).args([
        "-Copt-level=s",
        "-Cstrip=symbols",
        "--target",
        &of_cargo("TARGET"),
    ]);
    if let Ok(linker) = var("RUSTC_LINKER") {
        compiler.arg(format!("-Clinker={linker}"));
    }
    let status = compiler.args(["-o", &library, source]).status().expect("cargo's compiler starts");
    assert!(status.success(), "{source} compiles");
}
