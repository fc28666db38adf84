//! Starting a process so that it inherits nothing by accident, and does not outlive its parent.

#![allow(unsafe_code, reason = "code between fork and exec is unsafe by its nature")]

use rustix::io::{FdFlags, fcntl_setfd};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use std::io;
use std::net::TcpStream;
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::os::unix::net::UnixDatagram;
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

/// A network of its own for a process, whose sockets nothing else on the machine or beyond it reaches.
#[derive(Debug)]
pub struct OwnNetwork {
    receiver: UnixDatagram,
    socket: Option<OwnedFd>,
}

impl OwnNetwork {
    /// Gives the process of `command` a network of its own where the kernel grants it.
    ///
    /// # Errors
    /// If the system has no pair of sockets left.
    pub fn of(command: &mut Command) -> io::Result<Self> {
        let (receiver, sender) = UnixDatagram::pair()?;
        receiver.set_nonblocking(true)?;
        // SAFETY: the closure runs between fork and exec and makes async-signal-safe system calls alone. The kernel keeps
        // a socket in the network in which it was made.
        unsafe {
            command.pre_exec(move || {
                if let Some(socket) = enter_own_network() {
                    send_descriptor(sender.as_raw_fd(), socket);
                }
                Ok(())
            });
        }
        Ok(Self { receiver, socket: None })
    }

    /// Connects to a port on which the process listens; `None` if it has no network of its own.
    ///
    /// # Errors
    /// While it does not listen yet.
    pub fn connect(&mut self, port: u16) -> io::Result<Option<TcpStream>> {
        if self.socket.is_none() {
            self.socket = receive_descriptor(self.receiver.as_raw_fd());
        }
        let Some(socket) = &self.socket else { return Ok(None) };
        let address = libc::sockaddr_in {
            sin_family: libc::AF_INET as libc::sa_family_t,
            sin_port: port.to_be(),
            sin_addr: libc::in_addr { s_addr: u32::from_ne_bytes([127, 0, 0, 1]) },
            sin_zero: [0; 8],
        };
        let size = size_of_val(&address) as libc::socklen_t;
        // SAFETY: the address is a whole `sockaddr_in`, and the socket is open.
        let result =
            unsafe { libc::connect(socket.as_raw_fd(), (&raw const address).cast(), size) };
        if result != 0 {
            return Err(io::Error::last_os_error());
        }
        Ok(self.socket.take().map(TcpStream::from))
    }
}

/// Moves this process, between fork and exec, to a network of its own; a socket in it.
fn enter_own_network() -> Option<RawFd> {
    // SAFETY: system calls on plain structs of this frame.
    unsafe {
        let alone = libc::CLONE_NEWNET;
        if libc::unshare(alone) != 0 && libc::unshare(alone | libc::CLONE_NEWUSER) != 0 {
            return None;
        }
        let kind = libc::SOCK_STREAM | libc::SOCK_CLOEXEC;
        let socket = libc::socket(libc::AF_INET, kind, 0);
        let mut request: libc::ifreq = std::mem::zeroed();
        request.ifr_name[0] = b'l' as libc::c_char;
        request.ifr_name[1] = b'o' as libc::c_char;
        request.ifr_ifru.ifru_flags = libc::IFF_UP as libc::c_short;
        let is_up = libc::ioctl(socket, libc::SIOCSIFFLAGS as _, &raw mut request) == 0;
        is_up.then_some(socket)
    }
}

/// Room for the one descriptor that a message carries.
#[repr(C, align(8))]
struct Carried([u8; 64]);

/// A message of one byte, with room for a descriptor.
fn message(byte: &mut libc::iovec, carried: &mut Carried) -> libc::msghdr {
    // SAFETY: a struct of numbers and pointers, for which zeros are valid.
    let mut message: libc::msghdr = unsafe { std::mem::zeroed() };
    (message.msg_iov, message.msg_iovlen) = (byte, 1);
    message.msg_control = carried.0.as_mut_ptr().cast();
    // SAFETY: arithmetic.
    message.msg_controllen = unsafe { libc::CMSG_SPACE(size_of::<RawFd>() as u32) } as _;
    message
}

fn send_descriptor(sender: RawFd, socket: RawFd) {
    let (mut word, mut carried) = ([0_u8], Carried([0; 64]));
    let mut byte = libc::iovec { iov_base: word.as_mut_ptr().cast(), iov_len: 1 };
    let message = message(&mut byte, &mut carried);
    // SAFETY: the header points into `carried`, which has room for one descriptor.
    unsafe {
        let header = libc::CMSG_FIRSTHDR(&raw const message);
        (*header).cmsg_level = libc::SOL_SOCKET;
        (*header).cmsg_type = libc::SCM_RIGHTS;
        (*header).cmsg_len = libc::CMSG_LEN(size_of::<RawFd>() as u32) as _;
        libc::CMSG_DATA(header).cast::<RawFd>().write_unaligned(socket);
        libc::sendmsg(sender, &raw const message, 0);
    }
}

fn receive_descriptor(receiver: RawFd) -> Option<OwnedFd> {
    let (mut word, mut carried) = ([0_u8], Carried([0; 64]));
    let mut byte = libc::iovec { iov_base: word.as_mut_ptr().cast(), iov_len: 1 };
    let mut message = message(&mut byte, &mut carried);
    // SAFETY: the kernel writes at most the room that the message names, and the descriptor that it hands over is ours.
    unsafe {
        if libc::recvmsg(receiver, &raw mut message, libc::MSG_CMSG_CLOEXEC) < 0 {
            return None;
        }
        let header = libc::CMSG_FIRSTHDR(&raw const message);
        let is_descriptor = !header.is_null() && (*header).cmsg_type == libc::SCM_RIGHTS;
        is_descriptor
            .then(|| OwnedFd::from_raw_fd(libc::CMSG_DATA(header).cast::<RawFd>().read_unaligned()))
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
