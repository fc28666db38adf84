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

use messages::Topic;
use road::LaneLines;
pub use sumo::{Limit, Route};

use scenario_derive::tables;
use std::path::PathBuf;

use crate::actor::{Actor, MAX_ACTORS, Profile};
use crate::lateral::LateralModel;
use crate::plan::{Lanes, Start};
use crate::quantity::{Duration, IntersectionId, OutOfRange, SignalGroupId, Time};
use crate::reading::{Document, Refusal, ScenarioError, plain, refuse};
use crate::supervision::Restart;
use crate::v2x::{MAX_SIGNALS, Phase, ProgramPhase, Signal};
use crate::{Problem, Scenario, Value, table};

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
        pub route: Option<sumo::Route>,
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
        traffic.route = Some(route.map_err(|error| ScenarioError::whole_of(&error))?);
        let here = std::env::current_dir().unwrap_or_default();
        traffic.sumo = Some(here.join(file));
    }
    let Some(route) = traffic.route.clone() else {
        unused(scenario)?;
        return Ok(Vec::new());
    };
    let signals = signals(&route)?;
    alone(scenario, &signals)?;
    scenario.actors = (1..=MAX_ACTORS).map(place).collect();
    scenario.v2x.signals = signals;
    follow(scenario, &route, |key| document.has(key))?;
    let plan = scenario.road.plan.get_or_insert_default();
    let (axis, _) = route.axis().map_err(|error| Problem::of_axis("traffic.sumo", &error))?;
    plan.lay(axis);
    if !document.has("road.plan") {
        plan.start = Start::of_pose(&route.start);
        plan.lanes = lanes(route.lines);
    }
    Ok(if file.is_some() { route.notes } else { Vec::new() })
}

/// Refuses keys that act with SUMO alone.
fn unused(scenario: &Scenario) -> Result<(), Problem> {
    if scenario.traffic.sumo.is_some() {
        return Err(Problem::unread("traffic.sumo", "a scenario file"));
    }
    refuse!(if scenario.traffic.ego.is_some(),
        "traffic.ego": "traffic.ego has no effect without SUMO", "traffic.sumo");
    refuse!(if let Some(index) = crate::check::aimed_at(scenario, Topic::AnnouncedMotions),
        "faults.{index}.topic": "nothing is sent on `v2x/motions` without SUMO", "traffic.sumo");
    refuse!(if let Some(index) = scenario.actors.iter().position(is_place),
        "actors.{index}.profile": "SUMO does not have the traffic", "traffic.sumo");
    Ok(())
}

/// Refuses vehicles and signals beside SUMO's.
fn alone(scenario: &Scenario, signals: &[Signal]) -> Result<(), Problem> {
    refuse!(if scenario.storyboard.is_some() || !scenario.actors.iter().all(is_place),
        "actors": "SUMO has the traffic, and there are other vehicles", "no actors beside it",
        against "traffic.sumo");
    refuse!(if !scenario.v2x.signals.is_empty() && scenario.v2x.signals != signals,
        "v2x.signals": "the signals are SUMO's lights", "no signals beside them");
    Ok(())
}

fn is_place(actor: &Actor) -> bool {
    actor.profile == Profile::Sumo
}

/// A number of the route, in the range of its quantity.
fn inside<T: TryFrom<f64, Error = OutOfRange<f64>>>(value: f64) -> Result<T, Problem> {
    T::try_from(value).map_err(|error| {
        Problem::new("traffic.sumo", format!("the route: {error}"), "a net of streets")
    })
}

/// Gives keys that were not written the values that follow from the route.
fn follow(
    scenario: &mut Scenario,
    route: &sumo::Route,
    is_written: impl Fn(&str) -> bool,
) -> Result<(), Problem> {
    if !is_written("duration_s") {
        let waits_s = WAIT_S * (route.lights.len() + 1) as f64;
        scenario.duration_s = inside(libm::ceil(SLOWER * route.free_s() + waits_s))?;
    }
    if !is_written("set_speed_mps") {
        scenario.set_speed_mps = inside(route.fastest_mps())?;
    }
    // Turns inside of junctions are narrower than a driver's law on the offset can steer.
    if !is_written("plant.lateral.model") {
        scenario.plant.lateral.model = LateralModel::OnAxis;
    }
    // The traffic ends with the process that has the connection to SUMO.
    if !is_written("supervision.services.perception-sim") {
        scenario.supervision.services.perception_sim = Some(Restart::Never);
    }
    Ok(())
}

/// The lanes along a road, with those beside the ego's at the start by their lines.
fn lanes(along: LaneLines) -> Lanes {
    let first = along.stations().first().map_or(&[-1.6, 1.6][..], |station| &station[1..]);
    let right = first.iter().filter(|line_m| **line_m < 0.0).count();
    let width_m = (first[first.len() - 1] - first[0]) / (first.len() - 1) as f64;
    let beside = [first.len() - right, right].map(|lines| lines.saturating_sub(1));
    Lanes { along, ..Lanes::beside(beside, width_m) }
}

fn place(number: usize) -> Actor {
    let name = format!("sumo-{number}");
    let keys = table! { name: name, gap_m: 0, initial_speed_mps: 0, profile: "sumo" };
    plain(Value::Table(keys), "actors").expect("the keys that an actor needs")
}

/// The signals at the stop lines. What they show comes from SUMO: their program is a filler.
fn signals(route: &sumo::Route) -> Result<Vec<Signal>, Problem> {
    let mut controllers: Vec<&str> = Vec::new();
    let mut signals: Vec<Signal> = Vec::new();
    for light in route.lights.iter().take(MAX_SIGNALS) {
        let signal_group = SignalGroupId::of((light.link % MAX_LINKS + 1) as u8);
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
            stop_line_m: inside(light.stop_line_m)?,
            intersection_id: IntersectionId::of(index as u16 + 1),
            signal_group,
            offset_s: Time::of(0.0),
            repeat: true,
            program: vec![ProgramPhase { phase: Phase::Red, duration_s: Duration::of(1.0) }],
        });
    }
    Ok(signals)
}

#[cfg(test)]
mod tests {
    use crate::Scenario;

    #[test]
    fn a_fault_of_announced_motions_needs_sumo() {
        let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"v2x/motions\"\nat_s = 0\nfor_s = 1\n";
        let text = format!("schema_version = 1\nname = \"t\"\n{fault}");
        let refused = Scenario::parse("t", &text).expect_err("without SUMO").to_string();
        assert!(refused.contains("nothing is sent on `v2x/motions` without SUMO"), "{refused}");
    }
}
