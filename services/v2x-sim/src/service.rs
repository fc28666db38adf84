//! The roadside unit's loop: present and coming phases, by radio and as ground truth.

use crate::air::Air;
use crate::cell_map::CellMap;
use crate::frames::Frames;
use crate::link::Link;
use crate::report::LinkReport;
use crate::roadside_unit::{RoadsideUnit, is_audible, near};
use crate::unit_clock::UnitClock;
use bytemuck::Zeroable;
use its::EncodeError;
use messages::{
    AnnouncedMotions, Curves, EgoTruth, Header, Lights, Map, Odometry, Origins, Preview,
    RadioFrames, ServiceState, SignalTruth, Spat,
};
use obu::awareness::Awareness;
use obu::clock::Moment;
use runtime::{Cycle, Overrun, Publisher, Runtime, RuntimeError, Subscriber};
use scenario::{Problem, Scenario};
use std::collections::BTreeMap;

/// Runs the roadside unit in its group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let unit = RoadsideUnit::new(&scenario.v2x);
    let mut ego = runtime.subscriber::<EgoTruth>()?;
    let mut voice = Voice::open(&mut runtime, &scenario)?;
    let mut truth = runtime.publisher::<SignalTruth>()?;
    let mut preview = Previews::open(&mut runtime, &scenario)?;
    let mut bends = Bends::open(&mut runtime, &scenario)?;
    // Another simulator has the lights.
    let lights = scenario.traffic.route.as_ref().map(|_| runtime.subscriber::<Lights>());
    let mut lights = lights.transpose()?;
    runtime.begin(&scenario)?;
    voice.begin(&runtime);
    runtime.run_cycles(|runtime| {
        let Some(release) = runtime.next_release(Overrun::Skip)? else { return Ok(Cycle::Last) };
        runtime.update(&mut ego)?;
        let ego_m = ego.newest().map_or(0.0, |ego| ego.position_m);
        let header = Header::new(release.step, release.scheduled_ns, Origins::NONE);
        let time_ns = release.scheduled_ns.unsigned_abs();

        if let Some(lights) = &mut lights {
            // Perception, which sends the lights, waits for the curves of this step.
            if let Some(bends) = &mut bends {
                bends.send(header, ego_m)?;
            }
            runtime.update(lights)?;
        }
        let newest = lights.as_ref().and_then(Subscriber::newest);

        // The referee's copy goes first: the plant may wait for it.
        let mut shown = match newest {
            Some(lights) => near(lights, ego_m, f64::INFINITY),
            None => voice.truth(&unit, time_ns, ego_m),
        };
        shown.header = header;
        let mut message = truth.loan_used()?;
        *message = shown;
        truth.send(message)?;
        voice.send(runtime, header, (&unit, newest), ego_m)?;
        if let Some(preview) = &mut preview {
            preview.send(header, ego_m)?;
        }
        if let Some(bends) = bends.as_mut().filter(|_| lights.is_none()) {
            bends.send(header, ego_m)?;
        }

        let seen = ego.newest().is_some();
        runtime.end_cycle(if seen { ServiceState::Running } else { ServiceState::Degraded })?;
        Ok(Cycle::Next)
    })?;
    let report = voice.report();
    runtime.finish(report)
}

/// The way of the signals to the vehicle.
enum Voice {
    Structs {
        spat: Publisher<Spat>,
        map: Publisher<Map>,
        motions: Option<Publisher<AnnouncedMotions>>,
    },
    /// Frames through the air, to the on-board unit.
    Frames(Box<Radio>),
    /// Frames of units on other hosts, or in a capture.
    Link(Box<Link>),
}

impl Voice {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Ok(match &scenario.v2x.radio {
            scenario::radio::Radio::Direct => Self::Structs {
                spat: runtime.publisher()?,
                map: runtime.publisher()?,
                motions: scenario
                    .traffic
                    .route
                    .as_ref()
                    .map(|_| runtime.publisher())
                    .transpose()?,
            },
            scenario::radio::Radio::Frames => {
                Self::Frames(Box::new(Radio::open(runtime, scenario)?))
            }
            scenario::radio::Radio::Carrier(address) => {
                let period_ns = i64::from(scenario.v2x.period_ms.value()) * 1_000_000;
                Self::Link(Box::new(Link::open(runtime, address, period_ns)?))
            }
        })
    }

    fn begin(&mut self, runtime: &Runtime) {
        match self {
            Self::Structs { .. } => {}
            Self::Frames(radio) => radio.utc_start_ns = runtime.utc_start_ns(),
            Self::Link(link) => link.begin(runtime),
        }
    }

    /// The signals as they are. Another host's units run the scenario's programs by their own clock. Signals are
    /// missing until that clock is known, and for units of other makers.
    fn truth(&self, unit: &RoadsideUnit, time_ns: u64, ego_m: f64) -> SignalTruth {
        match self {
            Self::Structs { .. } | Self::Frames(_) => unit.truth(&UnitClock::OWN, time_ns, ego_m),
            Self::Link(link) => {
                let shown = link.unit.as_ref().map(|clock| unit.truth(clock, time_ns, ego_m));
                shown.unwrap_or_else(SignalTruth::zeroed)
            }
        }
    }

    fn send(
        &mut self,
        runtime: &mut Runtime,
        header: Header,
        (unit, lights): (&RoadsideUnit, Option<&Lights>),
        ego_m: f64,
    ) -> Result<(), RuntimeError> {
        let time_ns = header.acquisition_ns.unsigned_abs();
        match self {
            Self::Structs { spat, map, motions } => {
                let received = match lights {
                    Some(lights) => near(lights, ego_m, unit.range_m),
                    None => unit.received(time_ns, ego_m),
                };
                map.send_with(|message| {
                    message.header = header;
                    (message.lanes, message.count) = (received.lanes, received.count);
                })?;
                spat.send_with(|message| {
                    message.header = header;
                    (message.signals, message.count) = (received.signals, received.count);
                })?;
                let Some((motions, lights)) = motions.as_mut().zip(lights) else { return Ok(()) };
                let heard = |motion: &&_| is_audible(motion, ego_m, unit.range_m);
                let heard = lights.motions.iter().filter(heard);
                motions.send_with(|message| {
                    message.header = header;
                    for (place, motion) in message.motions.iter_mut().zip(heard) {
                        *place = *motion;
                        message.count += 1;
                    }
                })?;
                Ok(())
            }
            Self::Frames(radio) => radio.send(header, time_ns, ego_m, lights),
            Self::Link(link) => link.exchange(runtime, header),
        }
    }

    fn report(&self) -> Option<LinkReport> {
        match self {
            Self::Structs { .. } | Self::Frames(_) => None,
            Self::Link(link) => Some(link.report()),
        }
    }
}

/// The roadside units' frames on their way through the air to the vehicle.
struct Radio {
    units: Frames,
    /// The on-board units of the other egos in a net, by station id.
    vehicles: BTreeMap<u64, Awareness>,
    scenario: Scenario,
    air: Air,
    frames: Publisher<RadioFrames>,
    utc_start_ns: i64,
}

impl Radio {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Ok(Self {
            units: Frames::new(scenario),
            vehicles: BTreeMap::new(),
            scenario: scenario.clone(),
            air: Air::new(&scenario.v2x.air, scenario.seed.value()),
            frames: runtime.publisher()?,
            utc_start_ns: 0,
        })
    }

    fn send(
        &mut self,
        header: Header,
        time_ns: u64,
        ego_m: f64,
        lights: Option<&Lights>,
    ) -> Result<(), RuntimeError> {
        let sent = self.units.at(time_ns, self.utc_start_ns, Some(ego_m), lights);
        let refused = |error: EncodeError| {
            let expected = "what SPATEM and MAPEM have room for";
            RuntimeError::from(Problem::new("v2x.signals", error.to_string(), expected))
        };
        for frame in sent.map_err(refused)? {
            self.air.send(time_ns, frame.bytes);
        }
        if let Some(lights) = lights {
            for frame in self.cams(lights, ego_m, header.acquisition_ns) {
                self.air.send(time_ns, frame);
            }
        }
        let arrived = self.air.arrived(time_ns);
        let utc_start_ns = self.utc_start_ns;
        self.frames.send_with(|message| {
            message.header = header;
            message.utc_start_ns = utc_start_ns;
            for (place, frame) in message.frames.iter_mut().zip(&arrived) {
                place.write(frame.sent_ns as i64, frame.received_ns as i64, &frame.bytes);
                message.count += 1;
            }
            message.left_out = arrived.len() as u64 - message.count;
        })?;
        Ok(())
    }

    /// The CAMs that the other egos send now.
    fn cams(&mut self, lights: &Lights, ego_m: f64, now_ns: i64) -> Vec<Vec<u8>> {
        let Self { vehicles, scenario, utc_start_ns, .. } = self;
        let moment = Moment { now_ns, utc_start_ns: *utc_start_ns, ahead_ns: 0 };
        let length_m = scenario.plant.length_m.value();
        let heard = |motion: &&_| is_audible(motion, ego_m, scenario.v2x.range_m.value());
        let due = lights.motions.iter().filter(heard).filter_map(|motion| {
            let id = motion.station_id;
            let unit = vehicles.entry(id).or_insert_with(|| Awareness::of(scenario, id as u32));
            let mut odometry = Odometry::zeroed();
            odometry.header.acquisition_ns = motion.made_ns;
            odometry.position_m = motion.rear_position_m + length_m;
            odometry.speed_mps = motion.speed_mps;
            odometry.acceleration_mps2 = motion.acceleration_mps2;
            unit.due(&odometry, motion.lateral_m, &moment)
        });
        due.collect()
    }
}

/// The map of the road, for a truck's controller.
struct Previews {
    map: CellMap,
    speed_limit_mps: f64,
    publisher: Publisher<Preview>,
}

impl Previews {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Option<Self>, RuntimeError> {
        if !scenario.plant.vehicle.is_truck() {
            return Ok(None);
        }
        let map = CellMap::of_grades(scenario)?;
        let speed_limit_mps = scenario.speed_limit_mps.map_or(f64::INFINITY, |v| v.value());
        Ok(Some(Self { map, speed_limit_mps, publisher: runtime.publisher()? }))
    }

    fn send(&mut self, header: Header, ego_m: f64) -> Result<(), RuntimeError> {
        let (map, speed_limit_mps) = (&self.map, self.speed_limit_mps);
        self.publisher.send_with(|message: &mut Preview| {
            message.header = header;
            (message.count, message.first_cell_m) = map.ahead(ego_m, &mut message.grades);
            message.cell_m = map.cell_m;
            message.speed_limit_mps = speed_limit_mps;
        })?;
        Ok(())
    }
}

/// The map of the road's curves, on a road with a plan.
struct Bends {
    map: CellMap,
    publisher: Publisher<Curves>,
}

impl Bends {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Option<Self>, RuntimeError> {
        let Some(map) = CellMap::of_curves(scenario) else { return Ok(None) };
        Ok(Some(Self { map, publisher: runtime.publisher()? }))
    }

    fn send(&mut self, header: Header, ego_m: f64) -> Result<(), RuntimeError> {
        let map = &self.map;
        self.publisher.send_with(|message: &mut Curves| {
            message.header = header;
            (message.count, message.first_cell_m) = map.ahead(ego_m, &mut message.curvatures);
            message.cell_m = map.cell_m;
        })?;
        Ok(())
    }
}
