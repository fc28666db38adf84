//! What fields mean: the doc comments of the structs that declare them, read from the sources.

/// The sources of this crate that declare messages.
const SOURCES: &[&str] = &[
    include_str!("brake.rs"),
    include_str!("control.rs"),
    include_str!("e2e/profile7.rs"),
    include_str!("header.rs"),
    include_str!("health.rs"),
    include_str!("law.rs"),
    include_str!("perception.rs"),
    include_str!("radio.rs"),
    include_str!("v2x.rs"),
    include_str!("vehicle.rs"),
];

/// The comment on field `field` of the message struct `name`, in one line.
#[must_use]
pub fn of_message(name: &str, field: &str) -> Option<String> {
    SOURCES.iter().find_map(|source| in_source(source, name, field))
}

/// The comment on field `field` of `pub struct name` in the text of a source file, in one line.
#[must_use]
pub fn in_source(source: &str, name: &str, field: &str) -> Option<String> {
    in_block(source, &format!("pub struct {name} {{"), "pub ", field)
}

/// The comment on field `field` of the enum variant `name` in the text of a source file, in one line.
#[must_use]
pub fn in_variant(source: &str, name: &str, field: &str) -> Option<String> {
    in_block(source, &format!("{name} {{"), "", field)
}

/// The comment on the line `PREFIX FIELD:` behind the line `head`, up to the end of that block.
fn in_block(source: &str, head: &str, prefix: &str, field: &str) -> Option<String> {
    let mut lines = source.lines();
    lines.find(|line| line.trim() == head)?;
    let mut comment = String::new();
    for line in lines.map(str::trim) {
        if line.starts_with('}') {
            return None;
        }
        if let Some(text) = line.strip_prefix("///") {
            if !comment.is_empty() {
                comment.push(' ');
            }
            comment.push_str(text.trim());
        } else if !line.starts_with("#[")
            && let Some(rest) = line.strip_prefix(prefix)
        {
            if rest.split_once(':').is_some_and(|(known, _)| known == field) {
                return Some(comment);
            }
            comment.clear();
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Element, Layout, TOPICS};

    #[test]
    fn a_comment_is_found_beside_its_field() {
        let source = "/// S.\npub struct S {\n    /// One,\n    /// m.\n    #[serde(default)]\n    \
                      pub one_m: X,\n    /// Two.\n    pub two: Y,\n}\n";
        assert_eq!(in_source(source, "S", "one_m").as_deref(), Some("One, m."));
        assert_eq!(in_source(source, "S", "two").as_deref(), Some("Two."));
        assert_eq!(in_source(source, "S", "three"), None);
        assert_eq!(in_source(source, "T", "two"), None);
    }

    fn check(layout: &Layout) {
        for field in layout.fields {
            let meaning = of_message(layout.name, field.name);
            assert!(
                meaning.is_some_and(|meaning| !meaning.is_empty()),
                "{}.{} has no comment, or its source is not listed here",
                layout.name,
                field.name
            );
            if let Element::Struct(inner) = field.shape.element {
                check(inner);
            }
        }
    }

    #[test]
    fn every_field_of_every_message_has_a_meaning() {
        TOPICS.into_iter().for_each(|topic| check(topic.layout()));
    }
}
