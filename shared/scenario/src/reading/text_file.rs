//! Text files of bounded size.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Opens a file to read it; an error is the reason.
pub(crate) fn open(path: &Path) -> Result<File, String> {
    File::open(path).map_err(|error| format!("cannot be opened: {error}"))
}

/// Reads a text file of at most `most` bytes; an error is the reason.
pub(crate) fn read(path: &Path, most: usize) -> Result<String, String> {
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return Err("is not a regular file".to_owned());
    }
    let mut bytes = Vec::new();
    let read = open(path)?.take(most as u64 + 1).read_to_end(&mut bytes);
    read.map_err(|error| format!("cannot be read: {error}"))?;
    if bytes.len() > most {
        return Err(format!("is larger than {most} bytes"));
    }
    String::from_utf8(bytes)
        .map_err(|error| format!("is not UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_not_a_text_file() {
        assert_eq!(read(Path::new("/"), 1), Err("is not a regular file".to_owned()));
    }
}
