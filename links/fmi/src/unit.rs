//! A unit as a file: read, checked and wired without any of its code.

use crate::UnitError;
use crate::archive::Archive;
use crate::description::{Description, FILE, Version};
use crate::quantity::{LAW, Motion, Quantity, Request, VEHICLE};
use crate::wiring::Wiring;
use messages::{LawAnswer, LawInput};
use std::path::Path;

/// Longest model description, bytes.
const MAX_DESCRIPTION: u64 = 16 << 20;

/// Most speed that a vehicle gains or loses in its first period, m/s. Chosen: a crash loses more.
const MOST_GAINED_MPS: f64 = 1.0;

/// A unit that fits its part.
pub struct Unit<Q: 'static, A: 'static> {
    /// Name of its file, for errors.
    pub(crate) name: String,
    pub(crate) archive: Archive,
    pub(crate) description: Description,
    pub(crate) wiring: Wiring<Q, A>,
    /// Its library inside the archive.
    pub(crate) library: String,
}

pub trait Part<A: 'static>: Sized + 'static {
    const QUANTITIES: &'static [Quantity<Self, A>];
    /// Quantities without which a unit is of no use; alternatives stand in one text.
    const NEEDED: &'static [&'static str];

    /// Number, reset, time and period of a question, s.
    fn head(&self) -> (u64, u64, f64, f64);

    /// Fault of the answer to a question that began anew, and what was expected.
    fn fault(&self, _answer: &A) -> Option<(String, String)> {
        None
    }
}

impl Part<LawAnswer> for LawInput {
    const QUANTITIES: &'static [Quantity<Self, LawAnswer>] = LAW;
    const NEEDED: &'static [&'static str] =
        &["request_mps2", "speed_mps|gap_m|relative_speed_mps|set_speed_mps|target_speed_mps"];

    fn head(&self) -> (u64, u64, f64, f64) {
        (self.sequence, self.reset, self.time_s, self.period_s)
    }
}

impl Part<Motion> for Request {
    const QUANTITIES: &'static [Quantity<Self, Motion>] = VEHICLE;
    const NEEDED: &'static [&'static str] =
        &["speed_mps", "request_mps2|throttle", "request_mps2|brake"];

    fn head(&self) -> (u64, u64, f64, f64) {
        (self.sequence, self.reset, self.time_s, self.period_s)
    }

    fn fault(&self, answer: &Motion) -> Option<(String, String)> {
        let gained_mps = (answer.speed_mps - self.speed_mps).abs();
        (gained_mps > MOST_GAINED_MPS).then(|| {
            let (begun, expected) = (answer.speed_mps, self.speed_mps);
            let parameter = "a parameter or a start for initial_speed_mps";
            (format!("begins at {begun} m/s"), format!("{expected} m/s by {parameter}"))
        })
    }
}

impl<A: 'static, Q: Part<A>> Unit<Q, A> {
    /// Reads a unit and wires it; `words` are those behind it in a command.
    ///
    /// # Errors
    /// Names the part of the unit that is wrong, and what was expected.
    pub fn read(path: &Path, words: &[String]) -> Result<Self, UnitError> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let archive = Archive::open(path)?;
        let text = archive.read(FILE, MAX_DESCRIPTION)?;
        let description = Description::read(&name, &String::from_utf8_lossy(&text))?;
        let library = library(&archive, &name, &description)?;
        let wiring = Wiring::of(&name, &description, Q::QUANTITIES, Q::NEEDED, words)?;
        Ok(Self { name, archive, description, wiring, library })
    }

    pub fn begins_as_given(&self) -> bool {
        self.wiring.has("initial_speed_mps")
    }
}

/// Name of this machine's folder of libraries.
pub fn platform(version: Version) -> String {
    match (version, std::env::consts::ARCH) {
        (Version::Two, "x86_64") => "linux64".to_owned(),
        (_, machine) => format!("{machine}-linux"),
    }
}

fn library(archive: &Archive, unit: &str, what: &Description) -> Result<String, UnitError> {
    let library = format!("binaries/{}/{}.so", platform(what.version), what.identifier);
    if archive.names().any(|name| name == library) {
        return Ok(library);
    }
    let others = archive.names().filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'));
    let mut others: Vec<_> = others.map(|(platform, _)| platform).collect();
    others.dedup();
    let fault = match others.is_empty() {
        true => "it has no binaries".to_owned(),
        false => format!("it has no `{library}`, and binaries for {}", others.join(", ")),
    };
    Err(UnitError::new(unit, fault, format!("`{library}` for this machine")))
}
