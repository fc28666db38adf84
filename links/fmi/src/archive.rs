//! The zip archive that a unit is: its table of files, and the files.
//!
//! The reader accepts what tools write: stored and deflated files below 4 GiB. Every length is checked against the
//! archive, and no name leads out of the directory into which files are unpacked.

use crate::UnitError;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use std::fs::{self, File, Permissions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Component, Path};

/// End of the table: signature, and its length without a remark.
const END: (&[u8], usize) = (b"PK\x05\x06", 22);
/// Longest remark behind the table, bytes.
const MAX_REMARK: u64 = u16::MAX as u64;
/// A file in the table.
const ENTRY: (&[u8], usize) = (b"PK\x01\x02", 46);
/// A file's own header.
const HEADER: (&[u8], usize) = (b"PK\x03\x04", 30);

/// An open archive.
#[derive(Debug)]
pub struct Archive {
    place: String,
    file: File,
    entries: Vec<Entry>,
}

/// A file of the archive.
#[derive(Debug)]
struct Entry {
    name: String,
    is_deflated: bool,
    checksum: u32,
    packed: u64,
    size: u64,
    header: u64,
}

impl Archive {
    /// Opens an archive and reads its table.
    ///
    /// # Errors
    /// When the file is not there, or not such an archive.
    pub fn open(path: &Path) -> Result<Self, UnitError> {
        let place = path.display().to_string();
        let unit = "a unit (.fmu), which is a zip archive";
        let file = File::open(path).map_err(|e| UnitError::new(&place, e.to_string(), unit))?;
        let mut archive = Self { place, file, entries: Vec::new() };
        match archive.table() {
            Ok(entries) => archive.entries = entries,
            Err(error) => return Err(archive.refuse(error.to_string(), unit)),
        }
        Ok(archive)
    }

    fn refuse(&self, fault: impl Into<String>, expected: &str) -> UnitError {
        UnitError::new(&self.place, fault, expected)
    }

    fn table(&mut self) -> io::Result<Vec<Entry>> {
        let length = self.file.seek(SeekFrom::End(0))?;
        let tail = length.min(MAX_REMARK + END.1 as u64);
        let bytes = self.part(length - tail, tail)?;
        let end = (0..(bytes.len() + 1).saturating_sub(END.1))
            .rev()
            .find(|at| bytes[*at..].starts_with(END.0))
            .ok_or_else(|| invalid("not a zip archive"))?;
        let (count, size, at) =
            (short(&bytes, end + 10), long(&bytes, end + 12), long(&bytes, end + 16));
        if count == u64::from(u16::MAX) || at == u64::from(u32::MAX) || at + size > length {
            return Err(invalid("a zip archive that is cut off, or of the 64-bit form"));
        }
        let table = self.part(at, size)?;
        let mut entries = Vec::new();
        let mut rest = table.as_slice();
        for _ in 0..count {
            if rest.len() < ENTRY.1 || !rest.starts_with(ENTRY.0) {
                return Err(invalid("a zip archive with a broken table of files"));
            }
            let [name, extra, remark] = [28, 30, 32].map(|at| short(rest, at) as usize);
            let whole = ENTRY.1 + name + extra + remark;
            let method = short(rest, 10);
            if rest.len() < whole || short(rest, 8) & 1 != 0 || !matches!(method, 0 | 8) {
                return Err(invalid("a zip archive with an encrypted, foreign or broken file"));
            }
            let name = String::from_utf8_lossy(&rest[ENTRY.1..ENTRY.1 + name]);
            entries.push(Entry {
                // Some tools for Windows write its separator.
                name: name.replace('\\', "/"),
                is_deflated: method == 8,
                checksum: long(rest, 16) as u32,
                packed: long(rest, 20),
                size: long(rest, 24),
                header: long(rest, 42),
            });
            rest = &rest[whole..];
        }
        Ok(entries)
    }

    fn part(&mut self, at: u64, length: u64) -> io::Result<Vec<u8>> {
        self.file.seek(SeekFrom::Start(at))?;
        let mut bytes = Vec::new();
        (&mut self.file).take(length).read_to_end(&mut bytes)?;
        match bytes.len() as u64 == length {
            true => Ok(bytes),
            false => Err(invalid("a zip archive that is cut off")),
        }
    }

    /// Names of the files.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// When it is not there, is broken, or has more than `most` bytes.
    pub fn read(&mut self, name: &str, most: u64) -> Result<Vec<u8>, UnitError> {
        let place = self.entries.iter().position(|entry| entry.name == name);
        let place = place.ok_or_else(|| self.refuse(format!("no `{name}` in it"), "one"))?;
        if self.entries[place].size > most {
            let fault = format!("`{name}` has {} bytes", self.entries[place].size);
            return Err(self.refuse(fault, &format!("at most {most}")));
        }
        let mut bytes = Vec::new();
        match self.copy(place, &mut bytes) {
            Ok(()) => Ok(bytes),
            Err(error) => Err(self.refuse(format!("`{name}`: {error}"), "a file as it was packed")),
        }
    }

    /// Unpacks the files of some folders into a directory.
    ///
    /// # Errors
    /// When a file is broken or leads out of the directory, or the disk does not take it.
    pub fn unpack(&mut self, folders: &[&str], directory: &Path) -> Result<(), UnitError> {
        for place in 0..self.entries.len() {
            let name = self.entries[place].name.clone();
            if name.ends_with('/') || !folders.iter().any(|folder| name.starts_with(folder)) {
                continue;
            }
            let inside = Path::new(&name).components().all(|c| matches!(c, Component::Normal(_)));
            if !inside {
                let fault = format!("the file `{name}` leads out of it");
                return Err(self.refuse(fault, "names below the unit's own directory"));
            }
            let mut write = || -> io::Result<()> {
                let path = directory.join(&name);
                fs::create_dir_all(path.parent().unwrap_or(directory))?;
                let mut file = File::create(&path)?;
                self.copy(place, &mut file)?;
                // A unit may start programs of its own.
                file.set_permissions(Permissions::from_mode(0o700))
            };
            write().map_err(|error| {
                self.refuse(format!("`{name}`: {error}"), "a file that can be unpacked")
            })?;
        }
        Ok(())
    }

    /// Copies a file and checks its size and checksum.
    fn copy(&mut self, place: usize, to: &mut impl Write) -> io::Result<()> {
        let at = self.entries[place].header;
        let header = self.part(at, HEADER.1 as u64)?;
        if !header.starts_with(HEADER.0) {
            return Err(invalid("its header is broken"));
        }
        let behind = at + HEADER.1 as u64 + short(&header, 26) + short(&header, 28);
        self.file.seek(SeekFrom::Start(behind))?;
        let entry = &self.entries[place];
        let packed = (&mut self.file).take(entry.packed);
        let mut bytes: Box<dyn Read + '_> = match entry.is_deflated {
            true => Box::new(DeflateDecoder::new(packed)),
            false => Box::new(packed),
        };
        let (mut hash, mut left) = (crc32fast::Hasher::new(), entry.size);
        let mut part = vec![0; 64 << 10];
        loop {
            let count = bytes.read(&mut part)?;
            if count == 0 {
                break;
            }
            left = left.checked_sub(count as u64).ok_or_else(|| invalid("it is too long"))?;
            hash.update(&part[..count]);
            to.write_all(&part[..count])?;
        }
        match left == 0 && hash.finalize() == entry.checksum {
            true => Ok(()),
            false => Err(invalid("its checksum is wrong")),
        }
    }
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

/// Two bytes of a record that is long enough.
fn short(bytes: &[u8], at: usize) -> u64 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]]).into()
}

/// Four bytes of a record that is long enough.
fn long(bytes: &[u8], at: usize) -> u64 {
    short(bytes, at) | short(bytes, at + 2) << 16
}

/// Packs files into an archive. All are of the year 1980, so that the same files give the same bytes.
///
/// ```
/// let unit = fmi::pack(&[("modelDescription.xml", b"<a/>")])?;
/// assert!(unit.starts_with(b"PK"));
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// When the files have more than 4 GiB.
pub fn pack(files: &[(&str, &[u8])]) -> io::Result<Vec<u8>> {
    let (mut archive, mut table) = (Vec::new(), Vec::new());
    let length = |length: usize| u32::try_from(length).map_err(|_| invalid("files of over 4 GiB"));
    for (name, bytes) in files {
        let header = length(archive.len())?;
        let mut packed = DeflateEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(bytes)?;
        let packed = packed.finish()?;
        // Version 2.0, names in UTF-8, deflated, at midnight of the first day.
        let mut common: Vec<u8> = vec![20, 0, 0, 8, 8, 0, 0, 0, 33, 0];
        for word in [crc32fast::hash(bytes), length(packed.len())?, length(bytes.len())?] {
            common.extend(word.to_le_bytes());
        }
        common.extend([name.len() as u8, 0, 0, 0]);
        archive.extend([HEADER.0, &common, name.as_bytes(), &packed].concat());
        // Made under Unix; no remark, first volume, an executable file.
        let more = [0, 0, 0, 0, 0, 0, 0, 0, 0xed, 0x81];
        let entry = [ENTRY.0, &[20, 3], &common, &more, &header.to_le_bytes(), name.as_bytes()];
        table.extend(entry.concat());
    }
    let (count, at) = ((files.len() as u16).to_le_bytes(), length(archive.len())?.to_le_bytes());
    let size = length(table.len())?.to_le_bytes();
    archive.extend([&table[..], END.0, &[0; 4], &count, &count, &size, &at, &[0; 2]].concat());
    Ok(archive)
}
