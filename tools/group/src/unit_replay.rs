//! The on-board unit alone, in this thread: the recorded frames into it again.
//!
//! It is the unit of every run. Its releases and samples are the recorded ones; a player stands for all other
//! services.

use crate::Error;
use crate::report::ObuReport;
use messages::{Map, Odometry, Origin, RadioFrames, RadioSent, Service, Spat};
use recorder::{Recording, UnitTake};
use runtime::{FromService, InProcess, Played, RuntimeError, Sealing, Tap, Tapped};
use scenario::Scenario;

/// Messages of the on-board unit in a replay.
#[derive(Debug)]
pub enum UnitSaid<'a> {
    /// The stop lines ahead.
    Map(&'a Map),
    /// Their signals.
    Spat(&'a Spat),
    /// A frame of the vehicle's own.
    Sent(&'a RadioSent),
}

/// Gives the on-board unit of `scenario` the releases, frames and odometry of `take` in `recording`. `heard` gets all
/// its messages. Returns the unit's own figures.
///
/// # Errors
/// If the unit does not reach the end.
pub fn replay_unit(
    scenario: &Scenario,
    recording: &Recording,
    take: &UnitTake,
    heard: &mut dyn FnMut(UnitSaid<'_>),
) -> Result<ObuReport, Error> {
    let releases = recording.unit_cycles(take).map(|cycle| cycle.release()).collect();
    let mut run = InProcess::new(scenario, Sealing::Sealed);
    run.start_scheduled(Service::Obu, scenario, releases, obu::run)?;
    let mut ports = Ports::open(&run)?;
    let mut listener = Listener::open(&run.tap())?;
    let mut said = Said::default();
    run.take_turns(&mut |_, message| said.receive(message));
    run.begin();
    let mut cycles = recording.unit_cycles(take);
    loop {
        if let Some(cycle) = cycles.next() {
            ports.frames.send(cycle.batch(), cycle.frames.as_deref())?;
            let odometry = cycle.map.header.origins.odometry;
            ports.odometry.send(odometry, cycle.odometry.as_deref())?;
        }
        let is_alive = run.take_turns(&mut |_, message| said.receive(message));
        listener.listen(heard)?;
        if !is_alive {
            break;
        }
    }
    match said {
        Said { failed: Some(how), .. } => Err(broken(how)),
        Said { report: Some(report), .. } if listener.cycles == take.cycles => Ok(report),
        Said { .. } => Err(broken(format!("it ran {} cycles", listener.cycles))),
    }
}

fn broken(what: String) -> Error {
    let what = format!("broke the replay: {what}");
    Error::NotReady { service: Service::Obu, what, foreign: false }
}

/// Messages of the unit to its launcher.
#[derive(Default)]
struct Said {
    report: Option<ObuReport>,
    failed: Option<String>,
}

impl Said {
    fn receive(&mut self, message: FromService) {
        match message {
            FromService::Report(report) => {
                self.report = report.details.read();
            }
            FromService::Failed(how) => self.failed = Some(how),
            FromService::Ready(_) | FromService::TookOver(_) | FromService::Ended(_) => {}
        }
    }
}

/// The sending ends of the unit's inputs.
struct Ports {
    frames: Port<RadioFrames>,
    odometry: Port<Odometry>,
}

impl Ports {
    fn open(run: &InProcess) -> Result<Self, RuntimeError> {
        let player = run.player();
        Ok(Self { frames: Port::new(player.on()?), odometry: Port::new(player.on()?) })
    }
}

struct Port<T: messages::Message> {
    played: Played<T>,
    last: Origin,
}

impl<T: messages::Message> Port<T> {
    fn new(played: Played<T>) -> Self {
        Self { played, last: Origin::NONE }
    }

    /// Sends the sample of a cycle, unless the cycle before used it too.
    fn send(&mut self, origin: Origin, sample: Option<&[u8]>) -> Result<(), RuntimeError> {
        if let Some(sample) = sample.filter(|_| origin != self.last) {
            self.last = origin;
            self.played.send(sample)?;
        }
        Ok(())
    }
}

/// Hears the unit.
struct Listener {
    map: Tapped<Map>,
    spat: Tapped<Spat>,
    sent: Tapped<RadioSent>,
    cycles: u64,
}

impl Listener {
    fn open(tap: &Tap) -> Result<Self, RuntimeError> {
        Ok(Self { map: tap.on()?, spat: tap.on()?, sent: tap.on()?, cycles: 0 })
    }

    fn listen(&mut self, heard: &mut dyn FnMut(UnitSaid<'_>)) -> Result<(), RuntimeError> {
        let Self { map, spat, sent, cycles } = self;
        while map.take(|map| {
            *cycles += 1;
            heard(UnitSaid::Map(map));
        })? {}
        while spat.take(|spat| heard(UnitSaid::Spat(spat)))? {}
        while sent.take(|sent| heard(UnitSaid::Sent(sent)))? {}
        Ok(())
    }
}
