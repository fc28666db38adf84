//! Starting a process so that it inherits nothing by accident, and does not outlive its parent.

#![allow(unsafe_code, reason = "code between fork and exec is unsafe by its nature")]

use rustix::io::{FdFlags, fcntl_setfd};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use std::os::fd::{AsRawFd, BorrowedFd};
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Makes `command` inherit its standard streams and `keep`, and no other descriptor. iceoryx2's are not close-on-exec,
/// and a stray one would keep a dead run's lock.
pub fn inherit_only(command: &mut Command, keep: Option<BorrowedFd<'_>>) {
    let keep = keep.map(|keep| keep.as_raw_fd());
    // SAFETY: the closure runs between fork and exec and makes two async-signal-safe system calls. `keep` is open in
    // the parent at the fork, and so in the child.
    unsafe {
        command.pre_exec(move || {
            let closed =
                libc::syscall(libc::SYS_close_range, 3, u32::MAX, libc::CLOSE_RANGE_CLOEXEC);
            if closed != 0 {
                return Err(std::io::Error::last_os_error());
            }
            if let Some(keep) = keep {
                fcntl_setfd(BorrowedFd::borrow_raw(keep), FdFlags::empty())?;
            }
            Ok(())
        });
    }
}

/// Makes the kernel kill the process of `command` when the thread that starts it ends, whatever ends it.
pub fn die_with_this_thread(command: &mut Command) {
    let parent = rustix::process::getpid();
    // SAFETY: the closure runs between fork and exec and makes two async-signal-safe system calls.
    unsafe {
        command.pre_exec(move || {
            set_parent_process_death_signal(Some(Signal::KILL))?;
            if getppid() == Some(parent) {
                Ok(())
            } else {
                // It died before the order could reach the kernel.
                Err(std::io::Error::from_raw_os_error(libc::ECHILD))
            }
        });
    }
}
