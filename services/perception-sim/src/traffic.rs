//! The other vehicles: where they truly are.
//!
//! Each follows its profile alone, or a storyboard ([`crate::stage`]), whose triggers may look at the ego. With the
//! integrator `fine` the acceleration is constant over each step (1 ms by default). This is exact for profiles of
//! constant pieces. With `paper-euler` they take the step of the CACC paper's simulation,
//!
//! ```text
//! x += T v        v += T a(t, v)        both from the start of the step
//! ```
//!
//! and samples inside a step are on its straight lines, as the ego's do.
//!
//! On a road with a plan a vehicle at the offset l covers the way p' = v / (1 − κ l) of the axis. The inner lane of a
//! curve is shorter. The way of a vehicle that keeps speed and offset is a closed sum, v t = p − l θ(p) + constant, with
//! the axis' heading θ.

use std::sync::Arc;

use openscenario::world::State;
use scenario::Scenario;
use scenario::actor::{Actor, MAX_ACTORS, Profile};
use scenario::event::VEHICLE_WIDTH_M;
use scenario::plant::Integrator;
use scenario::speeds::SpeedPoint;
use serde::{Deserialize, Serialize};

use crate::radar::scene::Ego;
use crate::stage::Stage;
use crate::vehicle::Vehicle;
use crate::weaving::Weaving;

/// Times of a profile take effect this much early, so that rounding does not lose a step, s.
const TIME_TOLERANCE_S: f64 = 1e-9;

/// Places on the axis that differ by less than this are the same, m.
const SAME_M: f64 = 1e-9;

/// All vehicles but the ego.
#[derive(Clone, Debug)]
pub struct Traffic {
    movers: Vec<Mover>,
    stage: Option<Stage>,
    vehicles: Vec<Vehicle>,
}

/// Vehicles in a row of a snapshot: as many as serde's arrays have at most.
const ROW: usize = 32;
const _: () = assert!(MAX_ACTORS.is_multiple_of(ROW));

/// State of all vehicles that outlives a process, without allocation.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Snapshot([[Option<Base>; ROW]; MAX_ACTORS / ROW], Option<State>);

impl Snapshot {
    /// Simulated time of the newest part of it, ns; 0 without vehicles.
    pub fn newest_ns(&self) -> u64 {
        self.0.iter().flatten().flatten().map(|base| base.time_ns).max().unwrap_or(0)
    }
}

/// A vehicle and what moves it.
#[derive(Clone, Debug)]
struct Mover {
    actor: Actor,
    integrator: Integrator,
    step_ns: u64,
    appears_ns: u64,
    leaves_ns: u64,
    /// On a road with a plan, for a vehicle that is not always on its axis.
    axis: Option<Arc<road::Axis>>,
    weaving: Weaving,
    /// It keeps its speed and its offset.
    keeps: bool,
    /// Start of the present step, once the vehicle has appeared.
    base: Option<Base>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Base {
    time_ns: u64,
    position_m: f64,
    speed_mps: f64,
}

impl Traffic {
    /// The vehicles of a scenario, before the start.
    pub fn new(scenario: &Scenario) -> Self {
        let axis = scenario.road.plan().map(|plan| Arc::new(plan.axis().clone()));
        let on_axis =
            |actor: &Actor| actor.lateral_offset_m.value() == 0.0 && actor.lateral.is_empty();
        let movers: Vec<Mover> = scenario
            .actors
            .iter()
            .map(|actor| Mover {
                actor: actor.clone(),
                integrator: scenario.plant.integrator,
                step_ns: scenario.plant.integration_step_ms.nanoseconds(),
                appears_ns: actor.appears_at_s.nanoseconds(),
                leaves_ns: actor.leaves_at_s.map_or(u64::MAX, |time| time.nanoseconds()),
                axis: axis.clone().filter(|_| !on_axis(actor)),
                weaving: Weaving::new(actor),
                keeps: keeps(actor),
                base: None,
            })
            .collect();
        let vehicles = vec![Vehicle::default(); movers.len()];
        Self { movers, stage: Stage::of(scenario, axis), vehicles }
    }

    /// Brings all vehicles to `time_ns`, which never goes back. A vehicle that appears is placed
    /// relative to the ego's front bumper.
    pub fn advance(&mut self, time_ns: u64, ego: &Ego) {
        // Vehicles of SUMO are placed.
        let own = |(mover, _): &(&mut Mover, &mut Vehicle)| mover.actor.profile != Profile::Sumo;
        for (mover, vehicle) in self.movers.iter_mut().zip(&mut self.vehicles).filter(own) {
            *vehicle = mover.advance(time_ns, ego.position_m);
        }
        if let Some(stage) = &mut self.stage {
            stage.advance(time_ns, ego, &mut self.vehicles);
        }
    }

    pub(crate) fn place(&mut self, vehicles: impl Iterator<Item = Vehicle>) {
        for (place, vehicle) in self.vehicles.iter_mut().zip(vehicles) {
            *place = vehicle;
        }
    }

    pub fn has_storyboard(&self) -> bool {
        self.stage.is_some()
    }

    /// A storyboard has come to its end, and so has the run.
    pub fn is_over(&self) -> bool {
        self.stage.as_ref().is_some_and(Stage::is_over)
    }

    /// The ego came to the end of the road of an OpenSCENARIO file.
    pub fn has_road_ended(&self) -> bool {
        self.stage.as_ref().is_some_and(Stage::has_road_ended)
    }

    /// Names of the storyboard's acts that have not started.
    pub fn unstarted_acts(&self) -> Vec<String> {
        self.stage.as_ref().map(Stage::unstarted_acts).unwrap_or_default()
    }

    /// State of all vehicles for a process that takes this one's place. The vehicles outlive their simulator.
    pub fn snapshot(&self) -> Snapshot {
        let mut kept = Snapshot::default();
        for (place, mover) in kept.0.as_flattened_mut().iter_mut().zip(&self.movers) {
            *place = mover.base;
        }
        kept.1 = self.stage.as_ref().map(|stage| stage.state().clone());
        kept
    }

    /// Goes on from what another process kept.
    pub fn restore(&mut self, kept: &Snapshot) {
        for (mover, base) in self.movers.iter_mut().zip(kept.0.as_flattened()) {
            mover.base = *base;
        }
        if let (Some(stage), Some(state)) = (&mut self.stage, &kept.1) {
            stage.restore(state.clone());
        }
    }

    pub fn vehicles(&self) -> &[Vehicle] {
        &self.vehicles
    }
}

impl Mover {
    fn advance(&mut self, time_ns: u64, ego_position_m: f64) -> Vehicle {
        if time_ns < self.appears_ns || time_ns >= self.leaves_ns {
            return Vehicle::default();
        }
        let mut base = self.base.unwrap_or_else(|| Base {
            time_ns,
            position_m: ego_position_m + self.actor.gap_m.value(),
            speed_mps: initial_speed(&self.actor, seconds(time_ns)),
        });
        if self.keeps {
            let way_m = base.speed_mps * seconds(time_ns - base.time_ns);
            base.position_m = self.place_after(base.position_m, way_m);
            base.time_ns = time_ns;
        }
        while base.time_ns + self.step_ns <= time_ns {
            base = self.after(&base, self.step_ns);
        }
        self.base = Some(base);
        let inside_ns = time_ns - base.time_ns;
        let here = if inside_ns > 0 { self.after(&base, inside_ns) } else { base };
        let (lateral_m, lateral_speed_mps) = self.weaving.at(seconds(time_ns));
        Vehicle {
            present: true,
            rear_position_m: here.position_m,
            speed_mps: here.speed_mps,
            acceleration_mps2: self.acceleration(&base, seconds(self.step_ns)),
            lateral_m,
            lateral_speed_mps,
            length_m: self.actor.length_m.value(),
            width_m: self.actor.width_m.value(),
            touches_within_m: 0.5 * (self.actor.width_m.value() + VEHICLE_WIDTH_M),
            turned_rad: 0.0,
        }
    }

    /// The place on the axis after a way at a constant offset.
    fn place_after(&self, from_m: f64, way_m: f64) -> f64 {
        let Some(axis) = &self.axis else { return from_m + way_m };
        let (lateral_m, _) = self.weaving.at(0.0);
        let to_m = from_m - lateral_m * axis.heading_rad(from_m) + way_m;
        let mut place_m = from_m;
        // Newton's steps; two are usual.
        for _ in 0..4 {
            let left_m = to_m - (place_m - lateral_m * axis.heading_rad(place_m));
            place_m += left_m / (1.0 - axis.curvature_perm(place_m) * lateral_m);
            if left_m.abs() < SAME_M {
                break;
            }
        }
        // At a kink of the axis the sum jumps.
        place_m.max(from_m)
    }

    /// State `elapsed_ns` (at most one step) after `base`, at the step's acceleration.
    fn after(&self, base: &Base, elapsed_ns: u64) -> Base {
        let acceleration = self.acceleration(base, seconds(self.step_ns));
        let elapsed_s = seconds(elapsed_ns);
        let speed_mps = (base.speed_mps + elapsed_s * acceleration).max(0.0);
        let mean_mps = match self.integrator {
            Integrator::PaperEuler => base.speed_mps,
            Integrator::Fine => 0.5 * (base.speed_mps + speed_mps),
        };
        Base {
            time_ns: base.time_ns + elapsed_ns,
            position_m: base.position_m + elapsed_s * mean_mps / self.stretch(base),
            speed_mps,
        }
    }

    /// Way at the vehicle's offset by the way on the axis: 1 without curves.
    fn stretch(&self, base: &Base) -> f64 {
        let Some(axis) = &self.axis else { return 1.0 };
        let (lateral_m, _) = self.weaving.at(seconds(base.time_ns));
        1.0 - axis.curvature_perm(base.position_m) * lateral_m
    }

    /// Acceleration over the step that starts at `base`, within standstill and the highest speed.
    fn acceleration(&self, base: &Base, step_s: f64) -> f64 {
        let (start_s, speed) = (seconds(base.time_ns), base.speed_mps);
        let wanted = match &self.actor.profile {
            Profile::Constant | Profile::Storyboard | Profile::Sumo => 0.0,
            Profile::Steps(steps) => {
                current(steps, start_s, |step| step.time_s.value()).map_or(0.0, |step| {
                    let rate = step.acceleration_mps2.value();
                    ((step.speed_mps.value() - speed) / step_s).clamp(-rate, rate)
                })
            }
            Profile::Sine(sine) => {
                let at_s = match self.integrator {
                    Integrator::PaperEuler => start_s,
                    Integrator::Fine => start_s + 0.5 * step_s,
                };
                let since_s = at_s - sine.start_s.value();
                let angle = 2.0 * std::f64::consts::PI * since_s / sine.period_s.value();
                if since_s < 0.0 { 0.0 } else { sine.amplitude_mps2.value() * libm::sin(angle) }
            }
            Profile::Piecewise(pieces) => current(pieces, start_s, |piece| piece.time_s.value())
                .map_or(0.0, |piece| piece.acceleration_mps2.value()),
            Profile::Speeds(points) => (speed_in(points, start_s + step_s) - speed) / step_s,
            Profile::Csv(csv) => (speed_in(&csv.points, start_s + step_s) - speed) / step_s,
            Profile::Cycle(cycle) => (speed_in(cycle.points(), start_s + step_s) - speed) / step_s,
        };
        let highest = self.actor.max_speed_mps.map_or(f64::INFINITY, |speed| speed.value());
        wanted.min((highest - speed) / step_s).max(-speed / step_s)
    }
}

/// An actor keeps its speed and its offset from its first moment on.
fn keeps(actor: &Actor) -> bool {
    let highest_mps = actor.max_speed_mps.map_or(f64::INFINITY, |speed| speed.value());
    matches!(actor.profile, Profile::Constant | Profile::Storyboard)
        && actor.lateral.is_empty()
        && (0.0..=highest_mps).contains(&initial_speed(actor, 0.0))
}

/// The last item that has begun.
fn current<T>(items: &[T], time_s: f64, start_s: impl Fn(&T) -> f64) -> Option<&T> {
    let begun = items.partition_point(|item| start_s(item) <= time_s + TIME_TOLERANCE_S);
    begun.checked_sub(1).map(|last| &items[last])
}

fn initial_speed(actor: &Actor, time_s: f64) -> f64 {
    match (actor.initial_speed_mps, actor.profile.points()) {
        (Some(speed), _) => speed.value(),
        (None, Some(points)) => speed_in(points, time_s),
        (None, None) => 0.0,
    }
}

/// Speed of a table at a time: linear between the points, constant before the first and after the
/// last.
fn speed_in(points: &[SpeedPoint], time_s: f64) -> f64 {
    let after = points.partition_point(|point| point.0.value() <= time_s);
    let before = after.checked_sub(1).map(|i| &points[i]);
    match (before, points.get(after)) {
        (Some(a), Some(b)) => {
            let share = (time_s - a.0.value()) / (b.0.value() - a.0.value());
            a.1.value() + share * (b.1.value() - a.1.value())
        }
        (Some(point), None) | (None, Some(point)) => point.1.value(),
        (None, None) => 0.0,
    }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}

#[cfg(test)]
mod tests;
