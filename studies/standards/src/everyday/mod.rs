//! Random scenes of everyday driving. A law drives each one, with or without the emergency brake. An oracle that has
//! the motion of all vehicles judges it.
//!
//! | kind | scene |
//! |---|---|
//! | [`Kind::CutIn`] | a vehicle comes in with 1 to 2.5 s of time gap and at most 3 m/s slower, in 3 to 6 s |
//! | [`Kind::CutInThatBrakes`] | a vehicle comes in closely, 2 to 10 m/s slower, and then brakes with 2 to 5 m/s² |
//! | [`Kind::PullsAway`] | a faster car comes in 3 to 15 m ahead and pulls away |
//! | [`Kind::Slower`] | a car in the lane is 2 to 12 m/s slower |
//! | [`Kind::Standing`] | a car stands in the lane |
//! | [`Kind::FastClosing`] | a car 70 to 120 m ahead is 12 to 28 m/s slower |
//! | [`Kind::Stop`] | a lead brakes to standstill with 0.5 to 2.5 m/s², waits and moves off |
//! | [`Kind::StopAndGo`] | a lead stops and goes four times |
//! | [`Kind::BrakingLead`] | after settled following a lead brakes with 3 to 9 m/s² |
//! | [`Kind::Pass`] | slower vehicles in both neighbouring lanes wander in theirs and are passed |
//! | [`Kind::Queue`] | vehicles that stand beside an empty lane, in a column or in pairs abreast |
//! | [`Kind::CrawlingQueue`] | the same, crawling |
//! | [`Kind::LedQueue`] | either of them behind a lead that drives past them |
//! | [`Kind::TwoWheeler`] | a two-wheeler stands 0.5 to 1 m beside the ego's side |
//! | [`Kind::CutOut`] | a lead leaves before a vehicle that stands or is slow, 1 to 3 s before it would be there |
//! | [`Kind::HalfBlind`] | a slower car or a braking lead, seen by a radar that misses 30 to 90 % |
//! | [`Kind::FalseDetections`] | a steady lead among 10 to 60 false detections in each scan |
//! | [`Kind::LostTracks`] | a lead brakes while no tracks arrive for 1 to 3 s |
//! | [`Kind::ClockAhead`] | a lead brakes while the controller's clock is ahead by 0.1 to 2 ms |
//! | [`Kind::CurveQueue`] | vehicles that stand beside an empty lane where a curve begins or ends |
//! | [`Kind::CurveQueueAhead`] | the same in the ego's lane |
//! | [`Kind::BrakesBeside`] | a vehicle in the next lane brakes with 2 to 8 m/s² and is passed |
//!
//! A scene is a function of its kind and its number alone.
//!
//! ```
//! use standards::everyday::Kind;
//!
//! let text = Kind::Standing.scene(7).text(7, "acc-mpc", true);
//! assert!(text.contains("name = \"standing\""));
//! ```

mod curves;
mod draw;
pub mod limits;
pub mod oracle;
pub mod scene;

use controller::laws;
use group::Error;
use group::report::Outcome;
use oracle::{Brakes, Oracle};
use rand_pcg::Pcg64;
use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use scene::Scene;

/// Time before something happens behind a lead, in which the law settles, s.
const SETTLE_S: f64 = 10.0;

/// A kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Kind {
    /// A comfortable cut-in.
    CutIn,
    /// A close cut-in that brakes.
    CutInThatBrakes,
    /// A faster car that comes in closely.
    PullsAway,
    /// A slower car.
    Slower,
    /// A standing car.
    Standing,
    /// A much slower car.
    FastClosing,
    /// A comfortable stop behind a lead.
    Stop,
    /// A lead that stops and goes.
    StopAndGo,
    /// A lead that brakes hard.
    BrakingLead,
    /// Slower traffic in the neighbouring lanes.
    Pass,
    /// Standing queues in the neighbouring lanes.
    Queue,
    /// Crawling queues in the neighbouring lanes.
    CrawlingQueue,
    /// Queues in the neighbouring lanes, behind a lead.
    LedQueue,
    /// A two-wheeler that stands beside the path.
    TwoWheeler,
    /// A lead that leaves before a standing or slow vehicle.
    CutOut,
    /// A radar that misses much.
    HalfBlind,
    /// A radar with many false detections.
    FalseDetections,
    /// Tracks that do not arrive.
    LostTracks,
    /// A controller whose clock is ahead.
    ClockAhead,
    /// A queue beside the ego's lane where a curve begins or ends.
    CurveQueue,
    /// A queue in the ego's lane where a curve begins or ends.
    CurveQueueAhead,
    /// A vehicle in the next lane that brakes.
    BrakesBeside,
}

/// Result of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The ego touched another vehicle, by the oracle.
    pub collided: bool,
    /// The same by the run's referee.
    pub referee_collided: bool,
    /// Brakes that take over 0.35 s after the need would have avoided it ([`oracle`]). They are those of the emergency
    /// brake if it is on, else those of the law.
    pub avoidable: bool,
    /// Times at which the emergency brake began to brake, s.
    pub interventions_s: Vec<f64>,
    /// Those of them where 1.5 m/s² was enough, s.
    pub needless_s: Vec<f64>,
    /// Times that the ego's target was not a vehicle in its path, where the radar is judged.
    pub false_targets: u64,
    /// Least acceleration, m/s².
    pub hardest_mps2: f64,
}

/// The draws of one scene.
struct Draws(Pcg64);

impl Draws {
    fn new(number: u32, stream: u128) -> Self {
        Self(Pcg64::new(u128::from(number), 0x1501 + stream))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * random::uniform(&mut self.0)
    }

    fn side(&mut self) -> f64 {
        if self.between(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 }
    }
}

impl Kind {
    /// Scene number `number`.
    #[must_use]
    pub fn scene(self, number: u32) -> Scene {
        let draws = &mut Draws::new(number, self as u128);
        match self {
            Self::CutIn => draw::cut_in(draws),
            Self::CutInThatBrakes => draw::cut_in_that_brakes(draws),
            Self::PullsAway => draw::pulls_away(draws),
            Self::Slower => draw::slower(draws),
            Self::Standing => draw::standing(draws),
            Self::FastClosing => draw::fast_closing(draws),
            Self::Stop => draw::stop(draws),
            Self::StopAndGo => draw::stop_and_go(draws),
            Self::BrakingLead => draw::braking_lead(draws),
            Self::Pass => draw::pass(draws),
            Self::Queue => draw::queue(draws),
            Self::CrawlingQueue => draw::crawling_queue(draws),
            Self::LedQueue => draw::led_queue(draws),
            Self::TwoWheeler => draw::two_wheeler(draws),
            Self::CutOut => draw::cut_out(draws),
            Self::HalfBlind => draw::half_blind(draws),
            Self::FalseDetections => draw::false_detections(draws),
            Self::LostTracks => draw::lost_tracks(draws),
            Self::ClockAhead => draw::clock_ahead(draws),
            Self::CurveQueue => curves::queue(draws, false),
            Self::CurveQueueAhead => curves::queue(draws, true),
            Self::BrakesBeside => draw::brakes_beside(draws),
        }
    }

    /// Drives scene number `number` with `law`, with or without the emergency brake, in this thread.
    ///
    /// # Errors
    /// There is no such law, or the run cannot begin.
    pub fn drive(self, number: u32, law: &str, aebs: bool) -> Result<Verdict, Error> {
        let scene = self.scene(number);
        drive(&scene, &scenario(&scene.text(number, law, aebs))?)
    }
}

fn scenario(text: &str) -> Result<Scenario, Error> {
    Ok(Scenario::parse_with("everyday", text, &Overrides::new(), &laws::check)?)
}

fn drive(scene: &Scene, scenario: &Scenario) -> Result<Verdict, Error> {
    let group = group::in_process::run_unsealed(scenario, &|| false)?;
    let summary = Summary::new(scenario, Mode::Lockstep, &group, group.ran_for);
    let oracle = Oracle::new(&scene.actors, &group.drive.steps);
    let collided = oracle.has_contact();
    let interventions_s = group.drive.interventions_s.clone();
    let needless = interventions_s.iter().copied().filter(|time_s| oracle.is_needless(*time_s));
    let accelerations = group.drive.steps.iter().map(|step| step.acceleration_mps2);
    Ok(Verdict {
        collided,
        referee_collided: summary.outcome == Outcome::Collision,
        avoidable: collided && oracle.is_avoidable(&brakes(scenario)?),
        needless_s: needless.collect(),
        interventions_s,
        false_targets: summary.perception.map_or(0, |perception| perception.false_targets),
        hardest_mps2: accelerations.fold(0.0, f64::min),
    })
}

/// The brakes that a drive is measured by.
fn brakes(scenario: &Scenario) -> Result<Brakes, Error> {
    if scenario.has_aebs() {
        return Ok(Brakes::EMERGENCY);
    }
    let law = laws::build(scenario)?;
    Ok(Brakes {
        deceleration_mps2: -law.request_bounds_mps2().0,
        lag_s: scenario.plant.actuator_time_constant_s.value(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;
    use scene::Actor;

    fn drive_of(kind: Kind, number: u32, law: &str) -> Verdict {
        kind.drive(number, law, true).unwrap_or_else(|error| panic!("{kind:?} {number}: {error}"))
    }

    #[test]
    fn every_scene_is_a_scenario_and_a_function_of_its_number() {
        for &kind in Kind::value_variants() {
            for number in 0..50 {
                assert_eq!(kind.scene(number), kind.scene(number));
                assert_ne!(kind.scene(number), kind.scene(number + 1), "{kind:?} {number}");
                let text = kind.scene(number).text(number, "acc-mpc", true);
                scenario(&text).unwrap_or_else(|error| panic!("{kind:?} {number}: {error}"));
            }
        }
    }

    /// The oracle's motion and the simulator's are two computations of one description.
    #[test]
    fn the_simulator_moves_the_vehicles_as_the_oracle_expects() {
        for &kind in Kind::value_variants() {
            let scene = kind.scene(3);
            let scenario = scenario(&scene.text(3, "acc-mpc", true)).expect("a scenario");
            let group = group::in_process::run_unsealed(&scenario, &|| false).expect("it runs");
            assert!(!group.drive.vehicles.is_empty());
            for truth in &group.drive.vehicles {
                let time_s = truth.header.acquisition_ns as f64 / 1e9;
                for (actor, vehicle) in scene.actors.iter().zip(&truth.vehicles) {
                    let place = actor.at(time_s);
                    let name = format!("{kind:?}, {} at {time_s} s", actor.name);
                    assert!((place.rear_m - vehicle.rear_position_m).abs() < 0.05, "{name}");
                    assert!((place.lateral_m - vehicle.lateral_m).abs() < 0.01, "{name}");
                    assert!((place.speed_mps - vehicle.speed_mps).abs() < 0.05, "{name}");
                }
            }
        }
    }

    #[test]
    fn oracle_and_referee_agree_on_contacts() {
        for number in 0..4 {
            let verdict = Kind::CutInThatBrakes
                .drive(number, "quadratic-bounded", false)
                .unwrap_or_else(|error| panic!("{number}: {error}"));
            assert_eq!(verdict.collided, verdict.referee_collided, "{number}: {verdict:?}");
        }
    }

    /// In 9 of these drives the emergency brake braked when points were left out by their own place.
    #[test]
    fn the_emergency_brake_leaves_an_empty_lane_between_queues_alone() {
        let braked = |number: &u32| {
            let verdict = drive_of(Kind::Queue, *number, "acc-mpc");
            assert!(!verdict.collided, "{number}");
            !verdict.needless_s.is_empty()
        };
        let scenes: Vec<u32> = (0..40).filter(braked).collect();
        assert!(scenes.len() <= 3, "{scenes:?}");
    }

    /// Pairs abreast that the radar does not resolve far off, with time to find that out. Each was a target between the
    /// two before.
    #[test]
    fn two_vehicles_abreast_are_not_one_between_them() {
        let mut scene = Scene::new(25.0, 25.0, 9.0);
        for number in 0..8 {
            let lateral_m = if number % 2 == 0 { -3.5 } else { 3.5 };
            let gap_m = 120.0 + 20.0 * f64::from(number / 2);
            let car = Actor::car(format!("car-{number}"), gap_m, 8.0);
            scene.actors.push(Actor { lateral_m, ..car });
        }
        let false_targets = |seed| {
            let scenario = scenario(&scene.text(seed, "acc-mpc", true)).expect("a scenario");
            drive(&scene, &scenario).expect("it runs").false_targets
        };
        assert!((1..5).map(false_targets).sum::<u64>() < 4, "not one in each drive");
    }
}
