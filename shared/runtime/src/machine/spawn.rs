//! Starting a process so that it inherits nothing by accident, and does not outlive its parent.

#![allow(unsafe_code, reason = "code between fork and exec is unsafe by its nature")]

use rustix::io::{FdFlags, fcntl_setfd};
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, SocketFlags, SocketType, connect, recvmsg, sendmsg,
    socket_with,
};
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::net::{Ipv4Addr, SocketAddrV4, TcpStream};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixDatagram;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Room for the one descriptor that a message carries.
const SPACE: usize = rustix::cmsg_space!(ScmRights(1));

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
                    send_descriptor(&sender, &socket);
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
            self.socket = receive_descriptor(&self.receiver);
        }
        let Some(socket) = &self.socket else { return Ok(None) };
        connect(socket, &SocketAddrV4::new(Ipv4Addr::LOCALHOST, port))?;
        Ok(self.socket.take().map(TcpStream::from))
    }
}

/// Moves this process, between fork and exec, to a network of its own; a socket in it.
fn enter_own_network() -> Option<OwnedFd> {
    let alone = libc::CLONE_NEWNET;
    // SAFETY: the process has one thread, and keeps its files and memory.
    if unsafe { libc::unshare(alone) != 0 && libc::unshare(alone | libc::CLONE_NEWUSER) != 0 } {
        return None;
    }
    let (family, kind) = (AddressFamily::INET, SocketType::STREAM);
    let socket = socket_with(family, kind, SocketFlags::CLOEXEC, None).ok()?;
    // SAFETY: a struct of numbers and pointers, for which zeros are valid.
    let mut request: libc::ifreq = unsafe { std::mem::zeroed() };
    request.ifr_name[0] = b'l' as libc::c_char;
    request.ifr_name[1] = b'o' as libc::c_char;
    request.ifr_ifru.ifru_flags = libc::IFF_UP as libc::c_short;
    // SAFETY: the call reads the struct of this frame.
    let up = unsafe { libc::ioctl(socket.as_raw_fd(), libc::SIOCSIFFLAGS as _, &raw mut request) };
    (up == 0).then_some(socket)
}

fn send_descriptor(sender: &UnixDatagram, socket: &OwnedFd) {
    let (mut space, sockets) = ([MaybeUninit::uninit(); SPACE], [socket.as_fd()]);
    let mut carried = SendAncillaryBuffer::new(&mut space);
    carried.push(SendAncillaryMessage::ScmRights(&sockets));
    // The other end waits for nothing.
    let _ = sendmsg(sender, &[IoSlice::new(&[0])], &mut carried, SendFlags::empty());
}

fn receive_descriptor(receiver: &UnixDatagram) -> Option<OwnedFd> {
    let (mut space, mut byte) = ([MaybeUninit::uninit(); SPACE], [0]);
    let mut carried = RecvAncillaryBuffer::new(&mut space);
    let bytes = &mut [IoSliceMut::new(&mut byte)];
    recvmsg(receiver, bytes, &mut carried, RecvFlags::CMSG_CLOEXEC).ok()?;
    carried.drain().find_map(|message| match message {
        RecvAncillaryMessage::ScmRights(mut sockets) => sockets.next(),
        _ => None,
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Accepts one connection to the port of its argument.
    const SERVER: &str = "import socket, sys\n\
        socket.create_server((\"127.0.0.1\", int(sys.argv[1]))).accept()[0].sendall(b\"in\")";

    #[test]
    fn a_process_in_its_own_network_is_reached_through_its_socket_alone() {
        const PORT: u16 = 47_123;
        let mut command = Command::new("python3");
        command.args(["-c", SERVER, &PORT.to_string()]);
        let mut network = OwnNetwork::of(&mut command).expect("a pair of sockets");
        die_with_this_thread(&mut command);
        let Ok(mut child) = command.spawn() else { return };
        let found = loop {
            match network.connect(PORT) {
                Ok(found) => break found,
                Err(_) => assert!(child.try_wait().expect("ours").is_none(), "it listens"),
            }
        };
        // A kernel may refuse a network.
        if let Some(mut stream) = found {
            assert!(TcpStream::connect(("127.0.0.1", PORT)).is_err(), "it is not of this network");
            let mut said = String::new();
            io::Read::read_to_string(&mut stream, &mut said).expect("it answers");
            assert_eq!(said, "in");
        }
        let _ = child.kill();
        child.wait().expect("ours");
    }
}
