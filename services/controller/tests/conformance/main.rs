//! The suite that every control law passes, whatever its principle: see [`Law`].
//!
//! It takes the laws from the registry: a new law is tested without a line here. [`VARIANTS`] adds
//! settings that choose another formulation or planner.

use controller::law::{
    Descriptor, Ego, Formulation, Input, Law, MAX_PLAN, Output, Phase, Plan, PlanRequest, Target,
};
use controller::laws;
use rand_pcg::Pcg64;
use scenario::Scenario;

mod counting;
mod inputs;

use inputs::{EVIL, numbers, ordinary, random, signal, uniform};

/// Laws with settings of `[controller]` that make something else of them.
const VARIANTS: [(&str, &str); 7] = [
    ("six-mode", "six_mode.variant = \"literal\""),
    ("quadratic-bounded", "quadratic_bounded.gains = \"printed\""),
    ("acc-mpc", "spacing_policy = \"constant-distance\""),
    ("cacc-mpc", "spacing_policy = \"constant-distance\""),
    ("cacc-mpc", "spacing_policy = \"measured-headway\""),
    ("predictive", "predictive.planner = \"paper-n2\""),
    ("predictive", "predictive.planner = \"constant-speed\""),
];

/// A law with its settings.
struct Subject {
    name: String,
    scenario: Scenario,
}

impl Subject {
    fn new(law: &str, keys: &str) -> Self {
        let trucks_alone = laws::find(law).is_some_and(|law| law.trucks_alone);
        let vehicle = if trucks_alone { "jh6-49t" } else { "car" };
        let text = format!(
            "schema_version = 1\nname = \"conformance\"\nplant.vehicle = \"{vehicle}\"\n\
             [controller]\nname = \"{law}\"\n{keys}\n"
        );
        let scenario = Scenario::parse("conformance", &text).expect("the keys are right");
        Self { name: format!("{law} {keys}"), scenario }
    }

    fn law(&self) -> Box<dyn Law> {
        laws::build(&self.scenario).unwrap_or_else(|problem| panic!("{}: {problem:?}", self.name))
    }

    fn formulation(&self) -> &'static Formulation {
        laws::formulation(&self.scenario).expect("the registry has the law")
    }
}

fn subjects() -> Vec<Subject> {
    // A law that is a program needs one: the system test `external` judges its host.
    let own = |law: &&&Descriptor| !std::ptr::eq(**law, &laws::external::EXTERNAL);
    let registered = laws::ALL.iter().filter(own).map(|law| Subject::new(law.name, ""));
    registered.chain(VARIANTS.iter().map(|(law, keys)| Subject::new(law, keys))).collect()
}

/// Runs a check for every law, each in a thread; a failure names the law.
fn for_each(check: impl Fn(&mut dyn Law, &Formulation) + Sync) {
    std::thread::scope(|scope| {
        for subject in subjects() {
            let check = &check;
            let name = subject.name.clone();
            let of_law = move || check(subject.law().as_mut(), subject.formulation());
            std::thread::Builder::new().name(name).spawn_scoped(scope, of_law).expect("a thread");
        }
    });
}

fn ask(law: &mut dyn Law, input: &Input) -> Output {
    // Earlier content must be overwritten.
    let mut output = Output { plan_len: 77, mode: 99, solver_iterations: 99, ..Output::default() };
    output.plan_mps2 = [f64::NAN; MAX_PLAN];
    output.figures = [f64::NAN; 8];
    law.step(input, &mut output);
    plan(law);
    output
}

/// Makes the plan that the law needs, before the next step, as the loop's planning thread does.
fn plan(law: &mut dyn Law) {
    if let Some(planning) = law.planning()
        && let Some(request) = planning.request()
    {
        let mut plan = Plan::default();
        planning.planner().plan(&request, &mut plan);
        planning.accept(&plan);
    }
}

/// The guarantees of a single output.
#[track_caller]
fn sound(law: &dyn Law, formulation: &Formulation, input: &Input, output: &Output) {
    let (low, high) = law.request_bounds_mps2();
    assert!(low.is_finite() && high.is_finite() && low < 0.0 && high > 0.0);
    assert!((1..=MAX_PLAN).contains(&output.plan_len), "{input:?}");
    for request in &output.plan_mps2[..output.plan_len] {
        assert!((low..=high).contains(request), "request {request} for {input:?}");
    }
    assert!((output.mode as usize) < formulation.modes.len(), "{input:?}");
    assert!((output.mode_reason as usize) < formulation.reasons.len(), "{input:?}");
    assert!(formulation.figures.len() <= output.figures.len());
    assert!(output.figures.iter().all(|f| f.is_finite()), "{:?} for {input:?}", output.figures);
}

#[test]
fn outputs_are_bounded_for_anything_a_road_shows() {
    for_each(|law, formulation| {
        let mut rng = Pcg64::new(1, 1);
        for k in 0..3000 {
            let input = random(&mut rng, k);
            let output = ask(law, &input);
            sound(law, formulation, &input, &output);
        }
    });
}

#[test]
fn outputs_are_finite_and_bounded_for_any_number_and_usable_after_it() {
    for_each(|law, formulation| {
        // Only a law that plans looks at a truck and its road; their numbers come last.
        let others = Input { powertrain: None, preview: None, ..ordinary(0) };
        let mut seen = if law.planning().is_some() { ordinary(0) } else { others };
        let count = numbers(&mut seen).len();
        for index in 0..count {
            for evil in EVIL {
                law.reset();
                for k in 0..3 {
                    let _ = ask(law, &ordinary(k));
                }
                for k in 3..6 {
                    let mut input = ordinary(k);
                    *numbers(&mut input)[index] = evil;
                    let output = ask(law, &input);
                    sound(law, formulation, &input, &output);
                }
                // One bad sample must not poison the state for good.
                for k in 6..60 {
                    let input = ordinary(k);
                    let output = ask(law, &input);
                    sound(law, formulation, &input, &output);
                }
                let input = ordinary(60);
                let usual = ask(law, &input).quality;
                assert_ne!(
                    usual,
                    controller::law::Quality::Backup,
                    "number {index} = {evil} is never forgotten"
                );
            }
        }
    });
}

#[test]
fn all_numbers_bad_at_once() {
    for_each(|law, formulation| {
        for evil in EVIL {
            let mut input = ordinary(0);
            for number in numbers(&mut input) {
                *number = evil;
            }
            input.signals[0].as_mut().expect("it has one").count = usize::MAX;
            let output = ask(law, &input);
            sound(law, formulation, &input, &output);
        }
    });
}

#[test]
fn a_lost_target_and_its_return() {
    for_each(|law, formulation| {
        for k in 0..200 {
            let mut input = ordinary(k);
            if (k / 7) % 2 == 1 {
                input.target = None;
            } else if let Some(target) = &mut input.target {
                target.track_id = k / 14;
            }
            let output = ask(law, &input);
            sound(law, formulation, &input, &output);
        }
        // An empty road below the set speed: in the end every law accelerates.
        let mut output = Output::default();
        for k in 0..100 {
            output = ask(law, &Input { target: None, signals: [None; 4], ..ordinary(k) });
        }
        assert!(output.request_mps2() > 0.0);
    });
}

#[test]
fn lost_and_impossible_signals() {
    for_each(|law, formulation| {
        for k in 0..120 {
            let mut input = ordinary(k);
            input.signals = match k % 6 {
                0 => [None; 4],
                1 => [Some(signal(50.0, &[])); 4],
                2 => [Some(signal(-3.0, &[(Phase::Red, 5.0)])), None, None, None],
                3 => [None, None, None, Some(signal(80.0, &[(Phase::Unknown, f64::INFINITY)]))],
                4 => [Some(signal(60.0, &[(Phase::Green, -1.0), (Phase::Red, -2.0)])); 4],
                _ => input.signals,
            };
            let output = ask(law, &input);
            sound(law, formulation, &input, &output);
        }
    });
}

#[test]
fn a_car_right_ahead_is_braked_for() {
    for_each(|law, _| {
        let mut input = ordinary(0);
        input.target = Some(Target {
            track_id: 9,
            gap_m: 8.0,
            relative_speed_mps: -10.0,
            ..Target::default()
        });
        let mut output = Output::default();
        for k in 0..20 {
            input.time_s = 0.1 * f64::from(k);
            output = ask(law, &input);
        }
        assert!(output.request_mps2() < -2.0, "{}", output.request_mps2());
    });
}

#[test]
fn a_car_that_stands_stays_at_a_set_speed_of_0() {
    let far = Target {
        track_id: 1,
        gap_m: 80.0,
        relative_speed_mps: 5.0,
        acceleration_mps2: 0.0,
        age_s: 0.02,
    };
    for target in [None, Some(far)] {
        for_each(|law, _| {
            let mut ego = Ego::default();
            for k in 0..300 {
                let signals = Default::default();
                let input = Input { ego, target, set_speed_mps: 0.0, signals, ..ordinary(k) };
                let request = ask(law, &input).plan_mps2[0];
                for _ in 0..10 {
                    ego.acceleration_mps2 += 0.01 / 0.5 * (request - ego.acceleration_mps2);
                    let speed_mps = ego.speed_mps + 0.01 * ego.acceleration_mps2;
                    if speed_mps <= 0.0 {
                        (ego.speed_mps, ego.acceleration_mps2) = (0.0, 0.0);
                    } else {
                        (ego.speed_mps, ego.position_m) =
                            (speed_mps, ego.position_m + 0.01 * speed_mps);
                    }
                }
                assert!(
                    ego.speed_mps <= 0.01,
                    "{} m/s after {} s",
                    ego.speed_mps,
                    0.1 * f64::from(k)
                );
            }
        });
    }
}

/// Requests and the rest of every output, as bits.
fn fingerprint(law: &mut dyn Law, seed: u64) -> Vec<u64> {
    let mut rng = Pcg64::new(u128::from(seed), 1);
    let mut bits = Vec::new();
    for k in 0..400 {
        let output = ask(law, &random(&mut rng, k));
        bits.extend(output.plan_mps2[..output.plan_len].iter().map(|v| v.to_bits()));
        bits.extend(output.figures.iter().map(|v| v.to_bits()));
        bits.push(u64::from(output.mode) << 32 | u64::from(output.mode_reason));
    }
    bits
}

#[test]
fn reset_brings_back_the_first_behaviour_exactly() {
    for_each(|law, _| {
        let fresh = fingerprint(law, 1);
        assert_ne!(fingerprint(law, 2), fresh);
        law.reset();
        assert_eq!(fingerprint(law, 1), fresh);
        // Also after bad input.
        let mut bad = ordinary(0);
        bad.ego.speed_mps = f64::NAN;
        let _ = ask(law, &bad);
        law.reset();
        assert_eq!(fingerprint(law, 1), fresh);
    });
}

#[test]
fn equal_inputs_give_equal_bits() {
    for subject in subjects() {
        let (mut one, mut other) = (subject.law(), subject.law());
        let name = &subject.name;
        assert_eq!(fingerprint(one.as_mut(), 7), fingerprint(other.as_mut(), 7), "{name}");
    }
}

#[test]
fn a_step_allocates_nothing() {
    for_each(|law, _| {
        let mut rng = Pcg64::new(5, 1);
        let inputs: Vec<Input> = (0..500).map(|k| random(&mut rng, k)).collect();
        let mut output = Output::default();
        let before = counting::allocations();
        for input in &inputs {
            law.step(input, &mut output);
        }
        law.reset();
        assert_eq!(counting::allocations() - before, 0);
    });
}

#[test]
fn planning_allocates_nothing() {
    for_each(|law, _| {
        let Some(planning) = law.planning() else { return };
        let mut planner = planning.planner();
        let mut plan = Plan::default();
        let mut rng = Pcg64::new(6, 1);
        let before = counting::allocations();
        let mut planned = 0;
        for number in 1..300 {
            let input = ordinary(0);
            let request = PlanRequest {
                number,
                position_m: uniform(&mut rng, 0.0, 1000.0),
                speed_mps: uniform(&mut rng, 0.0, 30.0),
                gear: 5,
                set_speed_mps: uniform(&mut rng, 15.0, 25.0),
                speed_limit_mps: f64::INFINITY,
                time_price: 1.0,
                preview: input.preview.expect("it has one"),
                ..PlanRequest::default()
            };
            planned += u32::from(planner.plan(&request, &mut plan));
        }
        assert_eq!(counting::allocations() - before, 0);
        assert!(planned > 50, "{planned}");
    });
}

#[test]
fn the_counter_counts() {
    let before = counting::allocations();
    drop(std::hint::black_box(Box::new(1)));
    assert!(counting::allocations() > before);
}
