//! UDP, to a multicast group or from a roadside unit to one vehicle.
//!
//! | | multicast | unicast |
//! | --- | --- | --- |
//! | roadside unit | sends to the group from a socket of its own | sends to the vehicle's address |
//! | vehicle | is a member of the group, shared with other vehicles of the host | listens at its address,
//! sends to its last sender |
//!
//! Questions go to the socket of a received frame, answers to that of the question. So a group does not carry them.

use crate::endpoint::{Endpoint, Origin, Outlet, Received};
use crate::error::{OpenError, SendError};
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::fd::OwnedFd;
use socket2::{Domain, InterfaceIndexOrAddress, Protocol, Socket, Type};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Opens both ends; `is_roadside` marks the roadside unit.
pub(crate) fn open(
    address: SocketAddr,
    interface: Option<&str>,
    is_roadside: bool,
) -> Result<(UdpEndpoint, UdpOutlet), OpenError> {
    let bind = |at: SocketAddr| {
        let bound = socket(at, interface);
        bound.map_err(|source| OpenError::Bind { address: at, source })
    };
    let index = interface.map(interface_index).transpose()?;
    let any: IpAddr = match address {
        SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let (own, group, target) = if address.ip().is_multicast() {
        // A link-local group cannot be bound without its link.
        let group = socket(address, interface).map_err(|source| match source.kind() {
            io::ErrorKind::InvalidInput => OpenError::Join { address, source },
            _ => OpenError::Bind { address, source },
        })?;
        join(&group, address.ip(), index).map_err(|source| OpenError::Join { address, source })?;
        let scope = match address {
            SocketAddr::V6(mut address) => {
                address.set_scope_id(index.unwrap_or(0));
                address.into()
            }
            SocketAddr::V4(_) => address,
        };
        (bind(SocketAddr::new(any, 0))?, Some(group), Target::Fixed(scope))
    } else if is_roadside {
        (bind(SocketAddr::new(any, 0))?, None, Target::Fixed(address))
    } else {
        (bind(address)?, None, Target::LastHeard(Arc::default()))
    };
    let closing = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)
        .map_err(|e| OpenError::SetUp(e.into()))?;
    let (own, closing) = (Arc::new(UdpSocket::from(own)), Arc::new(closing));
    let endpoint = UdpEndpoint {
        own: Arc::clone(&own),
        group: group.map(UdpSocket::from),
        closing: Arc::clone(&closing),
        target: target.clone(),
    };
    Ok((endpoint, UdpOutlet { own, closing, target }))
}

/// Destination of frames.
#[derive(Clone, Debug)]
enum Target {
    Fixed(SocketAddr),
    LastHeard(Arc<Mutex<Option<SocketAddr>>>),
}

fn socket(at: SocketAddr, interface: Option<&str>) -> io::Result<Socket> {
    let socket = Socket::new(Domain::for_address(at), Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    if at.ip().is_multicast() {
        // Several vehicles of one host receive the same group.
        socket.set_reuse_address(true)?;
    }
    if let Some(name) = interface {
        socket.bind_device(Some(name.as_bytes()))?;
    }
    socket.bind(&at.into())?;
    Ok(socket)
}

fn join(socket: &Socket, group: IpAddr, index: Option<u32>) -> io::Result<()> {
    match group {
        IpAddr::V4(group) => {
            let interface = InterfaceIndexOrAddress::Index(index.unwrap_or(0));
            socket.join_multicast_v4_n(&group, &interface)
        }
        IpAddr::V6(group) => socket.join_multicast_v6(&group, index.unwrap_or(0)),
    }
}

fn interface_index(name: &str) -> Result<u32, OpenError> {
    let fail = |source| OpenError::Interface { name: name.to_owned(), source };
    let family = rustix::net::AddressFamily::INET;
    let socket = rustix::net::socket(family, rustix::net::SocketType::DGRAM, None)
        .map_err(|e| fail(e.into()))?;
    rustix::net::netdevice::name_to_index(&socket, name).map_err(|e| fail(e.into()))
}

#[derive(Debug)]
pub(crate) struct UdpEndpoint {
    own: Arc<UdpSocket>,
    group: Option<UdpSocket>,
    closing: Arc<OwnedFd>,
    target: Target,
}

impl UdpEndpoint {
    fn take(&self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        let sockets = [Some(&*self.own), self.group.as_ref()];
        // An error of a socket belongs to an earlier sending: a closed port, a link that is down.
        sockets.into_iter().flatten().find_map(|socket| socket.recv_from(buffer).ok())
    }
}

impl Endpoint for UdpEndpoint {
    fn receive(&mut self, timeout: Duration, buffer: &mut [u8]) -> Received {
        let taken = self.take(buffer).or_else(|| {
            let group = self.group.as_ref().unwrap_or(&self.own);
            let mut sources = [
                PollFd::new(&self.closing, PollFlags::IN),
                PollFd::new(&self.own, PollFlags::IN),
                PollFd::new(group, PollFlags::IN),
            ];
            let timeout = Timespec::try_from(timeout).ok();
            // An interrupted wait ends early.
            let _ = poll(&mut sources, timeout.as_ref());
            self.take(buffer)
        });
        let mut closing = [PollFd::new(&self.closing, PollFlags::IN)];
        if poll(&mut closing, Some(&Timespec::default())).is_ok_and(|ready| ready > 0) {
            return Received::Closed;
        }
        let Some((length, from)) = taken else { return Received::Nothing };
        if let Target::LastHeard(last) = &self.target
            && let Ok(mut last) = last.lock()
        {
            *last = Some(from);
        }
        Received::Packet(length, Origin::Socket(from))
    }

    fn send(&mut self, to: Origin, _: Option<u64>, packet: &[u8]) {
        match to {
            Origin::Socket(to) => {
                // A lost one is repeated later.
                let _ = self.own.send_to(packet, to);
            }
            #[cfg(feature = "zenoh")]
            Origin::Zenoh => {}
        }
    }
}

/// The sending end.
#[derive(Debug)]
pub(crate) struct UdpOutlet {
    own: Arc<UdpSocket>,
    closing: Arc<OwnedFd>,
    target: Target,
}

impl Outlet for UdpOutlet {
    fn send(&mut self, packet: &[u8]) -> Result<(), SendError> {
        let target = match &self.target {
            Target::Fixed(address) => Some(*address),
            Target::LastHeard(last) => last.try_lock().ok().and_then(|last| *last),
        };
        let target = target.ok_or(SendError::NoTarget)?;
        let mut sent = self.own.send_to(packet, target);
        if matches!(&sent, Err(e) if e.kind() == io::ErrorKind::ConnectionRefused) {
            // The refusal of an earlier packet.
            sent = self.own.send_to(packet, target);
        }
        sent.map(drop).map_err(SendError::Kernel)
    }

    fn close(&mut self) {
        // A full counter was written before.
        let _ = rustix::io::write(&*self.closing, &1u64.to_ne_bytes());
    }
}
