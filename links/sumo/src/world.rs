//! SUMO's world around the ego, step by step.
//!
//! ```text
//! time of the run   0 ─────────── 100 ms ─────── 200 ms ────
//! ego               placed        placed         placed       for the next step, where it will be
//! SUMO              ├ step ┤      ├ step ┤       ├ step ┤     beside the run
//! bodies            of 0          of 100         of 200       extrapolated in between
//! ```
//!
//! SUMO computes a step beside the run, from the ego's place ahead at constant acceleration. A change of its acceleration
//! by 2 m/s² moves it by a centimetre in a step. In simulated time the run waits for a step at the step's time. In
//! realtime no cycle waits: the vehicles go on from the last answer until the next one has come.

use std::collections::BTreeMap;
use std::path::PathBuf;

use road::{Axis, Pose};

use crate::client::{Client, Vehicle};
use crate::lights::{Interval, Plan, State};
use crate::process::Network;
use crate::shared::Seat;
use crate::{ProgramError, RADIUS_M, Route, STEP_MS};

/// Time between two steps, ns.
const STEP_NS: u64 = STEP_MS * 1_000_000;
/// Simulated time that the ego waits for a gap, s.
const ROOM_S: f64 = 300.0;
/// Farthest distance of a vehicle to the side of the axis, m.
const ASIDE_M: f64 = 50.0;
/// Distance between two places of the axis in the search for the nearest one, m.
const SPACING_M: f64 = 4.0;
/// Angle to the axis up to which a body follows it, rad.
const ALONG_RAD: f64 = 0.15;
/// Way before the end of the route on which SUMO may take the ego away, m.
const NEAR_END_M: f64 = 20.0;

#[derive(Clone, Debug)]
pub struct Settings {
    pub config: PathBuf,
    pub seed: u64,
    /// Time that SUMO drives without the ego, s.
    pub begin_s: f64,
    pub deadline_s: f64,
    /// Length and width of the ego, m.
    pub ego_m: (f64, f64),
    /// Speed of the ego at the start, m/s.
    pub speed_mps: f64,
    /// Station id of the ego's radio.
    pub station_id: u32,
    pub most: usize,
    /// Waits for the answer of a step at once.
    pub waits: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Ego {
    /// Middle of its front bumper, and its heading, with the road beginning at the origin.
    pub pose: Pose,
    /// Place of the front bumper on the axis, m.
    pub place_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// A vehicle beside the ego, by the axis of the route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Place of its middle on the axis, m.
    pub middle_m: f64,
    /// Offset of its middle from the axis, m, left positive.
    pub aside_m: f64,
    /// Angle of its body to the axis, rad; 0 for one that goes along it.
    pub turned_rad: f64,
    /// Speed along the axis, m/s, negative towards its beginning.
    pub along_mps: f64,
    /// Speed to the left, m/s.
    pub across_mps: f64,
    /// Acceleration along the axis, m/s².
    pub acceleration_mps2: f64,
    pub length_m: f64,
    pub width_m: f64,
    /// Station id of another ego, which has a radio; 0 for a vehicle of SUMO's.
    pub station_id: u32,
}

/// Way in a time at constant acceleration, m, and the time in motion, s: braking ends at standstill.
fn way(speed_mps: f64, acceleration_mps2: f64, time_s: f64) -> (f64, f64) {
    let brakes = speed_mps * acceleration_mps2 < 0.0;
    let moving_s = if brakes { time_s.min(-speed_mps / acceleration_mps2) } else { time_s };
    (speed_mps * moving_s + 0.5 * acceleration_mps2 * moving_s * moving_s, moving_s)
}

impl Body {
    fn after(&self, time_s: f64) -> Self {
        let (way_m, moving_s) = way(self.along_mps, self.acceleration_mps2, time_s);
        Self {
            middle_m: self.middle_m + way_m,
            aside_m: self.aside_m + self.across_mps * moving_s,
            along_mps: self.along_mps + self.acceleration_mps2 * moving_s,
            ..*self
        }
    }
}

#[derive(Debug)]
pub struct World {
    client: Client,
    route: Route,
    axis: Axis,
    /// Places of the axis at even distances.
    marks: Vec<[f64; 2]>,
    settings: Settings,
    /// Time of the step that was begun and not taken, of the newest answer, and of the next step, ns of the run.
    open_ns: Option<u64>,
    known_ns: u64,
    next_ns: u64,
    /// Time by which SUMO's clock is ahead of the run's, s.
    ahead_s: f64,
    place_m: f64,
    /// Ids and bodies at the newest answer; a vehicle keeps its slot.
    slots: Vec<Option<(String, Body)>>,
    /// Time since that answer, s.
    age_s: f64,
    plans: Vec<(String, Plan)>,
    states: Vec<State>,
}

impl World {
    /// Starts SUMO, drives its traffic to the start of the run, and adds the ego to it.
    ///
    /// # Errors
    /// [`ProgramError`] if the program is missing, of another version, or does not do as it is asked.
    ///
    /// # Panics
    /// If the route has no axis, which [`crate::read_route`] rules out.
    pub fn start(
        settings: &Settings,
        route: &Route,
        network: &mut dyn Network,
    ) -> Result<Self, ProgramError> {
        let (Settings { config, seed, deadline_s, .. }, shared) = (settings, Seat::given());
        let mut client = match shared {
            Some(seat) => seat.take(*deadline_s)?,
            None => Client::start((config, *seed), *deadline_s, network)?,
        };
        let from_s = client.time_s()?;
        let mut time_s = from_s;
        while time_s < from_s + settings.begin_s {
            // In parts, each of which has the deadline.
            time_s = (time_s + 10.0).min(from_s + settings.begin_s);
            client.step_to(time_s)?;
        }
        let known = client.vehicles()?;
        let first = shared.map_or("ego".to_owned(), |seat| format!("ego-{}", seat.number));
        let names = std::iter::once(first).chain((0..).map(|n| format!("timegap-{n}")));
        let ego = names.into_iter().find(|name| !known.contains(name)).expect("they never end");
        let start = (route.lane, route.depart_m, settings.speed_mps);
        client.add(&ego, &route.edges, start, settings.ego_m)?;
        let waits_from_s = time_s;
        loop {
            client.step_to(0.0)?;
            time_s = client.time_s()?;
            if client.vehicles()?.contains(&ego) {
                break;
            }
            if time_s > waits_from_s + ROOM_S {
                let lane = format!("{}_{}", route.edges[0], route.lane);
                let waited = format!("no room for the ego on lane `{lane}` within {ROOM_S} s");
                let expected = "a lane with a gap (traffic.begin_s moves the start)";
                let fault = format!("{waited} of simulated time, expected {expected}");
                return Err(ProgramError::Unfit(fault));
            }
        }
        client.surround()?;
        let mut plans: Vec<(String, Plan)> = Vec::new();
        for light in &route.lights {
            if plans.iter().all(|(known, _)| *known != light.controller) {
                plans.push((light.controller.clone(), client.watch(&light.controller)?));
            }
        }
        let (axis, _) = route.axis().expect("a route that was read has an axis");
        let count = (axis.length_m() / SPACING_M) as usize + 1;
        let mark = |index: usize| {
            let pose = axis.pose(index as f64 * SPACING_M);
            [pose.x_m, pose.y_m]
        };
        Ok(Self {
            client,
            marks: (0..=count).map(mark).collect(),
            axis,
            route: route.clone(),
            settings: settings.clone(),
            open_ns: None,
            known_ns: 0,
            next_ns: 0,
            // The step of run time 0 is the next one.
            ahead_s: time_s + STEP_MS as f64 * 1e-3,
            place_m: 0.0,
            slots: vec![None; settings.most],
            age_s: 0.0,
            plans,
            states: Vec::new(),
        })
    }

    /// Brings the world to a time of the run, which never goes back, with the ego where it is then.
    ///
    /// # Errors
    /// [`ProgramError`] if SUMO ends, does not answer in time, or refuses the ego's place.
    pub fn advance(&mut self, time_ns: u64, ego: &Ego) -> Result<(), ProgramError> {
        self.place_m = ego.place_m;
        self.take_due(time_ns)?;
        while self.open_ns.is_none() && self.next_ns <= time_ns + STEP_NS {
            let (from_s, to_s) = (seconds(time_ns), seconds(self.next_ns));
            let (ahead_m, _) = way(ego.speed_mps, ego.acceleration_mps2, to_s - from_s);
            // Beside the axis as now, farther along it.
            let beside = ego.pose.seen_from(&self.axis.pose(ego.place_m));
            let there = beside.placed(&self.axis.pose(ego.place_m + ahead_m));
            let placed = there.placed(&self.route.start);
            let angle_deg = (90.0 - placed.heading_rad.to_degrees()).rem_euclid(360.0);
            let announced = (self.settings.station_id, ego.acceleration_mps2);
            self.client.begin_step([placed.x_m, placed.y_m], angle_deg, announced)?;
            self.open_ns = Some(self.next_ns);
            self.next_ns += STEP_NS;
            self.take_due(time_ns)?;
        }
        self.age_s = seconds(time_ns.saturating_sub(self.known_ns));
        Ok(())
    }

    /// The vehicles around the ego; a vehicle keeps its place in the list.
    pub fn bodies(&self) -> impl Iterator<Item = Option<Body>> + '_ {
        self.slots.iter().map(|slot| slot.as_ref().map(|(_, known)| known.after(self.age_s)))
    }

    /// The present interval of a light of the route, by its index, and those behind it. Empty while nothing is known.
    pub fn light(&self, index: usize, time_s: f64) -> Vec<Interval> {
        let light = &self.route.lights[index];
        let state = self.states.iter().find(|state| state.controller == light.controller);
        let plan = self.plans.iter().find(|(controller, _)| *controller == light.controller);
        let (Some(state), Some((_, plan))) = (state, plan) else { return Vec::new() };
        let known_s = seconds(self.known_ns).min(time_s);
        plan.now(state, light.link, known_s, self.ahead_s)
    }

    /// Takes the answer of a step whose time has come.
    fn take_due(&mut self, time_ns: u64) -> Result<(), ProgramError> {
        let Some(open_ns) = self.open_ns.filter(|open_ns| *open_ns <= time_ns) else {
            return Ok(());
        };
        if !self.settings.waits && !self.client.has_answered()? {
            return Ok(());
        }
        (self.open_ns, self.known_ns) = (None, open_ns);
        let step = self.client.end_step()?;
        if let Some(words) = step.refusal
            && self.place_m < self.axis.length_m() - NEAR_END_M
        {
            return Err(ProgramError::Refused("placing the ego", words));
        }
        if !step.states.is_empty() {
            self.states = step.states;
        }
        let ego = self.axis.pose(self.place_m).placed(&self.route.start);
        let away_m = |[x_m, y_m]: [f64; 2]| libm::hypot(x_m - ego.x_m, y_m - ego.y_m);
        let mut near: Vec<(f64, Vehicle)> =
            step.vehicles.into_iter().map(|vehicle| (away_m(vehicle.front_m), vehicle)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.id.cmp(&b.1.id)));
        let bodies = near.into_iter().filter_map(|(_, v)| Some((self.body(&v)?, v.id)));
        let mut found: BTreeMap<_, _> =
            bodies.take(self.slots.len()).map(|(body, id)| (id, body)).collect();
        for slot in &mut self.slots {
            *slot = slot.take().and_then(|(id, _)| found.remove_entry(&id));
        }
        let free = self.slots.iter_mut().filter(|slot| slot.is_none());
        free.zip(found).for_each(|(slot, new)| *slot = Some(new));
        Ok(())
    }

    /// A vehicle by the axis; `None` far beside it.
    fn body(&self, vehicle: &Vehicle) -> Option<Body> {
        let heading_rad = (90.0 - vehicle.angle_deg).to_radians();
        let [x_m, y_m] = vehicle.front_m;
        let front = Pose { x_m, y_m, heading_rad }.seen_from(&self.route.start);
        let (x_m, y_m) = front.to_world(-0.5 * vehicle.length_m, 0.0);
        let near_m = self.nearest_m(x_m, y_m);
        let (middle_m, aside_m) = self.axis.project(x_m, y_m, near_m);
        let is_known = [middle_m, aside_m, vehicle.speed_mps, vehicle.length_m, vehicle.width_m];
        if !is_known.iter().all(|value| value.is_finite()) || aside_m.abs() > ASIDE_M {
            return None;
        }
        let tangent_rad = self.axis.heading_rad(middle_m);
        let angle_rad = libm::remainder(front.heading_rad - tangent_rad, std::f64::consts::TAU);
        let (sine, cosine) = libm::sincos(angle_rad);
        let body_rad = libm::remainder(angle_rad, std::f64::consts::PI);
        let acceleration =
            if vehicle.acceleration_mps2.is_finite() { vehicle.acceleration_mps2 } else { 0.0 };
        Some(Body {
            middle_m,
            aside_m,
            turned_rad: if body_rad.abs() < ALONG_RAD { 0.0 } else { body_rad },
            along_mps: vehicle.speed_mps * cosine,
            across_mps: vehicle.speed_mps * sine,
            acceleration_mps2: acceleration * cosine,
            length_m: vehicle.length_m,
            width_m: vehicle.width_m,
            station_id: vehicle.station_id,
        })
    }

    /// The place on the axis, near the ego, that is nearest to a point, m. Before its beginning and behind its end the
    /// axis is straight.
    fn nearest_m(&self, x_m: f64, y_m: f64) -> f64 {
        let reach = (RADIUS_M / SPACING_M) as usize + 5;
        let own = (self.place_m / SPACING_M).max(0.0) as usize;
        let from = own.saturating_sub(reach).min(self.marks.len() - 1);
        let to = (own + reach).min(self.marks.len() - 1);
        let square = |index: &usize| {
            let [dx_m, dy_m] = [x_m - self.marks[*index][0], y_m - self.marks[*index][1]];
            dx_m * dx_m + dy_m * dy_m
        };
        let nearest = (from..=to).min_by(|a, b| square(a).total_cmp(&square(b)));
        nearest.unwrap_or(from) as f64 * SPACING_M
    }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}
