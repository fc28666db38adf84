//! A file as a tree of elements that know their lines.

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::error::{Place, ReadError};

/// Longest file, bytes.
pub const MAX_FILE_BYTES: usize = 4 << 20;
/// Deepest nesting of elements.
const MAX_DEPTH: usize = 64;

/// A well-formed file.
#[derive(Clone, Debug)]
pub struct Document {
    /// Its name in errors.
    pub file: String,
    /// The outermost element.
    pub root: Element,
}

/// An element with what it holds. Text between elements has no meaning in either standard and is
/// passed over.
#[derive(Clone, Debug)]
pub struct Element {
    /// Name, without a namespace.
    pub name: String,
    /// Line of its start tag, from 1.
    pub line: usize,
    /// Attributes in the order of the file.
    pub attributes: Vec<(String, String)>,
    /// Elements inside it, in the order of the file.
    pub children: Vec<Element>,
}

impl Element {
    /// The text of an attribute.
    #[must_use]
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// The first child of that name.
    #[must_use]
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// Reads a file's text.
///
/// # Errors
/// When it is not well-formed, nests too deeply, is too long or declares entities.
pub fn parse(file: &str, text: &str) -> Result<Document, ReadError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.len() > MAX_FILE_BYTES {
        let reason = format!("has {} bytes, expected at most {MAX_FILE_BYTES}", text.len());
        return Err(ReadError::File { file: file.to_owned(), reason });
    }
    let lines = Lines::of(text);
    let syntax = |at: u64, reason: String| ReadError::Syntax {
        place: Place { file: file.to_owned(), line: lines.at(at) },
        reason,
    };
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    loop {
        let start = reader.buffer_position();
        let event = reader
            .read_event()
            .map_err(|error| syntax(reader.error_position(), format!("not XML: {error}")))?;
        let line = lines.at(start);
        let closed = match event {
            Event::Start(tag) => {
                if root.is_some() && open.is_empty() {
                    return Err(syntax(start, "a second outermost element".to_owned()));
                }
                if open.len() == MAX_DEPTH {
                    let reason = format!("elements are nested more than {MAX_DEPTH} deep");
                    return Err(syntax(start, reason));
                }
                open.push(element(&tag, line).map_err(|reason| syntax(start, reason))?);
                None
            }
            Event::Empty(tag) => Some(element(&tag, line).map_err(|reason| syntax(start, reason))?),
            Event::End(_) => open.pop(),
            // One in another file changes nothing here, because entities of it are not read.
            Event::DocType(kind) if kind.contains('[') => {
                let reason = "a document type with declarations of its own, expected none";
                return Err(syntax(start, reason.to_owned()));
            }
            Event::Eof => break,
            _ => None,
        };
        match (closed, open.last_mut()) {
            (Some(element), Some(parent)) => parent.children.push(element),
            (Some(element), None) if root.is_none() => root = Some(element),
            (Some(_), None) => {
                return Err(syntax(start, "a second outermost element".to_owned()));
            }
            (None, _) => {}
        }
    }
    if let Some(element) = open.last() {
        let reason = format!("`{}` of line {} is not closed", element.name, element.line);
        return Err(syntax(text.len() as u64, reason));
    }
    match root {
        Some(root) => Ok(Document { file: file.to_owned(), root }),
        None => Err(syntax(0, "no element, expected XML".to_owned())),
    }
}

fn element(tag: &BytesStart<'_>, line: usize) -> Result<Element, String> {
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| format!("not XML: {error}"))?;
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|error| format!("not XML: {error}"))?;
        // Of the characters below the space XML knows three.
        if let Some(c) = value.chars().find(|c| *c < ' ' && !matches!(c, '\t' | '\n' | '\r')) {
            let code = u32::from(c);
            return Err(format!("not XML: an attribute holds the control character U+{code:04X}"));
        }
        attributes.push((attribute.key.local_name().as_ref().to_owned(), value.into_owned()));
    }
    let name = tag.local_name().as_ref().to_owned();
    Ok(Element { name, line, attributes, children: Vec::new() })
}

/// Where the lines of a text begin.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        let after = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self(after.map(|(at, _)| at + 1).collect())
    }

    fn at(&self, position: u64) -> usize {
        1 + self.0.partition_point(|start| *start as u64 <= position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        parse("x.xosc", text).expect_err("it is not well-formed").to_string()
    }

    #[test]
    fn elements_know_their_lines() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\n<!-- a\nremark -->\n<A b=\"1 &lt; 2\">\n <B/>\n\n <C\n  d='e'></C>\n</A>\n";
        let document = parse("x.xosc", text).expect("it is well-formed");
        let root = &document.root;
        assert_eq!((root.name.as_str(), root.line), ("A", 4));
        assert_eq!(root.attribute("b"), Some("1 < 2"));
        let children: Vec<(&str, usize)> =
            root.children.iter().map(|child| (child.name.as_str(), child.line)).collect();
        assert_eq!(children, [("B", 5), ("C", 7)]);
        assert_eq!(root.children[1].attribute("d"), Some("e"));
    }

    #[test]
    fn what_is_not_well_formed_is_refused_at_its_line() {
        assert!(
            refusal("<A>\n <B>\n</A>").starts_with("x.xosc:3: not XML"),
            "{}",
            refusal("<A>\n <B>\n</A>")
        );
        assert!(refusal("<A>\n").contains("`A` of line 1 is not closed"));
        assert!(refusal("<A/>\n<B/>").starts_with("x.xosc:2: a second outermost element"));
        assert!(refusal("").contains("no element"));
        let entities = "<!DOCTYPE a [<!ENTITY b \"c\">]>\n<A/>";
        assert!(refusal(entities).contains("a document type with declarations"));
        assert_eq!(
            refusal("<!DOCTYPE a SYSTEM \"a.dtd\">\n<A>"),
            "x.xosc:2: `A` of line 2 is not closed"
        );
        assert!(refusal("<A b=\"1\" b=\"2\"/>").contains("not XML"));
        assert!(refusal("<A b=\"\0\"/>").contains("U+0000"));
        assert!(refusal("<A b=\"&#27;[2J\"/>").contains("U+001B"));
        assert!(refusal(&"<A>".repeat(70)).contains("nested more than 64 deep"));
    }
}
