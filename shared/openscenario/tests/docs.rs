//! The page in docs/ states the subset that is read.

#[test]
fn the_page_has_the_table_of_the_subset() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/openscenario.md");
    let page = std::fs::read_to_string(path).expect("the page is there");
    assert!(
        page.contains(openscenario::reference::markdown().trim_end()),
        "docs/openscenario.md is out of date: cargo run -p openscenario --example subset prints its table"
    );
}
