//! `[traffic]`: SUMO as the traffic around the ego.
//!
//! ```toml
//! [traffic]
//! sumo = "grid.sumocfg"
//! ego = "from=A0B0,to=C2D2"      # or the name of a route, vehicle, trip or flow
//! begin_s = 60                   # SUMO drives a minute without the ego
//! ```
//!
//! The route of the ego in SUMO's net becomes the road. Its lights become the signals, and its speed limits cap the set
//! speed. Actors are places for the vehicles that SUMO has around the ego.

use std::path::Path;

use messages::Service;
use scenario_derive::tables;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

use crate::actor::{Actor, MAX_ACTORS, Profile};
use crate::event::VEHICLE_WIDTH_M;
use crate::lateral::LateralModel;
use crate::name::Name;
use crate::plan::{Lanes, Start};
use crate::quantity::{
    Distance, Duration, IntersectionId, Lateral, Length, SignalGroupId, Speed, Time,
};
use crate::reading::{Document, Refusal, ScenarioError};
use crate::schema::{Schema, Shape};
use crate::supervision::Restart;
use crate::v2x::{MAX_SIGNALS, Phase, ProgramPhase, Signal};
use crate::{Problem, Scenario};

/// Most links of a controller that have a signal group: groups count from 1 to 254.
const MAX_LINKS: usize = 254;
/// Duration that is assumed where none is written: this multiple of the free drive, and a wait at each light, s.
const SLOWER: f64 = 3.0;
const WAIT_S: f64 = 45.0;

tables! {
    /// SUMO as the traffic around the ego.
    pub struct Traffic {
        /// A configuration of SUMO (.sumocfg); a relative path starts at the scenario file's directory.
        pub sumo: Option<PathBuf>,
        /// The ego's way: the name of a route, vehicle, trip or flow of the configuration, or `from=EDGE,to=EDGE`, also
        /// with `via=EDGE` between them.
        pub ego: Option<String>,
        /// Time that SUMO drives before the ego comes, s.
        pub begin_s: Time = 0.0,
        /// Longest wait for an answer of SUMO, s of the wall.
        pub deadline_s: Duration = 10.0,
        /// The ego's route as it was read from the net.
        pub route: Option<SumoRoute>,
    }
}

/// A route of SUMO's net, as it was read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SumoRoute(pub sumo::Route);

impl Schema for SumoRoute {
    /// Reading a net fills it.
    fn shape() -> Shape {
        Shape::Free
    }
}

impl Traffic {
    /// The route, if SUMO has the traffic.
    #[must_use]
    pub fn route(&self) -> Option<&sumo::Route> {
        self.route.as_ref().map(|SumoRoute(route)| route)
    }
}

/// Fills in what a scenario takes from SUMO's files. `file` is the configuration if it has to be read. Returns remarks.
pub(crate) fn load(
    scenario: &mut Scenario,
    document: &Document<'_>,
    file: Option<&Path>,
) -> Result<Vec<String>, Refusal> {
    let traffic = &mut scenario.traffic;
    if let Some(file) = file {
        let Some(ego) = &traffic.ego else {
            let expected = "the name of a route, vehicle, trip or flow, or \"from=EDGE,to=EDGE\"";
            return Err(Problem::new("traffic.ego", "missing key `ego`", expected).into());
        };
        let route = sumo::read_route(file, ego, scenario.plant.length_m.value());
        let route = route.map_err(|error| ScenarioError::whole_of(&error))?;
        traffic.route = Some(SumoRoute(route));
        let here = std::env::current_dir().unwrap_or_default();
        traffic.sumo = Some(here.join(file));
    }
    let Some(SumoRoute(route)) = traffic.route.clone() else {
        if traffic.sumo.is_none() {
            return unused(scenario);
        }
        let message = "the file has not been read, for this scenario is not a file itself";
        return Err(Problem::new("traffic.sumo", message, "a scenario file").into());
    };
    let is_own = |actor: &Actor| actor.profile == Profile::Sumo;
    if scenario.storyboard.is_some() || !scenario.actors.iter().all(is_own) {
        let message = "SUMO has the traffic, and there are other vehicles";
        return Err(Problem::new("actors", message, "no actors beside it")
            .against("traffic.sumo")
            .into());
    }
    scenario.actors = (1..=MAX_ACTORS).map(place).collect();
    let signals = signals(&route)?;
    if !scenario.v2x.signals.is_empty() && scenario.v2x.signals != signals {
        let message = "the signals are SUMO's lights";
        return Err(Problem::new("v2x.signals", message, "no signals beside them").into());
    }
    scenario.v2x.signals = signals;
    let notes = if file.is_some() { route.notes.clone() } else { Vec::new() };
    follow(scenario, &route, |key| document.has(key))?;
    let plan = scenario.road.plan.get_or_insert_default();
    if !document.has("road.plan") {
        plan.start = Start::of_pose(&route.start);
        let beside = Lanes::beside(route.beside, width_m(&route));
        plan.lanes = Lanes { along: route.lines.clone(), ..beside };
    }
    plan.route = Some(route);
    Ok(notes)
}

/// Refuses keys that act with SUMO alone.
fn unused(scenario: &Scenario) -> Result<Vec<String>, Refusal> {
    if scenario.traffic.ego.is_some() {
        let message = "traffic.ego has no effect without SUMO";
        return Err(Problem::new("traffic.ego", message, "traffic.sumo").into());
    }
    if let Some(index) = scenario.actors.iter().position(|actor| actor.profile == Profile::Sumo) {
        let path = format!("actors.{index}.profile");
        return Err(Problem::new(path, "SUMO does not have the traffic", "traffic.sumo").into());
    }
    Ok(Vec::new())
}

/// Gives keys that were not written the values that follow from the route.
fn follow(
    scenario: &mut Scenario,
    route: &sumo::Route,
    is_written: impl Fn(&str) -> bool,
) -> Result<(), Problem> {
    let refuse = |error: crate::quantity::OutOfRange<f64>| {
        Problem::new("traffic.sumo", format!("the route: {error}"), "a net of streets")
    };
    if !is_written("duration_s") {
        let waits_s = WAIT_S * (route.lights.len() + 1) as f64;
        let duration_s = libm::ceil(SLOWER * route.free_s() + waits_s);
        scenario.duration_s = Duration::try_from(duration_s).map_err(refuse)?;
    }
    if !is_written("set_speed_mps") {
        scenario.set_speed_mps = Speed::try_from(route.fastest_mps()).map_err(refuse)?;
    }
    // Turns inside of junctions are narrower than a driver's law on the offset can steer.
    if !is_written("plant.lateral.model") {
        scenario.plant.lateral.model = LateralModel::OnAxis;
    }
    // The traffic ends with the process that has the connection to SUMO.
    if !is_written("supervision.services.perception-sim") {
        scenario.supervision.services.set(Service::PerceptionSim, Some(Restart::Never));
    }
    Ok(())
}

fn width_m(route: &sumo::Route) -> f64 {
    let first = route.lines.stations().first();
    first.map_or(3.2, |station| {
        (station[station.len() - 1] - station[1]) / (station.len() - 2) as f64
    })
}

/// A place for a vehicle.
fn place(number: usize) -> Actor {
    Actor {
        name: Name::of(&format!("sumo-{number}")),
        gap_m: Distance::of(0.0),
        initial_speed_mps: Some(Speed::of(0.0)),
        max_speed_mps: None,
        length_m: Length::of(4.5),
        width_m: Length::of(VEHICLE_WIDTH_M),
        lateral_offset_m: Lateral::of(0.0),
        appears_at_s: Time::of(0.0),
        leaves_at_s: None,
        profile: Profile::Sumo,
        lateral: Vec::new(),
        events: Vec::new(),
    }
}

/// The signals at the stop lines. What they show comes from SUMO: their program is a filler.
fn signals(route: &sumo::Route) -> Result<Vec<Signal>, Problem> {
    let mut controllers: Vec<&str> = Vec::new();
    let mut signals: Vec<Signal> = Vec::new();
    for light in route.lights.iter().take(MAX_SIGNALS) {
        let refuse = |what: String| Problem::new("traffic.sumo", what, "a net of streets");
        let group = i64::try_from(light.link % MAX_LINKS + 1).expect("it is small");
        let signal_group = SignalGroupId::of(u8::try_from(group).expect("at most 254"));
        let known = controllers.iter().position(|other| *other == light.controller);
        let is_new = |index: &usize| {
            let id = IntersectionId::of(*index as u16 + 1);
            signals.iter().all(|s| (s.intersection_id, s.signal_group) != (id, signal_group))
        };
        let index = known.filter(is_new).unwrap_or_else(|| {
            controllers.push(&light.controller);
            controllers.len() - 1
        });
        signals.push(Signal {
            stop_line_m: Distance::try_from(light.stop_line_m)
                .map_err(|e| refuse(e.to_string()))?,
            intersection_id: IntersectionId::of(index as u16 + 1),
            signal_group,
            offset_s: Time::of(0.0),
            repeat: true,
            program: vec![ProgramPhase { phase: Phase::Red, duration_s: Duration::of(1.0) }],
        });
    }
    Ok(signals)
}
