//! Builds the C part of the comparison with CycloneDDS if its library is installed.

fn main() {
    println!("cargo::rerun-if-changed=src/middleware/cyclonedds.c");
    println!("cargo::rustc-check-cfg=cfg(cyclonedds)");
    #[cfg(feature = "peers")]
    cyclonedds();
}

#[cfg(feature = "peers")]
fn cyclonedds() {
    match pkg_config::Config::new().atleast_version("0.10").probe("CycloneDDS") {
        Ok(library) => {
            cc::Build::new()
                .file("src/middleware/cyclonedds.c")
                .includes(library.include_paths)
                .compile("timegap_cyclonedds");
            println!("cargo::rustc-cfg=cyclonedds");
        }
        Err(error) => {
            let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
            println!("cargo::warning=built without the comparison with CycloneDDS: {reason}");
        }
    }
}
