//! Text files of bounded size.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::string::FromUtf8Error;

/// Reason why a text file is not read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TextFileError {
    #[error("cannot be opened: {0}")]
    NotOpened(#[source] io::Error),
    #[error("is not a regular file")]
    Irregular,
    #[error("cannot be read: {0}")]
    NotRead(#[source] io::Error),
    #[error("is larger than {0} bytes")]
    TooLarge(usize),
    #[error("is not UTF-8 text (byte {})", .0.utf8_error().valid_up_to())]
    NotText(#[from] FromUtf8Error),
}

/// Reads a text file of at most `most` bytes.
pub(crate) fn read(path: &Path, most: usize) -> Result<String, TextFileError> {
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    if !path.metadata().map_err(TextFileError::NotOpened)?.is_file() {
        return Err(TextFileError::Irregular);
    }
    let (file, mut bytes) = (File::open(path).map_err(TextFileError::NotOpened)?, Vec::new());
    file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(TextFileError::NotRead)?;
    if bytes.len() > most {
        return Err(TextFileError::TooLarge(most));
    }
    Ok(String::from_utf8(bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_not_a_text_file() {
        assert!(matches!(read(Path::new("/"), 1), Err(TextFileError::Irregular)));
    }
}
