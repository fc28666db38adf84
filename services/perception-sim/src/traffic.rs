//! The other vehicles: where they truly are.
//!
//! Each follows its profile alone, or a storyboard ([`crate::stage`]), whose triggers may look at the ego.
//! With the integrator `fine` speed and
//! position are those of an acceleration that is constant over each step (1 ms by default), exact for
//! profiles of constant pieces. With `paper-euler` they take the step of the CACC paper's simulation,
//!
//! ```text
//! x += T v        v += T a(t, v)        both from the start of the step
//! ```
//!
//! and samples inside a step are on its straight lines, as the ego's do.

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

/// Times of a profile take effect this much early, so that rounding does not lose a step, s.
const TIME_TOLERANCE_S: f64 = 1e-9;

/// All vehicles but the ego.
#[derive(Clone, Debug)]
pub struct Traffic {
    movers: Vec<Mover>,
    stage: Option<Stage>,
    vehicles: Vec<Vehicle>,
}

/// Where all vehicles are, as it outlives a process.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Snapshot([Option<Base>; MAX_ACTORS], Option<State>);

impl Snapshot {
    /// Simulated time of the newest part of it, ns; 0 without vehicles.
    #[must_use]
    pub fn newest_ns(&self) -> u64 {
        self.0.iter().flatten().map(|base| base.time_ns).max().unwrap_or(0)
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
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let movers: Vec<Mover> = scenario
            .actors
            .iter()
            .map(|actor| Mover {
                actor: actor.clone(),
                integrator: scenario.plant.integrator,
                step_ns: scenario.plant.integration_step_ms.nanoseconds(),
                appears_ns: actor.appears_at_s.nanoseconds(),
                leaves_ns: actor.leaves_at_s.map_or(u64::MAX, |time| time.nanoseconds()),
                base: None,
            })
            .collect();
        let vehicles = vec![Vehicle::default(); movers.len()];
        Self { movers, stage: Stage::of(scenario), vehicles }
    }

    /// Brings all vehicles to `time_ns`, which never goes back. A vehicle that appears is placed
    /// relative to the ego's front bumper.
    pub fn advance(&mut self, time_ns: u64, ego: &Ego) {
        for (mover, vehicle) in self.movers.iter_mut().zip(&mut self.vehicles) {
            *vehicle = mover.advance(time_ns, ego.position_m);
        }
        if let Some(stage) = &mut self.stage {
            stage.advance(time_ns, ego, &mut self.vehicles);
        }
    }

    /// Takes points of the first vehicle's table of speeds from `ahead`, so that all are there that
    /// [`Self::advance`] to `time_ns` looks at.
    pub fn learn(&mut self, time_ns: u64, ahead: &mut dyn FnMut(f64, &mut Vec<SpeedPoint>)) {
        let Some(Mover { actor, step_ns, .. }) = self.movers.first_mut() else { return };
        let Profile::Speeds(points) = &mut actor.profile else { return };
        // The step after the present one; the second is for the rounding of times.
        let until_s = seconds(time_ns + 2 * *step_ns);
        if points.last().is_none_or(|last| last.0.value() <= until_s) {
            ahead(until_s, points);
        }
    }

    /// A storyboard has come to its end, and so has the run.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.stage.as_ref().is_some_and(Stage::is_over)
    }

    /// Names of the storyboard's acts that have not started.
    #[must_use]
    pub fn unstarted_acts(&self) -> Vec<String> {
        self.stage.as_ref().map(Stage::unstarted_acts).unwrap_or_default()
    }

    /// Where all vehicles are, for a process that goes on in this one's place: they do not vanish with
    /// who simulates them.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let mut kept = Snapshot::default();
        for (place, mover) in kept.0.iter_mut().zip(&self.movers) {
            *place = mover.base;
        }
        kept.1 = self.stage.as_ref().map(|stage| stage.state().clone());
        kept
    }

    /// Goes on from what another process kept.
    pub fn restore(&mut self, kept: &Snapshot) {
        for (mover, base) in self.movers.iter_mut().zip(kept.0) {
            mover.base = base;
        }
        if let (Some(stage), Some(state)) = (&mut self.stage, &kept.1) {
            stage.restore(state.clone());
        }
    }

    /// The vehicles, in the scenario's order.
    #[must_use]
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
        while base.time_ns + self.step_ns <= time_ns {
            base = self.after(&base, self.step_ns);
        }
        self.base = Some(base);
        let inside_ns = time_ns - base.time_ns;
        let here = if inside_ns > 0 { self.after(&base, inside_ns) } else { base };
        let (lateral_m, lateral_speed_mps) = lateral_at(&self.actor, seconds(time_ns));
        Vehicle {
            present: true,
            rear_position_m: here.position_m,
            speed_mps: here.speed_mps,
            acceleration_mps2: self.acceleration(&base, seconds(self.step_ns)),
            lateral_m,
            lateral_speed_mps,
            length_m: self.actor.length_m.value(),
            width_m: VEHICLE_WIDTH_M,
            touches_within_m: VEHICLE_WIDTH_M,
        }
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
            position_m: base.position_m + elapsed_s * mean_mps,
            speed_mps,
        }
    }

    /// Acceleration over the step that starts at `base`, within standstill and the highest speed.
    fn acceleration(&self, base: &Base, step_s: f64) -> f64 {
        let (start_s, speed) = (seconds(base.time_ns), base.speed_mps);
        let wanted = match &self.actor.profile {
            Profile::Constant | Profile::Storyboard => 0.0,
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
    let after = first_after(points, time_s);
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

/// Index of the first point after a time. Recorded tables have even steps: there the place is known
/// without a search.
fn first_after(points: &[SpeedPoint], time_s: f64) -> usize {
    let is_before = |index: usize| points.get(index).is_some_and(|point| point.0.value() <= time_s);
    if let [first, second, ..] = points {
        let step_s = second.0.value() - first.0.value();
        let guess = ((time_s - first.0.value()) / step_s).max(0.0) as usize;
        for index in guess.saturating_sub(1)..guess.saturating_add(2).min(points.len()) {
            if is_before(index) && !is_before(index + 1) {
                return index + 1;
            }
        }
    }
    points.partition_point(|point| point.0.value() <= time_s)
}

/// Lateral position, m, and speed, m/s: one motion after the other.
fn lateral_at(actor: &Actor, time_s: f64) -> (f64, f64) {
    let start = (actor.lateral_offset_m.value(), 0.0);
    actor.lateral.iter().fold(start, |(lateral_m, speed_mps), motion| {
        let (share, share_per_s) = motion.progress(time_s);
        let way_m = motion.to_m.value() - lateral_m;
        (lateral_m + share * way_m, share_per_s * way_m + (1.0 - share) * speed_mps)
    })
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::builtin;

    use super::*;

    const PERIOD_NS: u64 = 50_000_000;

    macro_rules! reference {
        ($name:literal) => {
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/", $name, ".csv"))
        };
    }

    fn traffic(actors: &str) -> Traffic {
        let text = format!("schema_version = 1\nname = \"x\"\n{actors}");
        let scenario = Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}"));
        Traffic::new(&scenario)
    }

    fn ego(position_m: f64) -> Ego {
        Ego { position_m, ..Ego::default() }
    }

    fn lead(profile: &str) -> Traffic {
        traffic(&format!("[[actors]]\nname = \"lead\"\ngap_m = 50\n{profile}\n"))
    }

    /// The only vehicle at a time, reached in the radar's period.
    fn at(traffic: &mut Traffic, time_s: f64) -> Vehicle {
        let end = (time_s * 1e9).round() as u64;
        for time_ns in (0..=end).step_by(PERIOD_NS as usize) {
            traffic.advance(time_ns, &ego(0.0));
        }
        traffic.advance(end, &ego(0.0));
        traffic.vehicles()[0]
    }

    #[test]
    fn the_papers_leads_move_as_in_the_reference() {
        for (name, csv) in [
            ("cacc-a", reference!("cacc-a-cacc")),
            ("cacc-b", reference!("cacc-b-cacc")),
            ("cacc-c", reference!("cacc-c-cacc")),
            ("cacc-table3", reference!("cacc-table3-cacc")),
        ] {
            let builtin = builtin::find(name).expect("it is built in");
            let scenario = Scenario::parse(name, builtin.text).expect("it is right");
            let mut traffic = Traffic::new(&scenario);
            for (k, line) in csv.lines().skip(1).enumerate() {
                let row: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
                let (position, gap, speed) = (row[1], row[7], row[8]);
                traffic.advance(2 * k as u64 * PERIOD_NS, &ego(0.0));
                let vehicle = traffic.vehicles()[0];
                assert!((vehicle.rear_position_m - position - gap).abs() < 2e-5, "{name} {k}");
                assert!((vehicle.speed_mps - speed).abs() < 1e-5, "{name} {k}");
                traffic.advance((2 * k as u64 + 1) * PERIOD_NS, &ego(0.0));
            }
        }
    }

    #[test]
    fn a_constant_lead_keeps_its_speed() {
        let vehicle = at(&mut lead("initial_speed_mps = 20"), 30.0);
        assert!((vehicle.rear_position_m - 650.0).abs() < 1e-8);
        assert_eq!((vehicle.speed_mps, vehicle.acceleration_mps2), (20.0, 0.0));
    }

    #[test]
    fn steps_reach_their_speeds_and_stay() {
        let profile = "initial_speed_mps = 10\nprofile.steps = [\
            { time_s = 2, speed_mps = 16, acceleration_mps2 = 3 },\
            { time_s = 6, speed_mps = 0, acceleration_mps2 = 4 }]";
        let vehicle = at(&mut lead(profile), 3.0);
        assert!((vehicle.speed_mps - 13.0).abs() < 1e-9 && vehicle.acceleration_mps2 == 3.0);
        assert!((vehicle.rear_position_m - (50.0 + 20.0 + 11.5)).abs() < 1e-8);
        let vehicle = at(&mut lead(profile), 5.5);
        assert!((vehicle.speed_mps - 16.0).abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
        let vehicle = at(&mut lead(profile), 60.0);
        assert!(vehicle.speed_mps.abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
        assert!((vehicle.rear_position_m - (50.0 + 20.0 + 26.0 + 32.0 + 32.0)).abs() < 1e-6);
    }

    #[test]
    fn a_sine_is_integrated_to_its_closed_form() {
        let profile = "initial_speed_mps = 15\n\
            profile.sine = { amplitude_mps2 = 2, period_s = 10, start_s = 1 }";
        let vehicle = at(&mut lead(profile), 8.0);
        let w = 2.0 * std::f64::consts::PI / 10.0;
        let speed = 15.0 + 2.0 / w * (1.0 - libm::cos(w * 7.0));
        let position = 50.0 + 15.0 * 8.0 + 2.0 / w * (7.0 - libm::sin(w * 7.0) / w);
        assert!((vehicle.speed_mps - speed).abs() < 1e-6);
        assert!((vehicle.rear_position_m - position).abs() < 1e-5);
    }

    #[test]
    fn pieces_stop_at_standstill_and_at_the_cap() {
        let profile = "initial_speed_mps = 10\nmax_speed_mps = 12\nprofile.piecewise = [\
            { time_s = 0, acceleration_mps2 = 1 }, { time_s = 5, acceleration_mps2 = -4 }]";
        let vehicle = at(&mut lead(profile), 4.0);
        assert!((vehicle.speed_mps - 12.0).abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
        let vehicle = at(&mut lead(profile), 20.0);
        assert!(vehicle.speed_mps.abs() < 1e-9);
        let position = 50.0 + 22.0 + 36.0 + 18.0;
        assert!((vehicle.rear_position_m - position).abs() < 1e-6);
    }

    #[test]
    fn a_table_of_speeds_is_followed_between_and_beyond_its_points() {
        let profile = "profile.speeds = [[1, 10], [3, 14], [4, 0]]";
        assert!((at(&mut lead(profile), 0.5).speed_mps - 10.0).abs() < 1e-9);
        assert!((at(&mut lead(profile), 2.0).speed_mps - 12.0).abs() < 1e-9);
        let vehicle = at(&mut lead(profile), 9.0);
        assert!(vehicle.speed_mps.abs() < 1e-9);
        assert!((vehicle.rear_position_m - (50.0 + 10.0 + 24.0 + 7.0)).abs() < 1e-6);
    }

    #[test]
    fn a_table_that_grows_on_the_way_moves_a_vehicle_as_the_whole_one_does() {
        let all: Vec<String> =
            (0..200_u32).map(|k| format!("[{}, {}]", f64::from(k) * 0.02, 9 + k % 7)).collect();
        let table = |count: usize| format!("profile.speeds = [{}]", all[..count].join(", "));
        let mut whole = lead(&table(200));
        let Profile::Speeds(points) = whole.movers[0].actor.profile.clone() else { panic!("so") };
        let (mut growing, mut asked) = (lead(&table(1)), 0);
        for time_ns in (0..=5_000_000_000).step_by(PERIOD_NS as usize) {
            growing.learn(time_ns, &mut |until_s, known| {
                asked += 1;
                let wanted = points.partition_point(|point| point.0.value() <= until_s) + 1;
                known.extend_from_slice(&points[known.len()..wanted.min(points.len())]);
            });
            whole.advance(time_ns, &ego(0.0));
            growing.advance(time_ns, &ego(0.0));
            assert_eq!(growing.vehicles(), whole.vehicles(), "{time_ns}");
        }
        assert!(asked > 70, "{asked}");
    }

    #[test]
    fn a_vehicle_appears_relative_to_the_ego_and_leaves() {
        let mut traffic = lead("initial_speed_mps = 10\nappears_at_s = 2\nleaves_at_s = 4");
        traffic.advance(1_950_000_000, &ego(30.0));
        assert!(!traffic.vehicles()[0].present);
        traffic.advance(2_000_000_000, &ego(31.0));
        assert_eq!(traffic.vehicles()[0].rear_position_m, 81.0);
        traffic.advance(3_000_000_000, &ego(50.0));
        assert!((traffic.vehicles()[0].rear_position_m - 91.0).abs() < 1e-9);
        traffic.advance(4_000_000_000, &ego(60.0));
        assert!(!traffic.vehicles()[0].present);
    }

    #[test]
    fn a_cut_in_moves_smoothly_into_the_path_and_out_again() {
        let profile = "initial_speed_mps = 10\nlateral_offset_m = -3.5\nlateral = [\
            { time_s = 2, to_m = 0, duration_s = 4 }, { time_s = 10, to_m = 3.5, duration_s = 2 }]";
        let lateral = |time_s| at(&mut lead(profile), time_s).lateral_m;
        assert_eq!(lateral(2.0), -3.5);
        assert!((lateral(4.0) + 1.75).abs() < 1e-12);
        assert_eq!(lateral(6.0), 0.0);
        assert_eq!(lateral(30.0), 3.5);
        assert!(!at(&mut lead(profile), 3.0).in_ego_path());
        assert!(at(&mut lead(profile), 5.0).in_ego_path());
    }

    #[test]
    fn a_cut_in_of_constant_speed_rises_evenly_and_ends_at_once() {
        let profile = "initial_speed_mps = 10\nlateral_offset_m = -3.5\nlateral = [\
            { time_s = 1, to_m = 0, duration_s = 4, rise_s = 1 }]";
        let lateral = |time_s| at(&mut lead(profile), time_s).lateral_m;
        assert_eq!(lateral(1.0), -3.5);
        assert!((lateral(2.0) + 3.0).abs() < 1e-9, "{}", lateral(2.0));
        assert!((lateral(3.5) + 1.5).abs() < 1e-9, "{}", lateral(3.5));
        assert_eq!(lateral(5.0), 0.0);
    }

    proptest! {
        #[test]
        fn the_result_does_not_depend_on_the_sampling(
            skips in prop::collection::vec(1u64..20, 1..40), paper: bool,
        ) {
            let how = if paper { "paper-euler\"\nintegration_step_ms = 100" } else { "fine\"" };
            let text = format!("[plant]\nintegrator = \"{how}\n[[actors]]\nname = \"lead\"\n\
                gap_m = 50\ninitial_speed_mps = 8\nprofile.steps = [\
                {{ time_s = 1.23, speed_mps = 0, acceleration_mps2 = 3.1 }},\
                {{ time_s = 7, speed_mps = 20, acceleration_mps2 = 1.7 }}]");
            let (mut coarse, mut fine) = (traffic(&text), traffic(&text));
            coarse.advance(0, &ego(0.0));
            let (mut now, mut last) = (0, 0.0);
            for skip in skips {
                for _ in 0..skip {
                    fine.advance(now, &ego(0.0));
                    now += 10_000_000;
                }
                fine.advance(now, &ego(0.0));
                coarse.advance(now, &ego(0.0));
                prop_assert_eq!(fine.vehicles(), coarse.vehicles());
                let vehicle = fine.vehicles()[0];
                prop_assert!(vehicle.speed_mps >= 0.0 && vehicle.rear_position_m >= last);
                last = vehicle.rear_position_m;
            }
        }
    }
}
