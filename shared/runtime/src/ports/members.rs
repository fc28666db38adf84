//! Members of the group: which process is which restart of which service, and which processes only
//! listen.
//!
//! The launcher writes down every process that it starts, and itself. A consumer looks a sender up at its first
//! message. In lockstep a sender looks a listener up before it waits for it. A process of the same user that opens a
//! topic on its own is not a member. Its messages are not used, and no sender waits for it.

use crate::RuntimeError;
use messages::Service;
use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// Name of the list in the run's root.
const FILE: &str = "members";
/// A line is a service as a number, an incarnation and a process id, or [`LISTENER`] and a process id.
const LISTENER: &str = "listener";
/// Longest list that is read, bytes.
const LONGEST_LIST: usize = 64 * 1024;
/// Lines from which on those of processes that are gone are taken out.
const MANY_LINES: usize = 128;
/// Newest lines, which stay: messages of a process that is gone may still be on their way.
const NEWEST_LINES: usize = 64;

/// Enters process `pid` as restart `incarnation` of `service` of the run at `root`.
pub fn enroll(
    root: &Path,
    service: Service,
    incarnation: u32,
    pid: u32,
) -> Result<(), RuntimeError> {
    append(root, &format!("{} {incarnation} {pid}\n", service.to_wire()))?;
    thin_out(root)
}

/// Enters process `pid` as one that listens to the run at `root`: in lockstep senders wait for it.
pub fn enroll_listener(root: &Path, pid: u32) -> Result<(), RuntimeError> {
    append(root, &format!("{LISTENER} {pid}\n"))
}

fn append(root: &Path, line: &str) -> Result<(), RuntimeError> {
    let path = root.join(FILE);
    OpenOptions::new()
        .create(true)
        .append(true)
        .mode(0o600)
        .open(&path)
        .and_then(|mut file| file.write_all(line.as_bytes()))
        .map_err(RuntimeError::file(&path))
}

/// Takes processes that are gone out of a long list. Readers find the list before or after that.
fn thin_out(root: &Path) -> Result<(), RuntimeError> {
    let path = root.join(FILE);
    let text = std::fs::read_to_string(&path).map_err(RuntimeError::file(&path))?;
    let lines: Vec<&str> = text.lines().collect();
    let Some(old) = lines.len().checked_sub(NEWEST_LINES).filter(|_| lines.len() > MANY_LINES)
    else {
        return Ok(());
    };
    let lives = |line: &&&str| {
        let pid = line.rsplit(' ').next().unwrap_or_default();
        Path::new("/proc").join(pid).exists()
    };
    let kept: Vec<&str> = lines[..old].iter().filter(lives).chain(&lines[old..]).copied().collect();
    let thinner = root.join("members.new");
    let written = std::fs::write(&thinner, kept.join("\n") + "\n");
    written.and_then(|()| std::fs::rename(&thinner, &path)).map_err(RuntimeError::file(&path))
}

/// The processes that the launcher wrote down, in this file.
#[derive(Debug)]
pub(crate) struct Members(PathBuf);

impl Members {
    pub(crate) fn of(root: &Path) -> Self {
        Self(root.join(FILE))
    }

    /// True if process `pid` is restart `incarnation` of service `source`. Reads the list again, as
    /// it grows; callers keep the answer.
    pub(crate) fn is_member(&self, source: u32, incarnation: u32, pid: u32) -> bool {
        find(&self.0, |line| service(line) == Some([source, incarnation, pid]))
    }

    /// True if process `pid` is any service of the group, or one of its listeners.
    pub(crate) fn is_in_group(&self, pid: u32) -> bool {
        find(&self.0, |line| {
            service(line).is_some_and(|[_, _, known]| known == pid) || listener(line) == Some(pid)
        })
    }
}

/// True if `is_it` says so of a line of the list. Allocates nothing.
fn find(path: &Path, is_it: impl Fn(&[u8]) -> bool) -> bool {
    let mut text = [0; 4096];
    let mut read = 0;
    let Ok(mut file) = std::fs::File::open(path) else { return false };
    let mut rest = ([0; 64], 0);
    while let Ok(count @ 1..) = file.read(&mut text) {
        for &byte in &text[..count] {
            if byte == b'\n' {
                if is_it(&rest.0[..rest.1]) {
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

/// Service, incarnation and process id.
fn service(line: &[u8]) -> Option<[u32; 3]> {
    let mut numbers = std::str::from_utf8(line).ok()?.split(' ').map(str::parse);
    let mut next = || numbers.next()?.ok();
    Some([next()?, next()?, next()?])
}

/// Process id of a listener.
fn listener(line: &[u8]) -> Option<u32> {
    let pid = std::str::from_utf8(line).ok()?.strip_prefix(LISTENER)?;
    pid.strip_prefix(' ')?.parse().ok()
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
        // As many as a long run with many restarts has; this test itself is one that lives.
        let living = std::process::id();
        enroll(&root, Service::Plant, 0, living).expect("ours");
        let gone = 0x4000_0000;
        for k in 0..10_000 {
            enroll(&root, Service::Controller, k, gone + k).expect("ours");
        }
        assert!(members.is_member(1, 0, living), "it lives");
        assert!(members.is_member(4, 9_999, gone + 9_999), "it was there until just now");
        assert!(members.is_member(4, 9_950, gone + 9_950));
        assert!(!members.is_member(4, 9_998, gone + 9_999) && !members.is_member(1, 0, gone));
        assert!(!members.is_member(4, 10_000, gone + 10_000));
        let length = std::fs::metadata(root.join(FILE)).expect("ours").len();
        assert!(length < 8_192, "{length} bytes");
        enroll_listener(&root, 77).expect("ours");
        assert!(members.is_in_group(77) && members.is_in_group(gone + 9_999));
        assert!(!members.is_in_group(78) && !members.is_in_group(7));
        assert!((0..8).all(|source| !members.is_member(source, 0, 77)), "it sends nothing");
        std::fs::remove_dir_all(&root).expect("ours");
    }
}
