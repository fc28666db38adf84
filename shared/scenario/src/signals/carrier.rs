//! Source of radio frames when the roadside unit is not in the group: a carrier's address.
//!
//! | address | carrier |
//! | --- | --- |
//! | `udp://239.255.3.1:5520`, `udp://[ff02::114]:5520?interface=eth0` | UDP to a multicast group |
//! | `udp://192.0.2.7:5520` | UDP to one vehicle, at which it listens |
//! | `zenoh`, `zenoh:FILE.json5` | zenoh, as a peer that finds others, or as its configuration file says |
//! | `pcap:FILE` | a capture, played from the start of the run |

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The address of a carrier of radio frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CarrierAddress {
    Udp {
        /// A multicast group, or the vehicle's own address.
        address: SocketAddr,
        /// Network interface to send and receive on; absent: the kernel's choice.
        interface: Option<String>,
    },
    Zenoh {
        /// zenoh's configuration file; absent: zenoh's own defaults.
        configuration: Option<PathBuf>,
    },
    /// A capture, pcap or pcapng.
    Capture { file: PathBuf },
}

/// Text that is not a carrier's address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CarrierAddressError {
    #[error(
        "`{0}` names no carrier, expected udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5 or pcap:FILE"
    )]
    Scheme(String),
    #[error(
        "`{0}` is not an IP address with a port, expected udp://239.255.3.1:5520 or udp://[ff02::114]:5520"
    )]
    Socket(String),
    /// Port 0 cannot be listened on by agreement.
    #[error("port 0 is not a port to agree on, expected 1 to 65535")]
    Port,
    #[error("`{0}` is not an option of udp://, expected ?interface=NAME")]
    Option(String),
    #[error("`{0}` lacks the file, expected {0}FILE")]
    File(&'static str),
}

impl CarrierAddress {
    /// True for UDP to a group, of which several vehicles can be members.
    pub fn is_multicast(&self) -> bool {
        matches!(self, Self::Udp { address, .. } if address.ip().is_multicast())
    }

    /// Settles where its file is, if it has one: a relative path begins in `directory`.
    pub fn place(&mut self, directory: &Path) {
        match self {
            Self::Udp { .. } | Self::Zenoh { configuration: None } => {}
            Self::Zenoh { configuration: Some(file) } | Self::Capture { file } => {
                *file = directory.join(&file);
            }
        }
    }

    /// True for a carrier whose frames come at their own wall-clock instants: everything but a capture.
    pub fn is_live(&self) -> bool {
        !matches!(self, Self::Capture { .. })
    }
}

impl FromStr for CarrierAddress {
    type Err = CarrierAddressError;

    fn from_str(text: &str) -> Result<Self, CarrierAddressError> {
        if let Some(rest) = text.strip_prefix("udp://") {
            return udp(rest);
        }
        if text == "zenoh" {
            return Ok(Self::Zenoh { configuration: None });
        }
        let file = |rest: &str, scheme| match rest {
            "" => Err(CarrierAddressError::File(scheme)),
            path => Ok(PathBuf::from(path)),
        };
        if let Some(rest) = text.strip_prefix("zenoh:") {
            return Ok(Self::Zenoh { configuration: Some(file(rest, "zenoh:")?) });
        }
        if let Some(rest) = text.strip_prefix("pcap:") {
            return Ok(Self::Capture { file: file(rest, "pcap:")? });
        }
        Err(CarrierAddressError::Scheme(text.to_owned()))
    }
}

fn udp(rest: &str) -> Result<CarrierAddress, CarrierAddressError> {
    let (socket, option) = match rest.split_once('?') {
        Some((socket, option)) => (socket, Some(option)),
        None => (rest, None),
    };
    let address: SocketAddr =
        socket.parse().map_err(|_| CarrierAddressError::Socket(socket.to_owned()))?;
    if address.port() == 0 {
        return Err(CarrierAddressError::Port);
    }
    let interface = match option {
        None => None,
        Some(option) => match option.strip_prefix("interface=") {
            Some(name) if !name.is_empty() => Some(name.to_owned()),
            _ => return Err(CarrierAddressError::Option(option.to_owned())),
        },
    };
    Ok(CarrierAddress::Udp { address, interface })
}

impl fmt::Display for CarrierAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Udp { address, interface: None } => write!(f, "udp://{address}"),
            Self::Udp { address, interface: Some(name) } => {
                write!(f, "udp://{address}?interface={name}")
            }
            Self::Zenoh { configuration: None } => f.write_str("zenoh"),
            Self::Zenoh { configuration: Some(file) } => write!(f, "zenoh:{}", file.display()),
            Self::Capture { file } => write!(f, "pcap:{}", file.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_read_back_as_they_are_written() {
        for text in [
            "udp://239.255.3.1:5520",
            "udp://[ff02::114]:5520?interface=eth0",
            "udp://192.0.2.7:5520",
            "zenoh",
            "zenoh:vehicle.json5",
            "pcap:drive.pcapng",
        ] {
            let address: CarrierAddress = text.parse().expect(text);
            assert_eq!(address.to_string(), text);
        }
        let group: CarrierAddress = "udp://239.255.3.1:5520".parse().expect("a group");
        let one: CarrierAddress = "udp://192.0.2.7:5520".parse().expect("one vehicle");
        assert!(group.is_multicast() && !one.is_multicast());
    }

    #[test]
    fn a_text_that_is_not_an_address_is_named() {
        for (text, said) in [
            ("", "names no carrier"),
            ("tcp://1.2.3.4:5", "names no carrier"),
            ("udp://somewhere:5520", "`somewhere:5520` is not an IP address with a port"),
            ("udp://1.2.3.4", "is not an IP address with a port"),
            ("udp://1.2.3.4:0", "port 0"),
            ("udp://1.2.3.4:5?ttl=3", "`ttl=3` is not an option"),
            ("udp://1.2.3.4:5?interface=", "is not an option"),
            ("zenoh:", "expected zenoh:FILE"),
            ("pcap:", "expected pcap:FILE"),
        ] {
            let error = text.parse::<CarrierAddress>().expect_err(text).to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
