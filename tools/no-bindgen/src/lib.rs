//! Nothing: `Cargo.toml` says what this stands in for.
