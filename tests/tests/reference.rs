//! Generated pages of the documentation match the code.

use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

#[test]
fn references_are_of_this_code() {
    let corner = Corner::new(PROGRAM);
    for page in ["scenario", "messages"] {
        let output = corner.run(&["print", "reference", page]);
        assert!(output.status.success());
        let made = String::from_utf8(output.stdout).expect("text");
        let path = format!("{}/../docs/reference-{page}.md", env!("CARGO_MANIFEST_DIR"));
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            made == kept,
            "{path} is old: timegap print reference {page} > docs/reference-{page}.md"
        );
    }
}

/// The table of all ends is both in the code and in the documentation.
#[test]
fn the_table_of_exits_is_that_of_the_code() {
    let read = |path: &str| {
        let path = format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
    };
    let (code, page) = (read("tools/drive/src/exits.rs"), read("docs/exits.md"));
    let of_code: Vec<_> = code.lines().filter_map(|line| line.strip_prefix("//! |")).collect();
    let of_page: Vec<_> = page.lines().filter_map(|line| line.strip_prefix('|')).collect();
    assert!(of_code.len() > 10);
    assert_eq!(of_code, of_page);
}

#[test]
fn completions_and_the_man_page_have_the_commands() {
    let corner = Corner::new(PROGRAM);
    for (product, sign) in [
        (&["completions", "bash"][..], "_timegap"),
        (&["completions", "zsh"], "#compdef timegap"),
        (&["man"], ".TH timegap"),
    ] {
        let output = corner.run(&[&["print"], product].concat());
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains(sign), "{product:?}: {text}");
        assert!(text.contains("campaign"), "{product:?} knows the commands");
    }
}
