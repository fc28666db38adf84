//! The same message over sockets.

use super::{MiddlewareError, Receiving, Sending, failed, patiently};
use messages::RadarTracks;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Bytes of the message.
const BYTES: usize = size_of::<RadarTracks>();

/// One end of a lossless connection: it waits for room or for a message.
#[derive(Debug)]
pub enum Socket {
    /// A unix datagram socket.
    Datagram(UnixDatagram),
    /// TCP on the loopback device, without delay.
    Tcp(TcpStream),
}

fn datagram_path(root: &Path) -> PathBuf {
    root.join("bench.sock")
}

fn port_path(root: &Path) -> PathBuf {
    root.join("bench.port")
}

/// Removes the names of both ends for the next comparison.
pub fn forget(root: &Path) {
    for path in [datagram_path(root), port_path(root)] {
        // Absent unless a comparison used it.
        let _ = std::fs::remove_file(path);
    }
}

impl Socket {
    /// The receiving end of a datagram socket below `root`.
    pub fn datagram_sink(root: &Path) -> Result<Self, MiddlewareError> {
        UnixDatagram::bind(datagram_path(root)).map(Self::Datagram).map_err(failed("unix datagram"))
    }

    /// The sending end, once the receiving one exists.
    pub fn datagram_source(root: &Path) -> Result<Self, MiddlewareError> {
        let connect = || {
            let socket = UnixDatagram::unbound()?;
            socket.connect(datagram_path(root))?;
            Ok(socket)
        };
        patiently(connect).map(Self::Datagram).map_err(failed("unix datagram"))
    }

    /// The receiving end of a connection; waits for the sending one.
    pub fn tcp_sink(root: &Path) -> Result<Self, MiddlewareError> {
        let accept = || {
            let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
            let port = listener.local_addr()?.port().to_string();
            // Renamed when complete, so that the other end never reads half a number.
            let part = root.join(".bench.port.part");
            std::fs::write(&part, port)?;
            std::fs::rename(part, port_path(root))?;
            listener.accept().map(|(stream, _)| stream)
        };
        accept().map(Self::Tcp).map_err(failed("tcp"))
    }

    /// The sending end, once the receiving one exists.
    pub fn tcp_source(root: &Path) -> Result<Self, MiddlewareError> {
        let connect = || {
            let port = std::fs::read_to_string(port_path(root))?;
            let port: u16 = port.parse().map_err(std::io::Error::other)?;
            let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
            stream.set_nodelay(true)?;
            Ok(stream)
        };
        patiently(connect).map(Self::Tcp).map_err(failed("tcp"))
    }
}

impl Sending for Socket {
    fn send(&mut self, message: &RadarTracks) -> Result<(), MiddlewareError> {
        let bytes = bytemuck::bytes_of(message);
        match self {
            Self::Datagram(socket) => socket.send(bytes).map(|_| ()),
            Self::Tcp(stream) => stream.write_all(bytes),
        }
        .map_err(failed("cannot send"))
    }
}

impl Receiving for Socket {
    /// Waits for one message without a limit: none is lost.
    fn receive(&mut self, _: Duration, each: &mut dyn FnMut(i64)) -> Result<(), MiddlewareError> {
        let mut bytes = [0_u8; BYTES];
        match self {
            Self::Datagram(socket) => socket.recv(&mut bytes).map(|_| ()),
            Self::Tcp(stream) => stream.read_exact(&mut bytes),
        }
        .map_err(failed("cannot receive"))?;
        let message: RadarTracks = bytemuck::pod_read_unaligned(&bytes);
        each(message.header.acquisition_ns);
        Ok(())
    }
}
