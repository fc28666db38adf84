//! The files of a scenario: itself, its catalogs, its road.

use std::path::{Path, PathBuf};

use crate::xml::MAX_FILE_BYTES;

/// A source of files: the disk, or a table in memory.
///
/// ```
/// use openscenario::Source;
/// use std::path::{Path, PathBuf};
///
/// /// One file, whatever the path.
/// struct OneFile(&'static str);
///
/// impl Source for OneFile {
///     fn read(&self, _: &Path) -> std::io::Result<String> {
///         Ok(self.0.to_owned())
///     }
///
///     fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
///         Ok(vec![directory.join("only.xosc")])
///     }
/// }
/// ```
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

/// The text of a file's bytes. The declared encoding does not matter: ASCII is UTF-8 in all of them.
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
