//! Doc comments of fields, found in the text of a source file.

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

    #[test]
    fn a_comment_is_found_beside_its_field() {
        let source = "/// S.\npub struct S {\n    /// One,\n    /// m.\n    #[serde(default)]\n    \
                      pub one_m: X,\n    /// Two.\n    pub two: Y,\n}\n";
        assert_eq!(in_source(source, "S", "one_m").as_deref(), Some("One, m."));
        assert_eq!(in_source(source, "S", "two").as_deref(), Some("Two."));
        assert_eq!(in_source(source, "S", "three"), None);
        assert_eq!(in_source(source, "T", "two"), None);
    }
}
