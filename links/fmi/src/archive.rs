//! The zip archive that a unit is. No name leads out of the directory into which files are unpacked.

use crate::UnitError;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use rawzip::{CompressionMethod, ZipArchive, ZipArchiveEntryWayfinder, ZipArchiveWriter};
use std::fs::{self, Permissions};
use std::io::{self, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Longest file of a unit, bytes.
const MAX_FILE: u64 = 4 << 30;

pub struct Archive {
    place: String,
    bytes: Vec<u8>,
    /// Its files: name, way of packing, place.
    entries: Vec<(String, CompressionMethod, ZipArchiveEntryWayfinder)>,
}

impl Archive {
    pub fn open(path: &Path) -> Result<Self, UnitError> {
        let place = path.display().to_string();
        let refuse =
            |fault: String| UnitError::new(&place, fault, "a unit (.fmu), which is a zip archive");
        let bytes = fs::read(path).map_err(|error| refuse(error.to_string()))?;
        let table = || -> Result<_, rawzip::Error> {
            let archive = ZipArchive::from_slice(&bytes)?;
            let (mut entries, mut rest) = (Vec::new(), archive.entries());
            while let Some(entry) = rest.next_entry()? {
                let name = entry.file_path().try_normalize()?.as_ref().to_owned();
                entries.push((name, entry.compression_method(), entry.wayfinder()));
            }
            Ok(entries)
        };
        let entries = table().map_err(|error| refuse(format!("not a zip archive: {error}")))?;
        Ok(Self { place, bytes, entries })
    }

    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(name, ..)| name.as_str())
    }

    /// The bytes of a file that is there, is whole, and has at most `most` bytes.
    pub fn read(&self, name: &str, most: u64) -> Result<Vec<u8>, UnitError> {
        let refuse = |fault: String, expected: &str| UnitError::new(&self.place, fault, expected);
        let entry = self.entries.iter().find(|(known, ..)| known == name);
        let (_, method, place) =
            entry.ok_or_else(|| refuse(format!("no `{name}` in it"), "one"))?;
        let read = || -> io::Result<Vec<u8>> {
            let archive = ZipArchive::from_slice(&self.bytes).map_err(io::Error::other)?;
            let file = archive.get_entry(*place).map_err(io::Error::other)?;
            let packed: Box<dyn Read> = match *method {
                CompressionMethod::STORE => Box::new(file.data()),
                CompressionMethod::DEFLATE => Box::new(DeflateDecoder::new(file.data())),
                _ => return Err(io::Error::other("it is packed by a method of its own")),
            };
            let mut bytes = Vec::new();
            file.verifying_reader(packed).take(most + 1).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        match read() {
            Ok(bytes) if bytes.len() as u64 <= most => Ok(bytes),
            Ok(_) => Err(refuse(format!("`{name}` is too long"), &format!("at most {most} bytes"))),
            Err(error) => Err(refuse(format!("`{name}`: {error}"), "a file as it was packed")),
        }
    }

    /// Unpacks the files of some folders into a directory.
    pub fn unpack(&self, folders: &[&str], directory: &Path) -> Result<(), UnitError> {
        let is_inside = |name: &&str| {
            !name.ends_with('/') && folders.iter().any(|folder| name.starts_with(folder))
        };
        for name in self.names().filter(is_inside) {
            let bytes = self.read(name, MAX_FILE)?;
            let path = directory.join(name);
            let write = || -> io::Result<()> {
                fs::create_dir_all(path.parent().unwrap_or(directory))?;
                fs::write(&path, bytes)?;
                // A unit may start programs of its own.
                fs::set_permissions(&path, Permissions::from_mode(0o700))
            };
            write().map_err(|error| {
                UnitError::new(path.display(), error.to_string(), "room for the unit's files")
            })?;
        }
        Ok(())
    }
}

/// Packs files into an archive. The same files give the same bytes.
///
/// ```
/// let unit = fmi::pack(&[("modelDescription.xml", b"<a/>")])?;
/// assert!(unit.starts_with(b"PK"));
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// When the files are too long for an archive.
pub fn pack(files: &[(&str, &[u8])]) -> io::Result<Vec<u8>> {
    let mut archive = ZipArchiveWriter::new(Vec::new());
    for (name, bytes) in files {
        let file = archive.new_file(*name).compression_method(CompressionMethod::DEFLATE);
        let started = file.unix_permissions(0o755).start();
        let (mut entry, config) = started.map_err(io::Error::other)?;
        let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::fast()));
        writer.write_all(bytes)?;
        let (encoder, descriptor) = writer.finish().map_err(io::Error::other)?;
        encoder.finish()?;
        entry.finish(descriptor).map_err(io::Error::other)?;
    }
    archive.finish().map_err(io::Error::other)
}
