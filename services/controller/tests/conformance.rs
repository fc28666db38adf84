//! The suite that every control law passes, whatever its principle: see [`Law`].
//!
//! It takes the laws from the registry: a new law is tested without a line here. [`VARIANTS`] adds
//! settings that choose another formulation or planner.

use controller::law::{
    Descriptor, Ego, Formulation, Input, Law, MAX_PLAN, Output, Phase, PhaseInterval, Plan,
    PlanRequest, Powertrain, Preview, SignalAhead, Target,
};
use controller::laws;
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::Scenario;

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
        let text = format!(
            "schema_version = 1\nname = \"conformance\"\n[controller]\nname = \"{law}\"\n{keys}\n"
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

/// Runs a check for every law; a failure names the law.
fn for_each(check: impl Fn(&mut dyn Law, &Formulation)) {
    for subject in subjects() {
        println!("{}", subject.name);
        check(subject.law().as_mut(), subject.formulation());
    }
}

fn ask(law: &mut dyn Law, input: &Input) -> Output {
    // Whatever was there must be overwritten.
    let mut output = Output { plan_len: 77, mode: 99, solver_iterations: 99, ..Output::default() };
    output.plan_mps2 = [f64::NAN; MAX_PLAN];
    output.figures = [f64::NAN; 8];
    law.step(input, &mut output);
    plan(law);
    output
}

/// Makes the plan that the law wants, before the next step, as the loop's planning thread does.
fn plan(law: &mut dyn Law) {
    if let Some(planning) = law.planning()
        && let Some(request) = planning.request()
    {
        let mut plan = Plan::default();
        planning.planner().plan(&request, &mut plan);
        planning.accept(&plan);
    }
}

/// The promises of a single output.
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

fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * random::uniform(rng)
}

fn signal(distance_m: f64, phases: &[(Phase, f64)]) -> SignalAhead {
    let mut intervals = [PhaseInterval::default(); 8];
    for (slot, (phase, ends_in_s)) in intervals.iter_mut().zip(phases) {
        *slot = PhaseInterval { phase: *phase, ends_in_s: *ends_in_s };
    }
    SignalAhead { id: 257, distance_m, intervals, count: phases.len() }
}

/// An ordinary moment: 20 m/s, a car ahead, a green light.
fn ordinary(k: u32) -> Input {
    let mut input = Input {
        time_s: 0.1 * f64::from(k),
        period_s: 0.1,
        ego: Ego { position_m: 2.0 * f64::from(k), speed_mps: 20.0, acceleration_mps2: 0.0 },
        target: Some(Target {
            track_id: 1,
            gap_m: 45.0,
            relative_speed_mps: -1.0,
            acceleration_mps2: 0.0,
            age_s: 0.02,
        }),
        set_speed_mps: 25.0,
        speed_limit_mps: 30.0,
        ..Input::default()
    };
    input.signals[0] = Some(signal(150.0, &[(Phase::Green, 12.0), (Phase::Red, 40.0)]));
    input.powertrain =
        Some(Powertrain { gear: 5, since_shift_s: 20.0, engine_torque_nm: 800.0, grade: 0.005 });
    input.preview = Some(Preview {
        start_m: 0.0,
        cell_m: 50.0,
        grades: core::array::from_fn(|cell| if cell % 20 < 10 { 0.01 } else { -0.015 }),
        count: 45,
    });
    input
}

/// Random but physical: everything a road shows, changing without continuity.
fn random(rng: &mut Pcg64, k: u32) -> Input {
    let speed = uniform(rng, 0.0, 45.0);
    let mut input = Input {
        time_s: 0.1 * f64::from(k),
        period_s: 0.1,
        ego: Ego {
            position_m: uniform(rng, 0.0, 1e5),
            speed_mps: speed,
            acceleration_mps2: uniform(rng, -9.0, 4.0),
        },
        set_speed_mps: uniform(rng, 0.0, 50.0),
        speed_limit_mps: [f64::INFINITY, 13.9, 27.8][rng.next_u32() as usize % 3],
        ..Input::default()
    };
    if !rng.next_u32().is_multiple_of(4) {
        input.target = Some(Target {
            track_id: rng.next_u32() % 3,
            gap_m: uniform(rng, -1.0, 250.0),
            relative_speed_mps: uniform(rng, -speed, 20.0),
            acceleration_mps2: uniform(rng, -9.0, 4.0),
            age_s: uniform(rng, 0.0, 0.3),
        });
    }
    if !rng.next_u32().is_multiple_of(3) {
        input.powertrain = Some(Powertrain {
            gear: rng.next_u32() as usize % 8,
            since_shift_s: uniform(rng, 0.0, 20.0),
            engine_torque_nm: uniform(rng, -2000.0, 2500.0),
            grade: uniform(rng, -0.06, 0.06),
        });
    }
    if !rng.next_u32().is_multiple_of(3) {
        let start_m = input.ego.position_m - uniform(rng, -100.0, 200.0);
        let grades = core::array::from_fn(|_| uniform(rng, -0.06, 0.06));
        let count = rng.next_u32() as usize % 70;
        input.preview = Some(Preview { start_m, cell_m: 50.0, grades, count });
    }
    for slot in input.signals.iter_mut().take(rng.next_u32() as usize % 3) {
        let phase = [Phase::Unknown, Phase::Green, Phase::Yellow, Phase::Red];
        let phases = [0; 3].map(|_| (phase[rng.next_u32() as usize % 4], uniform(rng, -1.0, 60.0)));
        *slot = Some(signal(uniform(rng, -20.0, 400.0), &phases));
    }
    input
}

/// Every number of an input, to be spoilt one at a time.
fn numbers(input: &mut Input) -> Vec<&mut f64> {
    let mut all = vec![
        &mut input.time_s,
        &mut input.period_s,
        &mut input.ego.position_m,
        &mut input.ego.speed_mps,
        &mut input.ego.acceleration_mps2,
        &mut input.set_speed_mps,
        &mut input.speed_limit_mps,
    ];
    if let Some(t) = &mut input.target {
        let acceleration = &mut t.acceleration_mps2;
        all.extend([&mut t.gap_m, &mut t.relative_speed_mps, acceleration, &mut t.age_s]);
    }
    for s in input.signals.iter_mut().flatten() {
        all.push(&mut s.distance_m);
        all.extend(s.intervals.iter_mut().map(|i| &mut i.ends_in_s));
    }
    if let Some(p) = &mut input.powertrain {
        all.extend([&mut p.since_shift_s, &mut p.engine_torque_nm, &mut p.grade]);
    }
    if let Some(p) = &mut input.preview {
        all.extend([&mut p.start_m, &mut p.cell_m]);
        all.extend(p.grades.iter_mut().step_by(30));
    }
    all
}

const EVIL: [f64; 11] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    1e300,
    -1e9,
    1e9,
    -0.0,
    0.0,
];

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

/// A global allocator that counts the allocations of each thread.
mod counting {
    // The trait `GlobalAlloc` is unsafe to implement, and there is no other way to see allocations.
    #![allow(unsafe_code)]

    use std::alloc::{GlobalAlloc, Layout, System};
    use std::cell::Cell;

    struct Counting;

    thread_local! {
        // Const and without a destructor, so that reading it allocates nothing itself.
        static COUNT: Cell<u64> = const { Cell::new(0) };
    }

    // SAFETY: every method hands its arguments to the system's allocator unchanged and returns what
    // that returns, so the system allocator's guarantees are ours.
    unsafe impl GlobalAlloc for Counting {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            COUNT.with(|c| c.set(c.get() + 1));
            // SAFETY: the caller's obligations are those of `System.alloc`.
            unsafe { System.alloc(layout) }
        }

        unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
            // SAFETY: as above; the pointer came from `System`.
            unsafe { System.dealloc(pointer, layout) }
        }

        unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            COUNT.with(|c| c.set(c.get() + 1));
            // SAFETY: as above; the pointer came from `System`.
            unsafe { System.realloc(pointer, layout, size) }
        }
    }

    #[global_allocator]
    static ALLOCATOR: Counting = Counting;

    /// Allocations of this thread so far.
    pub(super) fn allocations() -> u64 {
        COUNT.with(Cell::get)
    }
}
