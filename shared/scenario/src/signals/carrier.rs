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

impl CarrierAddress {
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

    /// The address in a text; `None` if it names no carrier.
    pub(crate) fn read(text: &str) -> Option<Result<Self, CarrierAddressError>> {
        if text == "zenoh" {
            return Some(Ok(Self::Zenoh { configuration: None }));
        }
        let (scheme, rest) = text.split_once(':')?;
        let file = || match rest {
            "" => Err(format!("`{scheme}:` lacks the file, expected {scheme}:FILE")),
            path => Ok(PathBuf::from(path)),
        };
        let address = match scheme {
            "udp" => udp(rest.strip_prefix("//")?),
            "zenoh" => file().map(|file| Self::Zenoh { configuration: Some(file) }),
            "pcap" => file().map(|file| Self::Capture { file }),
            _ => return None,
        };
        Some(address.map_err(CarrierAddressError))
    }
}

/// Reason why a text is not the address of a carrier.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CarrierAddressError(String);

impl FromStr for CarrierAddress {
    type Err = CarrierAddressError;

    fn from_str(text: &str) -> Result<Self, CarrierAddressError> {
        Self::read(text).unwrap_or_else(|| {
            let expected = "udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5 or pcap:FILE";
            Err(CarrierAddressError(format!("`{text}` names no carrier, expected {expected}")))
        })
    }
}

fn udp(rest: &str) -> Result<CarrierAddress, String> {
    let (socket, option) =
        rest.split_once('?').map_or((rest, None), |(socket, option)| (socket, Some(option)));
    let address: SocketAddr = socket.parse().map_err(|_| {
        let expected = "udp://239.255.3.1:5520 or udp://[ff02::114]:5520";
        format!("`{socket}` is not an IP address with a port, expected {expected}")
    })?;
    // It cannot be agreed on.
    if address.port() == 0 {
        return Err("port 0 is not a port to agree on, expected 1 to 65535".to_owned());
    }
    let name = |option: &str| {
        let name = option.strip_prefix("interface=").filter(|name| !name.is_empty());
        let refused = || format!("`{option}` is not an option of udp://, expected ?interface=NAME");
        name.map(str::to_owned).ok_or_else(refused)
    };
    Ok(CarrierAddress::Udp { address, interface: option.map(name).transpose()? })
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
