//! A result that is written whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use supervise::Error;

/// A result that is being written.
pub struct ResultFile {
    /// Its path when it is whole.
    path: PathBuf,
    file: BufWriter<File>,
}

impl ResultFile {
    pub(super) fn create(temporary: &Path, path: &Path) -> Result<Self, Error> {
        let path = path.to_owned();
        match File::create(temporary) {
            Ok(file) => Ok(Self { path, file: BufWriter::new(file) }),
            Err(reason) => Err(Error::Path { action: "write", path, reason }),
        }
    }

    /// Adds some bytes.
    pub fn add(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let path = || self.path.clone();
        let written = self.file.write_all(bytes);
        written.map_err(|reason| Error::Path { action: "write", path: path(), reason })
    }

    pub(super) fn finish(mut self, temporary: &Path) -> Result<(), Error> {
        let path = &self.path;
        let written = (self.file.flush())
            .and_then(|()| self.file.get_ref().sync_all())
            .and_then(|()| std::fs::rename(temporary, path));
        written.map_err(|reason| Error::Path { action: "write", path: path.clone(), reason })
    }
}
