//! Who belongs to the group: which process is which restart of which service.
//!
//! The launcher writes down every process that it starts; a consumer looks a sender up when it first
//! hears it. A process of the same user that opens a topic by itself is none of them.

use super::RuntimeError;
use messages::Service;
use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// Name of the list in the run's root.
const FILE: &str = "members";
/// A line is a service as a number, an incarnation and a process id.
const LONGEST_LIST: usize = 64 * 1024;

/// Enters process `pid` as restart `incarnation` of `service` of the run at `root`.
///
/// # Errors
/// [`RuntimeError::GroupFile`] if the list cannot be written.
pub fn enroll(
    root: &Path,
    service: Service,
    incarnation: u32,
    pid: u32,
) -> Result<(), RuntimeError> {
    let path = root.join(FILE);
    let line = format!("{} {incarnation} {pid}\n", service.to_wire());
    OpenOptions::new()
        .create(true)
        .append(true)
        .mode(0o600)
        .open(&path)
        .and_then(|mut file| file.write_all(line.as_bytes()))
        .map_err(|e| RuntimeError::GroupFile { path, reason: e.to_string() })
}

/// The list as a consumer reads it.
#[derive(Debug)]
pub(super) enum Members {
    /// The processes that the launcher wrote down in this file.
    Listed(PathBuf),
    /// All are in this process, and each has its service's number for a process id.
    InProcess,
}

impl Members {
    pub(super) fn of(root: &Path) -> Self {
        Self::Listed(root.join(FILE))
    }

    /// True if process `pid` is restart `incarnation` of service `source`. Reads the list anew, for
    /// it grows; callers remember the answer.
    pub(super) fn is_member(&self, source: u32, incarnation: u32, pid: u32) -> bool {
        let path = match self {
            Self::Listed(path) => path,
            Self::InProcess => return incarnation == 0 && source == pid,
        };
        let mut text = [0; 4096];
        let mut read = 0;
        let Ok(mut file) = std::fs::File::open(path) else { return false };
        let mut rest = ([0; 64], 0);
        while let Ok(count @ 1..) = file.read(&mut text) {
            for &byte in &text[..count] {
                if byte == b'\n' {
                    if parse(&rest.0[..rest.1]) == Some([source, incarnation, pid]) {
                        return true;
                    }
                    rest.1 = 0;
                } else if rest.1 < rest.0.len() {
                    rest.0[rest.1] = byte;
                    rest.1 += 1;
                }
            }
            read += count;
            if read > LONGEST_LIST {
                break;
            }
        }
        false
    }
}

fn parse(line: &[u8]) -> Option<[u32; 3]> {
    let mut numbers = std::str::from_utf8(line).ok()?.split(' ').map(str::parse);
    let mut next = || numbers.next()?.ok();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_processes_on_the_list_are_members() {
        let root = std::env::temp_dir().join(format!("timegap-members-{}", std::process::id()));
        std::fs::create_dir_all(&root).expect("the temporary directory is writable");
        let members = Members::of(&root);
        assert!(!members.is_member(4, 0, 17), "no list yet");
        for k in 0..400 {
            enroll(&root, Service::Controller, k, 1000 + k).expect("ours");
        }
        assert!(members.is_member(4, 0, 1000) && members.is_member(4, 399, 1399));
        assert!(!members.is_member(4, 1, 1000) && !members.is_member(1, 0, 1000));
        assert!(!members.is_member(4, 400, 1400));
        std::fs::remove_dir_all(&root).expect("ours");
    }
}
