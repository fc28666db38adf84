//! Prints the table of docs/openscenario.md: `cargo run -p openscenario --example subset`.

fn main() {
    print!("{}", openscenario::reference::markdown());
}
