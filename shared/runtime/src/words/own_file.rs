//! Files in shared memory that are this user's own.
//!
//! Every user may make a file in `/dev/shm`, also one with the name of ours, before us. A page that another user can
//! truncate kills the processes that read it.

use rustix::fs::OFlags;
use std::fs::{File, OpenOptions};
use std::io::{Error, ErrorKind, Result};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

/// Makes the file at `path`, or opens the one that another process of this user made.
pub(crate) fn open_own(path: &Path) -> Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).mode(0o600).custom_flags(OFlags::NOFOLLOW.bits().cast_signed());
    match options.create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        made => return made,
    }
    open_existing_own(path)
}

/// Opens the file at `path` that a process of this user made.
pub(crate) fn open_existing_own(path: &Path) -> Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).custom_flags(OFlags::NOFOLLOW.bits().cast_signed());
    let file = options.open(path)?;
    let found = file.metadata()?;
    let own = rustix::process::geteuid().as_raw() == found.uid();
    if own && found.is_file() && found.mode() & 0o077 == 0 {
        Ok(file)
    } else {
        let what = format!("{} is not a file of this user alone", path.display());
        Err(Error::new(ErrorKind::PermissionDenied, what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_file_is_shared_within_a_user_and_refused_beyond() {
        let path = std::env::temp_dir().join(format!("timegap-own-{}", std::process::id()));
        drop(open_own(&path).expect("new"));
        drop(open_own(&path).expect("ours"));
        for (mode, why) in [(0o666, "others may write it"), (0o640, "others may read it")] {
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).expect("ours");
            assert!(open_own(&path).is_err(), "{why}");
        }
        std::fs::remove_file(&path).expect("ours");
        std::os::unix::fs::symlink("/dev/null", &path).expect("free again");
        assert!(open_own(&path).is_err(), "a link to something else");
        std::fs::remove_file(&path).expect("ours");
        if rustix::process::geteuid().is_root() {
            std::fs::write(&path, "").expect("writable");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).expect("ours");
            std::os::unix::fs::chown(&path, Some(65_534), None).expect("root may");
            assert!(open_own(&path).is_err(), "another user's");
            std::fs::remove_file(&path).expect("root may");
        }
    }
}
