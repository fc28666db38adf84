//! The vehicles and the lights of SUMO: where `[traffic]` names it.

use std::io;
use std::net::TcpStream;
use std::process::Command;
use std::sync::Once;

use messages::{AnnouncedMotion, Header, Interval, Lane, Lights, MAX_LANES, PhaseState, Signal};
use runtime::{
    Mode, OwnNetwork, Publisher, Runtime, RuntimeError, die_with_this_thread, inherit_only,
};
use scenario::Scenario;
use scenario::event::VEHICLE_WIDTH_M;
use sumo::{Body, Network, ProgramError, Settings, World};

use crate::radar::scene::{Ego, PlaneEgo};
use crate::traffic::Traffic;
use crate::vehicle::{Vehicle, half_extent_m};

/// A stop line that was passed by no more than this is still sent, m.
const PASSED_M: f64 = 50.0;
/// Confidence of a certain end, and of another one.
const CERTAIN: u32 = 15;
const UNCERTAIN: u32 = 7;

/// SUMO's world, and what is sent of it.
pub(crate) struct SumoWorld {
    world: World,
    /// The stop lines of the route, with the signals' ids.
    lanes: Vec<Lane>,
    lights: Publisher<Lights>,
    time_s: f64,
}

impl SumoWorld {
    /// Starts SUMO; `None` without it in the scenario.
    pub(crate) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let (Some(config), Some(route)) = (&scenario.traffic.sumo, &scenario.traffic.route) else {
            return Ok(None);
        };
        let settings = Settings {
            config: config.clone(),
            seed: scenario.seed.value(),
            begin_s: scenario.traffic.begin_s.value(),
            deadline_s: scenario.traffic.deadline_s.value(),
            ego_m: (scenario.plant.length_m.value(), VEHICLE_WIDTH_M),
            speed_mps: scenario.plant.initial_speed_mps.value(),
            station_id: scenario.v2x.obu.station_id.value(),
            most: scenario.actors.len(),
            waits: runtime.clock().mode == Mode::Lockstep,
        };
        let world = World::start(&settings, route, &mut Alone::default()).map_err(failed)?;
        let lane = |signal: &scenario::v2x::Signal| Lane {
            intersection_id: signal.intersection_id.value().into(),
            signal_group: signal.signal_group.value().into(),
            stop_line_m: signal.stop_line_m.value(),
        };
        let lanes = scenario.v2x.signals.iter().map(lane).collect();
        Ok(Some(Self { world, lanes, lights: runtime.publisher()?, time_s: 0.0 }))
    }

    /// Brings SUMO to a time, and its vehicles into the traffic.
    pub(crate) fn advance(
        &mut self,
        time_ns: u64,
        ego: &Ego,
        in_plane: &PlaneEgo,
        traffic: &mut Traffic,
    ) -> Result<(), RuntimeError> {
        let &Ego { position_m: place_m, speed_mps, acceleration_mps2 } = ego;
        let ego = sumo::Ego { pose: in_plane.pose, place_m, speed_mps, acceleration_mps2 };
        self.world.advance(time_ns, &ego).map_err(failed)?;
        self.time_s = time_ns as f64 * 1e-9;
        traffic.place(self.world.bodies().map(|body| body.map(vehicle).unwrap_or_default()));
        Ok(())
    }

    /// Sends the lights ahead of the ego, and those just passed.
    pub(crate) fn send(&mut self, header: Header, ego_m: f64) -> Result<(), RuntimeError> {
        let Self { world, lanes, lights, time_s } = self;
        lights.send_with(|message| {
            message.header = header;
            let near = lanes.iter().enumerate();
            let near = near.filter(|(_, lane)| lane.stop_line_m > ego_m - PASSED_M);
            for (index, lane) in near.take(MAX_LANES) {
                let intervals = world.light(index, *time_s);
                let is_dark = intervals.first().is_none_or(|now| now.0 == PhaseState::Unavailable);
                if is_dark {
                    continue;
                }
                let place = message.count as usize;
                message.lanes[place] = *lane;
                write(lane, &intervals, &mut message.signals[place]);
                message.count += 1;
            }
            let others = world.bodies().flatten().filter(|body| body.station_id > 0);
            for (motion, body) in message.motions.iter_mut().zip(others) {
                *motion = AnnouncedMotion {
                    station_id: body.station_id.into(),
                    made_ns: header.acquisition_ns,
                    rear_position_m: body.middle_m - 0.5 * body.length_m,
                    lateral_m: body.aside_m,
                    speed_mps: body.along_mps,
                    acceleration_mps2: body.acceleration_mps2,
                };
            }
        })?;
        Ok(())
    }
}

fn failed(error: ProgramError) -> RuntimeError {
    RuntimeError::Program(Box::new(error))
}

fn write(lane: &Lane, intervals: &[sumo::Interval], signal: &mut Signal) {
    (signal.intersection_id, signal.signal_group) = (lane.intersection_id, lane.signal_group);
    for (place, (state, ends_s)) in signal.intervals.iter_mut().zip(intervals) {
        let [min_end_s, likely_end_s, max_end_s] = *ends_s;
        *place = Interval {
            state: state.to_wire(),
            confidence: if min_end_s == max_end_s { CERTAIN } else { UNCERTAIN },
            min_end_s,
            likely_end_s,
            max_end_s,
        };
        signal.count += 1;
    }
}

fn vehicle(body: Body) -> Vehicle {
    let along = half_extent_m(body.length_m, body.width_m, body.turned_rad);
    let across = match body.turned_rad == 0.0 {
        true => 0.5 * body.width_m,
        false => half_extent_m(body.width_m, body.length_m, body.turned_rad),
    };
    Vehicle {
        present: true,
        rear_position_m: body.middle_m - along,
        speed_mps: body.along_mps,
        acceleration_mps2: body.acceleration_mps2,
        lateral_m: body.aside_m,
        lateral_speed_mps: body.across_mps,
        length_m: body.length_m,
        width_m: body.width_m,
        touches_within_m: across + 0.5 * VEHICLE_WIDTH_M,
        turned_rad: body.turned_rad,
    }
}

/// SUMO listens on all interfaces. So it gets a network of its own where that is granted.
#[derive(Debug, Default)]
pub struct Alone(Option<OwnNetwork>);

impl Network for Alone {
    fn prepare(&mut self, command: &mut Command) -> io::Result<()> {
        self.0 = Some(OwnNetwork::of(command)?);
        inherit_only(command, None);
        die_with_this_thread(command);
        Ok(())
    }

    fn connect(&mut self, port: u16) -> io::Result<TcpStream> {
        static NOTE: Once = Once::new();
        if let Some(stream) = self.0.as_mut().map(|own| own.connect(port)).transpose()?.flatten() {
            return Ok(stream);
        }
        let stream = TcpStream::connect(("127.0.0.1", port))?;
        NOTE.call_once(|| {
            eprintln!("note: SUMO listens on all interfaces: no network of its own is granted");
        });
        Ok(stream)
    }
}
