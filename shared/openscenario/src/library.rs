//! The files of a scenario: itself, its catalogs, its road.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::{ReadError, one_of};
use crate::node::Node;
use crate::parameter::{Assignment, Scope};
use crate::subset;
use crate::xml::{self, Document, Element, MAX_FILE_BYTES};

/// Where files come from: the disk, or a table in memory.
pub trait Source {
    /// The text of a file.
    ///
    /// # Errors
    /// When it cannot be read.
    fn read(&self, path: &Path) -> std::io::Result<String>;

    /// The files of a directory whose names end in `.xosc`, in order.
    ///
    /// # Errors
    /// When it cannot be listed.
    fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>>;
}

/// The disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Source for Disk {
    fn read(&self, path: &Path) -> std::io::Result<String> {
        let metadata = std::fs::metadata(path)?;
        if !metadata.is_file() || metadata.len() > MAX_FILE_BYTES as u64 {
            let reason = format!("is not a regular file of at most {MAX_FILE_BYTES} bytes");
            return Err(std::io::Error::other(reason));
        }
        text(std::fs::read(path)?)
    }

    fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(directory)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "xosc") {
                files.push(path);
            }
        }
        files.sort();
        Ok(files)
    }
}

/// The text of a file's bytes, whatever encoding it declares: of ASCII all are UTF-8 too.
fn text(bytes: Vec<u8>) -> std::io::Result<String> {
    let refuse = |what: &str| std::io::Error::other(format!("{what}, expected XML in UTF-8"));
    if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, b'<', ..] | [b'<', 0, ..] = bytes[..] {
        return Err(refuse("is UTF-16 text"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        refuse(&format!("is not UTF-8 text (byte {at})"))
    })
}

/// Reads, checks and keeps files.
pub(crate) struct Library<'a> {
    source: &'a dyn Source,
    /// The scenario file's directory.
    directory: PathBuf,
    /// Catalogs by directory; each with its file.
    catalogs: RefCell<BTreeMap<PathBuf, Rc<Vec<Document>>>>,
}

/// The kinds of catalog entries that are used.
pub(crate) const LOCATIONS: &[(&str, &str)] = &[
    ("Vehicle", "VehicleCatalog"),
    ("Pedestrian", "PedestrianCatalog"),
    ("MiscObject", "MiscObjectCatalog"),
    ("Controller", "ControllerCatalog"),
    ("Trajectory", "TrajectoryCatalog"),
    ("Maneuver", "ManeuverCatalog"),
    ("Environment", "EnvironmentCatalog"),
];

impl<'a> Library<'a> {
    pub(crate) fn new(source: &'a dyn Source, scenario: &Path) -> Self {
        let directory = scenario.parent().unwrap_or(Path::new("")).to_owned();
        Self { source, directory, catalogs: RefCell::default() }
    }

    /// The text of a file that the scenario names.
    pub(crate) fn text(&self, relative: &str) -> (PathBuf, std::io::Result<String>) {
        let path = self.directory.join(relative.trim_start_matches("./"));
        let text = self.source.read(&path);
        (path, text)
    }

    /// Gives the entry that a reference names, and the kind of it, to `take`. `locations` is the
    /// scenario's `CatalogLocations`, `kinds` the entries that would do.
    pub(crate) fn entry<T>(
        &self,
        reference: Node<'_>,
        locations: Option<Node<'_>>,
        kinds: &[&str],
        take: &mut dyn FnMut(Node<'_>) -> Result<T, ReadError>,
    ) -> Result<T, ReadError> {
        let catalog = reference.text("catalogName")?;
        let entry = reference.text("entryName")?;
        let mut seen: Vec<String> = Vec::new();
        for (_, location) in LOCATIONS.iter().filter(|(kind, _)| kinds.contains(kind)) {
            let Some(place) = locations.and_then(|list| list.child_if(location)) else { continue };
            let directory = place.child("Directory")?;
            for document in self.directory(directory)?.iter() {
                let Some(found) = document.root.child("Catalog") else { continue };
                let name = found.attribute("name").unwrap_or_default();
                seen.push(name.to_owned());
                if name != catalog {
                    continue;
                }
                let named = |element: &&Element| element.attribute("name") == Some(entry.as_str());
                let Some(element) = found.children.iter().find(named) else {
                    let known = found.children.iter().filter_map(|e| e.attribute("name"));
                    return Err(reference.refuse(
                        format!("catalog `{catalog}` ({}) has no entry `{entry}`", document.file),
                        one_of(known),
                    ));
                };
                if !kinds.contains(&element.name.as_str()) {
                    return Err(reference.refuse(
                        format!("`{entry}` of catalog `{catalog}` is a `{}`", element.name),
                        one_of(kinds.iter().copied()),
                    ));
                }
                subset::check_part(&document.file, element)?;
                let assigned = assignments(reference)?;
                let scope = Scope::default()
                    .with(&document.file, element, &assigned)
                    .map_err(|error| error.given_at(&reference.place()))?;
                return take(Node { file: &document.file, element, scope: &scope });
            }
        }
        seen.sort();
        Err(reference.refuse(
            format!("catalog `{catalog}` is in none of the catalog locations"),
            match seen.is_empty() {
                true => "a location with catalogs of this kind".to_owned(),
                false => one_of(seen.iter().map(String::as_str)),
            },
        ))
    }

    fn directory(&self, node: Node<'_>) -> Result<Rc<Vec<Document>>, ReadError> {
        let path = self.directory.join(node.text("path")?.trim_start_matches("./"));
        if let Some(known) = self.catalogs.borrow().get(&path) {
            return Ok(Rc::clone(known));
        }
        let unreadable = |path: &Path, error: std::io::Error| {
            let reason = format!("the catalogs of {} cannot be read: {error}", path.display());
            node.refuse(reason, "a directory of catalogs, relative to the scenario file")
        };
        let mut documents = Vec::new();
        for file in self.source.list(&path).map_err(|error| unreadable(&path, error))? {
            let text = self.source.read(&file).map_err(|error| unreadable(&file, error))?;
            let document = xml::parse(&file.display().to_string(), &text)?;
            subset::check_head(&document)?;
            documents.push(document);
        }
        let documents = Rc::new(documents);
        self.catalogs.borrow_mut().insert(path, Rc::clone(&documents));
        Ok(documents)
    }
}

/// The values that a catalog reference gives to its entry's parameters.
fn assignments(reference: Node<'_>) -> Result<Vec<Assignment>, ReadError> {
    let Some(list) = reference.child_if("ParameterAssignments") else { return Ok(Vec::new()) };
    list.children()
        .map(|node| {
            // The name of the entry's parameter, with its `$` or without; not a parameter of the scenario.
            let name = node.element.attribute("parameterRef").unwrap_or_default();
            let name = name.trim_start_matches('$').to_owned();
            Ok(Assignment { name, value: node.text("value")? })
        })
        .collect()
}

/// Files in memory, for tests.
#[cfg(test)]
pub(crate) mod memory {
    use std::collections::BTreeMap;
    use std::path::{Path, PathBuf};

    use super::Source;

    pub(crate) struct Memory(BTreeMap<PathBuf, String>);

    impl Memory {
        pub(crate) fn of(files: &[(&str, &str)]) -> Self {
            Self(files.iter().map(|(path, text)| (path.into(), (*text).to_owned())).collect())
        }
    }

    impl Source for Memory {
        fn read(&self, path: &Path) -> std::io::Result<String> {
            self.0.get(path).cloned().ok_or_else(|| std::io::ErrorKind::NotFound.into())
        }

        fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
            let inside = self.0.keys().filter(|path| path.parent() == Some(directory));
            let files: Vec<PathBuf> = inside.cloned().collect();
            if files.is_empty() { Err(std::io::ErrorKind::NotFound.into()) } else { Ok(files) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_in_another_encoding_is_refused_with_what_was_expected() {
        assert_eq!(text(b"<a/>".to_vec()).expect("text"), "<a/>");
        let utf16 = |order: fn(u16) -> [u8; 2], mark: &str| {
            format!("{mark}<a/>").encode_utf16().flat_map(order).collect::<Vec<u8>>()
        };
        for bytes in [
            utf16(u16::to_le_bytes, "\u{feff}"),
            utf16(u16::to_be_bytes, "\u{feff}"),
            utf16(u16::to_le_bytes, ""),
            utf16(u16::to_be_bytes, ""),
        ] {
            let said = text(bytes).expect_err("not UTF-8").to_string();
            assert_eq!(said, "is UTF-16 text, expected XML in UTF-8");
        }
        let said = text(b"<a b='\xc4'/>".to_vec()).expect_err("Latin-1").to_string();
        assert_eq!(said, "is not UTF-8 text (byte 6), expected XML in UTF-8");
    }
}
