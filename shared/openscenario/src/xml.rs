//! A file as a tree of elements with their places.

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::error::{Place, ReadError, Spot};

/// Longest file, bytes: road files of whole towns have a few million.
pub const MAX_FILE_BYTES: usize = 16 << 20;
const MAX_DEPTH: usize = 64;

#[derive(Clone, Debug)]
pub struct Document {
    /// Its name in errors.
    pub file: String,
    pub root: Element,
}

/// An element with what it holds. Text between elements is skipped: neither standard gives it a meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Name, without a namespace.
    pub name: String,
    /// The beginning of its start tag.
    pub spot: Spot,
    pub attributes: Vec<Attribute>,
    /// Elements inside it, in the order of the file.
    pub children: Vec<Element>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Name, without a namespace.
    pub name: String,
    /// Value, with its references to characters replaced.
    pub value: String,
    /// The beginning of its name.
    pub spot: Spot,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.given(name).map(|attribute| attribute.value.as_str())
    }

    pub fn given(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }
}

/// Reads a file's text.
///
/// # Errors
/// When it is not well-formed, nests too deeply, is too long or declares entities.
pub fn parse(file: &str, text: &str) -> Result<Document, ReadError> {
    parse_within(file, text, MAX_FILE_BYTES)
}

/// The same with another longest text, bytes.
///
/// # Errors
/// As [`parse`].
pub fn parse_within(file: &str, text: &str, most_bytes: usize) -> Result<Document, ReadError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.len() > most_bytes {
        let reason = format!("has {} bytes, expected at most {most_bytes}", text.len());
        return Err(ReadError::File { file: file.to_owned(), reason });
    }
    let syntax = |at: u64, reason: String| ReadError::Syntax {
        place: Place { file: file.to_owned(), spot: Cursor::new(text).at(at as usize) },
        reason,
    };
    let mut cursor = Cursor::new(text);
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    loop {
        let start = reader.buffer_position();
        let event = reader
            .read_event()
            .map_err(|error| syntax(reader.error_position(), format!("not XML: {error}")))?;
        let spot = cursor.at(start as usize);
        let mut read = |tag: &BytesStart<'_>| {
            element(tag, spot, &mut cursor).map_err(|reason| syntax(start, reason))
        };
        let closed = match event {
            Event::Start(_) | Event::Empty(_) if root.is_some() && open.is_empty() => {
                return Err(syntax(start, "a second outermost element".to_owned()));
            }
            Event::Start(tag) => {
                if open.len() == MAX_DEPTH {
                    let reason = format!("elements are nested more than {MAX_DEPTH} deep");
                    return Err(syntax(start, reason));
                }
                open.push(read(&tag)?);
                None
            }
            Event::Empty(tag) => Some(read(&tag)?),
            Event::End(_) => open.pop(),
            // An external document type changes nothing: its entities are not read.
            Event::DocType(kind) if kind.contains('[') => {
                let reason = "a document type with declarations of its own, expected none";
                return Err(syntax(start, reason.to_owned()));
            }
            Event::Eof => break,
            _ => None,
        };
        match (closed, open.last_mut()) {
            (Some(element), Some(parent)) => parent.children.push(element),
            (Some(element), None) => root = Some(element),
            (None, _) => {}
        }
    }
    if let Some(element) = open.last() {
        let reason = format!("`{}` of line {} is not closed", element.name, element.spot.line);
        return Err(syntax(text.len() as u64, reason));
    }
    match root {
        Some(root) => Ok(Document { file: file.to_owned(), root }),
        None => Err(syntax(0, "no element, expected XML".to_owned())),
    }
}

fn element(tag: &BytesStart<'_>, spot: Spot, cursor: &mut Cursor<'_>) -> Result<Element, String> {
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| format!("not XML: {error}"))?;
        let value = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|error| format!("not XML: {error}"))?;
        // XML allows three characters below the space.
        if let Some(c) = value.chars().find(|c| *c < ' ' && !matches!(c, '\t' | '\n' | '\r')) {
            let code = u32::from(c);
            return Err(format!("not XML: an attribute holds the control character U+{code:04X}"));
        }
        let spot = cursor.of(attribute.key.as_ref()).unwrap_or(spot);
        let name = attribute.key.local_name().as_ref().to_owned();
        attributes.push(Attribute { name, value: value.into_owned(), spot });
    }
    let name = tag.local_name().as_ref().to_owned();
    Ok(Element { name, spot, attributes, children: Vec::new() })
}

/// A position in a text that counts lines and columns on its way forward.
struct Cursor<'a> {
    text: &'a str,
    at: usize,
    spot: Spot,
}

impl<'a> Cursor<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, at: 0, spot: Spot { line: 1, column: 1 } }
    }

    fn at(&mut self, byte: usize) -> Spot {
        if byte < self.at {
            *self = Self::new(self.text);
        }
        while let Some(c) = self.text[self.at..].chars().next()
            && self.at < byte
        {
            self.at += c.len_utf8();
            self.spot = match c {
                '\n' => Spot { line: self.spot.line + 1, column: 1 },
                _ => Spot { column: self.spot.column + 1, ..self.spot },
            };
        }
        self.spot
    }

    fn of(&mut self, part: &str) -> Option<Spot> {
        let byte = part.as_ptr().addr().checked_sub(self.text.as_ptr().addr())?;
        (byte + part.len() <= self.text.len()).then(|| self.at(byte))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        parse("x.xosc", text).expect_err("it is not well-formed").to_string()
    }

    #[test]
    fn elements_and_attributes_have_their_places() {
        let text = "\u{feff}<?xml version=\"1.0\"?>\n<!-- a\nremark -->\n<A b=\"1 &lt; 2\">\n <B/>\n\n <C\n  d='e'></C>\n</A>\n";
        let document = parse("x.xosc", text).expect("it is well-formed");
        let root = &document.root;
        let spot = |line, column| Spot { line, column };
        assert_eq!((root.name.as_str(), root.spot), ("A", spot(4, 1)));
        assert_eq!(root.attribute("b"), Some("1 < 2"));
        let children: Vec<(&str, Spot)> =
            root.children.iter().map(|child| (child.name.as_str(), child.spot)).collect();
        assert_eq!(children, [("B", spot(5, 2)), ("C", spot(7, 2))]);
        assert_eq!(root.children[1].given("d").map(|d| d.spot), Some(spot(8, 3)));
        assert_eq!(root.children[1].attribute("d"), Some("e"));
    }

    #[test]
    fn a_file_that_is_not_well_formed_is_refused_at_its_line() {
        assert!(
            refusal("<A>\n <B>\n</A>").starts_with("x.xosc:3:1: not XML"),
            "{}",
            refusal("<A>\n <B>\n</A>")
        );
        assert!(refusal("<A>\n").contains("`A` of line 1 is not closed"));
        assert!(refusal("<A/>\n<B/>").starts_with("x.xosc:2:1: a second outermost element"));
        assert!(refusal("").contains("no element"));
        let entities = "<!DOCTYPE a [<!ENTITY b \"c\">]>\n<A/>";
        assert!(refusal(entities).contains("a document type with declarations"));
        assert_eq!(
            refusal("<!DOCTYPE a SYSTEM \"a.dtd\">\n<A>"),
            "x.xosc:2:4: `A` of line 2 is not closed"
        );
        assert!(refusal("<A b=\"1\" b=\"2\"/>").contains("not XML"));
        assert!(refusal("<A b=\"\0\"/>").contains("U+0000"));
        assert!(refusal("<A b=\"&#27;[2J\"/>").contains("U+001B"));
        assert!(refusal(&"<A>".repeat(70)).contains("nested more than 64 deep"));
    }
}
