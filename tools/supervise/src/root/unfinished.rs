//! Shared memory that a process was making when it was killed.
//!
//! iceoryx2 first makes an object without content and without the permission to read it. Then it gives it its size, and
//! last the permission. A process that finds an object without content waits for its maker. With the right to read
//! everything (as root) it waits for ever, and so do the launcher and every service. So the unfinished objects of a
//! process are removed as soon as it is gone. Other threads may be waiting.

use crate::root::room::SHARED_MEMORY;
use std::os::unix::fs::MetadataExt;
use std::time::{Duration, SystemTime};

/// Time for which an object without content and without a maker's process in its name is left alone.
const YOUNG: Duration = Duration::from_millis(100);
/// The bits of an object's mode while it is made: its owner may write it, and nothing else is granted.
const UNFINISHED: u32 = 0o200;

/// Removes what process `pid` of the run with this prefix, which is gone, has not finished.
pub fn remove_unfinished(prefix: &str, pid: u32) {
    for entry in std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str().and_then(|name| name.strip_prefix(prefix)) else { continue };
        // Another process may have removed it.
        let Ok(found) = entry.metadata() else { continue };
        if found.size() > 0 || found.mode() & 0o777 != UNFINISHED {
            continue;
        }
        let age =
            found.modified().ok().and_then(|then| SystemTime::now().duration_since(then).ok());
        if names(name, pid) || age.is_some_and(|age| age > YOUNG) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// True if one of the numbers in an object's name is a port's id of this process. iceoryx2's ids
/// are seconds, nanoseconds, process and counter.
fn names(name: &str, pid: u32) -> bool {
    let ids = name.split(['_', '.']).filter_map(|part| part.parse::<u128>().ok());
    ids.into_iter().any(|id| (id >> 64) as u32 == pid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::path::PathBuf;

    #[test]
    fn only_what_the_dead_process_was_making_is_removed() {
        let prefix = format!("timegap_unfinished-{}_", std::process::id());
        let id = |pid: u32| (7_u128 << 96) | (u128::from(pid) << 64) | 99;
        let make = |name: &str, mode: u32, text: &str| {
            let path = PathBuf::from(SHARED_MEMORY).join(format!("{prefix}{name}"));
            std::fs::write(&path, text).expect("shared memory is writable");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).expect("ours");
            path
        };
        let dead = make(&format!("_a1_{}_{}.connection", id(17), id(18)), 0o200, "");
        let others = make(&format!("_a1_{}_{}.connection", id(19), id(18)), 0o200, "");
        let whole = make(&format!("_a1_{}.data", id(17)), 0o600, "");
        let sized = make(&format!("_b1_{}.data", id(17)), 0o200, "x");
        remove_unfinished(&prefix, 17);
        let left = [&dead, &others, &whole, &sized].map(|path| path.exists());
        for path in [&others, &whole, &sized] {
            std::fs::remove_file(path).expect("ours");
        }
        assert_eq!(left, [false, true, true, true]);
    }
}
