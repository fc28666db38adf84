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
        let entries = std::fs::read_dir(directory)?.map(|entry| Ok(entry?.path()));
        let mut files = entries.collect::<std::io::Result<Vec<PathBuf>>>()?;
        files.retain(|path| path.extension().is_some_and(|extension| extension == "xosc"));
        files.sort();
        Ok(files)
    }
}

/// Encodings of one byte a character, as files declare them. Western European programs write them.
const ONE_BYTE: [&str; 5] = ["iso-8859-1", "iso-8859-15", "latin1", "windows-1252", "us-ascii"];

/// The text of a file's bytes: UTF-8, UTF-16, or an encoding of one byte a character that the file declares.
fn text(bytes: Vec<u8>) -> std::io::Result<String> {
    let refuse = |what: &str| {
        let expected = "expected XML in UTF-8, UTF-16 or the Latin-1 that it declares";
        std::io::Error::other(format!("{what}, {expected}"))
    };
    let unit: Option<fn([u8; 2]) -> u16> = match bytes[..] {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, b'<', ..] => Some(u16::from_be_bytes),
        _ => None,
    };
    if let Some(unit) = unit {
        return utf16(&bytes, unit).ok_or_else(|| refuse("is broken UTF-16 text"));
    }
    String::from_utf8(bytes).or_else(|error| {
        let at = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        if declared(&bytes).is_some_and(|name| ONE_BYTE.contains(&name.as_str())) {
            // Bytes with another meaning in each of the encodings stand in names and comments alone.
            let character = |byte| match byte {
                0x80..=0x9f => char::REPLACEMENT_CHARACTER,
                _ => char::from(byte),
            };
            return Ok(bytes.into_iter().map(character).collect());
        }
        let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
        Err(refuse(&format!("is not UTF-8 text (line {line}, byte {at})")))
    })
}

/// The text of UTF-16, without its mark.
fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Option<String> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let decoded: Result<String, _> =
        char::decode_utf16(pairs.iter().map(|pair| unit(*pair))).collect();
    let text = decoded.ok().filter(|_| rest.is_empty())?;
    Some(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}

/// The encoding that an XML declaration names, in small letters.
fn declared(bytes: &[u8]) -> Option<String> {
    let head = bytes.strip_prefix(b"<?xml")?;
    let end = head.windows(2).position(|pair| pair == b"?>")?;
    let head = std::str::from_utf8(&head[..end]).ok()?;
    let (_, value) = head.split_once("encoding")?;
    let value = value.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    let (name, _) = value[1..].split_once(quote)?;
    Some(name.to_ascii_lowercase())
}

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
    fn a_text_is_read_in_the_encoding_that_it_declares_or_shows() {
        assert_eq!(text(b"<a/>".to_vec()).expect("text"), "<a/>");
        let utf16 = |order: fn(u16) -> [u8; 2], mark: &str| {
            format!("{mark}<a b='\u{c4}'/>").encode_utf16().flat_map(order).collect::<Vec<u8>>()
        };
        for bytes in [
            utf16(u16::to_le_bytes, "\u{feff}"),
            utf16(u16::to_be_bytes, "\u{feff}"),
            utf16(u16::to_le_bytes, ""),
            utf16(u16::to_be_bytes, ""),
        ] {
            assert_eq!(text(bytes).expect("UTF-16"), "<a b='\u{c4}'/>");
        }
        for head in
            ["<?xml version='1.0' encoding = 'ISO-8859-1'?>", "<?xml encoding=\"windows-1252\"?>"]
        {
            let bytes = [head.as_bytes(), b"<a b='\xc4 \x96'/>"].concat();
            assert_eq!(text(bytes).expect("Latin-1"), format!("{head}<a b='\u{c4} \u{fffd}'/>"));
        }
    }

    #[test]
    fn a_text_in_an_encoding_that_it_does_not_declare_is_refused_with_its_line() {
        let expected = "expected XML in UTF-8, UTF-16 or the Latin-1 that it declares";
        for head in ["", "<?xml version='1.0' encoding='UTF-8'?>", "<?xml encoding='?>", "<?xml"] {
            let bytes = [head.as_bytes(), b"\n<a b='\xc4'/>"].concat();
            let said = text(bytes).expect_err("Latin-1").to_string();
            let at = head.len() + 7;
            assert_eq!(said, format!("is not UTF-8 text (line 2, byte {at}), {expected}"));
        }
        for bytes in [&b"<\0a"[..], &[0xff, 0xfe, 0x00, 0xd8]] {
            let said = text(bytes.to_vec()).expect_err("half a character").to_string();
            assert_eq!(said, format!("is broken UTF-16 text, {expected}"));
        }
    }
}
