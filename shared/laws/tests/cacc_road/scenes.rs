//! Single scenes, each one case that a road brings.

use law::following::kinematics::Lag;
use law::{
    Ego, Input, Law, MAX_SIGNALS, Output, Phase, PhaseInterval, Quality, SignalAhead, SpeedProfile,
    Target,
};
use laws::cacc::config::Config;
use laws::cacc::{Signals, build, road};

use crate::cases::Random;
use crate::solvers::Flaky;
use crate::world::{Event, Signal, World};
use crate::{law, law_with};

/// Course of a run.
#[derive(Debug, Default)]
pub(crate) struct Run {
    world: Option<World>,
    pub(crate) hardest_mps2: f64,
    pub(crate) fastest_mps: f64,
    /// Lowest speed until the last crossing.
    pub(crate) slowest_mps: f64,
    max_jerk_mps3: f64,
    /// Times at which the lines were crossed, s.
    pub(crate) crossings_s: Vec<f64>,
    /// Names of the modes that occurred, in order.
    modes: Vec<&'static str>,
}

impl Run {
    pub(crate) fn world(&self) -> &World {
        self.world.as_ref().expect("a finished run has its world")
    }
}

/// Drives for `seconds` with events at their times; a breach fails the test.
pub(crate) fn run(world: World, seconds: f64, events: &[(f64, Event)]) -> Run {
    run_law(&mut law(), world, seconds, events)
}

pub(crate) fn run_law(
    law: &mut dyn Law,
    mut world: World,
    seconds: f64,
    events: &[(f64, Event)],
) -> Run {
    let mut run = Run { slowest_mps: f64::INFINITY, ..Run::default() };
    let mut output = Output::default();
    let mut next = 0;
    while world.time_s < seconds - 1e-6 {
        while next < events.len() && events[next].0 <= world.time_s + 1e-6 {
            world.apply(events[next].1);
            next += 1;
        }
        let before = world.ego;
        world.step(law, &mut output).expect("no breach");
        run.hardest_mps2 = run.hardest_mps2.min(world.ego.acceleration_mps2);
        run.fastest_mps = run.fastest_mps.max(world.ego.speed_mps);
        if run.crossings_s.len() < world.signals.len() {
            run.slowest_mps = run.slowest_mps.min(world.ego.speed_mps);
        }
        let jerk = (world.ego.acceleration_mps2 - before.acceleration_mps2).abs() / 0.1;
        if world.ego.speed_mps > 0.1 && before.speed_mps > 0.1 {
            run.max_jerk_mps3 = run.max_jerk_mps3.max(jerk);
        }
        let crossed =
            |s: &&Signal| s.line_m > before.position_m && s.line_m <= world.ego.position_m;
        run.crossings_s.extend(world.signals.iter().filter(crossed).map(|_| world.time_s));
        let mode = road::FORMULATION.modes[output.mode as usize];
        if run.modes.last() != Some(&mode) {
            run.modes.push(mode);
        }
    }
    run.world = Some(world);
    run
}

pub(crate) fn with_signal(
    v: f64,
    set: f64,
    line_m: f64,
    lengths_s: [f64; 3],
    phase: usize,
    left_s: f64,
) -> World {
    let mut world = World::new(v, set);
    world.signals.push(Signal { id: 256, line_m, lengths_s, phase, left_s });
    world
}

pub(crate) fn with_lead(mut world: World, gap_m: f64, speed_mps: f64) -> World {
    world.apply(Event::LeadAppears { gap_m, speed_mps });
    world
}

fn short_of_line(run: &Run) -> f64 {
    run.world().signals[0].line_m - run.world().ego.position_m
}

/// It is slow, and stops comfortably before the line where that does not open.
fn glides_to_line(run: &Run) -> bool {
    let (short, v) = (short_of_line(run), run.world().ego.speed_mps);
    short > 0.5 + 0.5 * v + v * v / 6.0 && v < 8.0 && short < 60.0
}

#[test]
fn it_cruises_at_the_set_speed_without_overshoot() {
    let run = run(World::new(5.0, 15.0), 20.0, &[]);
    assert!((run.world().ego.speed_mps - 15.0).abs() < 0.05);
    assert!(run.fastest_mps < 15.1 && run.max_jerk_mps3 < 3.0, "{run:?}");
    assert_eq!(run.modes, ["cruise"]);
}

#[test]
fn the_gap_settles_at_the_time_headway() {
    let run = run(with_lead(World::new(20.0, 25.0), 60.0, 15.0), 60.0, &[]);
    let (ego, lead) = (run.world().ego, run.world().lead.expect("it stays"));
    let error = 1.5 * ego.speed_mps + 5.0 - (lead.position_m - ego.position_m);
    assert!(error.abs() < 0.2, "{error}");
    assert!((ego.speed_mps - 15.0).abs() < 0.05);
    assert!(run.hardest_mps2 > -2.0 && run.max_jerk_mps3 < 3.0, "{run:?}");
}

#[test]
fn it_approaches_a_standing_vehicle_comfortably() {
    let run = run(with_lead(World::new(20.0, 20.0), 150.0, 0.0), 25.0, &[]);
    let gap = 150.0 - run.world().ego.position_m;
    assert!((4.8..5.5).contains(&gap), "{gap}");
    assert!(run.hardest_mps2 > -2.6 && run.max_jerk_mps3 < 2.0, "{run:?}");
}

#[test]
fn it_stops_short_of_a_red_line_and_starts_at_green() {
    let world = with_signal(15.0, 15.0, 200.0, [20.0, 3.0, 20.0], 2, 25.0);
    // While the phase is not known, the line is closed without an end.
    let (lost, heard) = ((0.1, Event::Silence { unknown: true }), (24.0, Event::Heard));
    let stopped = run(world.clone(), 24.0, &[lost]);
    let short = short_of_line(&stopped);
    assert!((0.5..=2.0).contains(&short), "{short}");
    assert_eq!(stopped.world().ego.speed_mps, 0.0);
    assert!(stopped.hardest_mps2 > -3.0, "{stopped:?}");
    let run = run(world, 40.0, &[lost, heard]);
    assert!(run.crossings_s[0] > 25.0 && run.crossings_s[0] < 28.0, "{run:?}");
}

#[test]
fn it_glides_to_a_light_about_to_turn_green() {
    let run = run(with_signal(15.0, 15.0, 120.0, [20.0, 3.0, 20.0], 2, 9.0), 20.0, &[]);
    assert!(run.crossings_s[0] > 9.0 && run.crossings_s[0] < 13.0, "{run:?}");
    assert!(run.hardest_mps2 > -2.5, "{run:?}");
}

#[test]
fn it_accelerates_to_pass_when_that_is_enough() {
    // At 12 m/s the line is 8.3 s away. At the set speed it is less than the 7.5 s that are left.
    let run = run(with_signal(12.0, 16.0, 100.0, [20.0, 3.0, 20.0], 0, 7.5), 15.0, &[]);
    assert!(run.crossings_s[0] < 7.5, "{run:?}");
    assert!(run.fastest_mps < 16.3);
}

#[test]
fn a_pass_that_the_gap_to_the_lead_forbids_is_not_tried() {
    // Without its lead the ego would cross in time. The gap limits its speed: it crossed in red.
    let lengths_s = [20.0, 0.0, 60.0];
    let world = with_lead(with_signal(17.47, 33.3, 134.69, lengths_s, 0, 6.54), 53.2, 17.47);
    let run = run(world, 14.0, &[]);
    assert!(run.crossings_s.is_empty() && run.hardest_mps2 > -3.05, "{run:?}");
}

#[test]
fn it_stops_when_green_is_out_of_reach() {
    let run = run(with_signal(12.0, 13.0, 100.0, [20.0, 3.0, 20.0], 0, 4.5), 20.0, &[]);
    assert!(run.crossings_s.is_empty());
    assert!(glides_to_line(&run), "{run:?}");
    assert!(run.hardest_mps2 > -3.0, "{run:?}");
}

#[test]
fn a_late_yellow_is_crossed_and_an_early_one_is_not() {
    // The announced end of green jumps to now, 20 m and 60 m before the line.
    let at = |seconds: f64| [(seconds, Event::Jump { signal: 0, left_s: 0.01 })];
    let world = with_signal(14.0, 14.0, 140.0, [30.0, 3.0, 20.0], 0, 25.0);
    let late = run(world.clone(), 20.0, &at(8.6));
    assert!(late.crossings_s[0] < 11.6 && late.hardest_mps2 > -1.0, "{late:?}");
    let early = run(world, 20.0, &at(5.7));
    assert!(early.crossings_s.is_empty());
    assert!(early.hardest_mps2 > -3.05, "{early:?}");
}

#[test]
fn it_queues_behind_a_vehicle_at_the_light() {
    let mut world = with_signal(14.0, 14.0, 150.0, [30.0, 3.0, 20.0], 2, 20.0);
    world = with_lead(world, 140.0, 0.0);
    let events = [(21.0, Event::LeadAccelerates(1.5)), (29.0, Event::LeadAccelerates(0.0))];
    let run = run(world, 40.0, &events);
    assert!(run.hardest_mps2 > -3.0);
    assert!(run.crossings_s[0] > 21.0 && run.crossings_s[0] < 32.0, "{run:?}");
}

#[test]
fn a_lead_that_runs_through_late_is_not_followed() {
    let world = with_signal(14.0, 14.0, 110.0, [30.0, 3.0, 20.0], 0, 4.0);
    let run = run(with_lead(world, 26.0, 14.0), 20.0, &[]);
    assert!(run.crossings_s.is_empty());
    assert!(glides_to_line(&run), "{run:?}");
    assert!(run.hardest_mps2 > -3.05, "{run:?}");
}

#[test]
fn a_lead_that_leaves_reveals_the_red_light() {
    let world = with_signal(10.0, 20.0, 250.0, [30.0, 3.0, 30.0], 2, 40.0);
    let run = run(with_lead(world, 25.0, 10.0), 35.0, &[(5.0, Event::LeadLeaves)]);
    assert!(run.crossings_s.is_empty());
    assert!(glides_to_line(&run), "{run:?}");
    assert!(run.hardest_mps2 > -3.0, "{run:?}");
}

#[test]
fn a_lost_signal_is_not_green() {
    for unknown in [false, true] {
        let world = with_signal(14.0, 14.0, 160.0, [60.0, 3.0, 20.0], 0, 50.0);
        let lost = [(4.0, Event::Silence { unknown }), (25.0, Event::Heard)];
        let run = run(world, 40.0, &lost);
        assert!(run.crossings_s[0] > 25.0 && run.crossings_s[0] < 29.0, "{run:?}");
        assert!(run.hardest_mps2 > -3.0, "{run:?}");
    }
}

#[test]
fn a_corridor_is_driven_without_a_breach() {
    let mut world = World::new(12.0, 14.0);
    for (i, (line_m, phase, left_s)) in
        [(150.0, 2, 15.0), (350.0, 0, 20.0), (520.0, 1, 1.0)].into_iter().enumerate()
    {
        let id = 256 + i as u32;
        world.signals.push(Signal { id, line_m, lengths_s: [18.0, 3.0, 15.0], phase, left_s });
    }
    let run = run(world, 120.0, &[]);
    assert_eq!(run.crossings_s.len(), 3, "{run:?}");
    assert!(run.hardest_mps2 > -3.0, "{run:?}");
}

#[test]
fn a_near_cut_in_with_equal_speed_is_no_emergency() {
    let world = World::new(20.0, 20.0);
    let run = run(world, 20.0, &[(3.0, Event::LeadAppears { gap_m: 14.0, speed_mps: 19.0 })]);
    assert!(run.hardest_mps2 > -3.0, "{run:?}");
}

#[test]
fn acc_ignores_the_light() {
    let mut acc = build(Signals::Ignored, &Config::default()).expect("the default is valid");
    let mut world = with_signal(12.0, 12.0, 200.0, [20.0, 3.0, 20.0], 2, 8.0);
    world.signals[0].left_s = 60.0;
    let mut output = Output::default();
    for _ in 0..100 {
        world.step(&mut *acc, &mut output).expect("the line is not reached");
    }
    assert!((world.ego.speed_mps - 12.0).abs() < 0.01);
}

fn red_ahead() -> Input {
    let mut input = Input {
        time_s: 1.0,
        period_s: 0.1,
        ego: Ego { position_m: 10.0, speed_mps: 13.0, acceleration_mps2: 0.2 },
        target: Some(Target {
            track_id: 1,
            gap_m: 40.0,
            relative_speed_mps: -2.0,
            acceleration_mps2: -0.5,
            age_s: 0.0,
        }),
        set_speed_mps: 15.0,
        speed_limit_mps: 14.0,
        ..Input::default()
    };
    let mut signal = SignalAhead { id: 7, distance_m: 60.0, count: 1, ..SignalAhead::default() };
    signal.intervals[0] = PhaseInterval { phase: Phase::Red, ends_in_s: 12.0 };
    input.signals[0] = Some(signal);
    input
}

#[test]
fn the_plan_is_exported_whole_and_repeats_to_the_bit() {
    let (mut one, mut two) = (Output::default(), Output::default());
    let mut law = law();
    law.step(&red_ahead(), &mut one);
    assert_eq!((one.plan_len, one.quality), (100, Quality::Full));
    law.step(&Input { time_s: 1.1, ..red_ahead() }, &mut two);
    law.reset();
    law.step(&red_ahead(), &mut two);
    assert_eq!(one, two);
}

#[test]
fn the_plan_keeps_to_the_speeds_that_the_road_allows_along_the_horizon() {
    let mut profile = SpeedProfile::constant(20.0);
    profile.cap(120.0, 140.0, 12.0, 1.5);
    profile.brake(1.5);
    let lag = Lag { tau_s: Config::default().model_time_constant_s }.discretise(0.1);
    let planned = |profile: Option<SpeedProfile>| {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let speed_limit_mps = f64::INFINITY;
        let free =
            Input { period_s: 0.1, ego, set_speed_mps: 20.0, speed_limit_mps, ..Input::default() };
        let mut output = Output::default();
        law().step(&Input { profile, ..free }, &mut output);
        let mut at = ego.motion();
        let advance = |request: &f64| {
            at = lag.advance(at, *request);
            at
        };
        output.plan_mps2[..output.plan_len].iter().map(advance).collect::<Vec<_>>()
    };
    let plan = planned(Some(profile));
    for at in &plan {
        let allowed_mps = profile.at_mps(at.position_m);
        assert!(at.speed_mps <= allowed_mps + 0.3, "{at:?}, {allowed_mps} m/s");
        assert!(at.acceleration_mps2 >= -2.0, "{at:?}");
    }
    let slowest_mps = plan.iter().map(|at| at.speed_mps).fold(f64::INFINITY, f64::min);
    assert!((11.0..12.3).contains(&slowest_mps), "{slowest_mps}");
    assert!(planned(None).iter().all(|at| (at.speed_mps - 20.0).abs() < 0.01));
}

#[test]
fn a_failed_solve_follows_the_previous_plan_and_then_the_driver() {
    let real = Config::default().create_solver();
    let mut law = law_with(Box::new(Flaky::new(real, 1)));
    let (mut first, mut second, mut late) =
        (Output::default(), Output::default(), Output::default());
    let follow = |time_s| Input { time_s, signals: [None; MAX_SIGNALS], ..red_ahead() };
    law.step(&follow(1.0), &mut first);
    assert_eq!(first.quality, Quality::Full);
    law.step(&follow(1.1), &mut second);
    assert_eq!((second.quality, second.plan_len), (Quality::Backup, 99));
    assert_eq!(second.plan_mps2[..99], first.plan_mps2[1..100]);
    // By now the plan is too old; the driver's whole trajectory takes its place.
    law.step(&follow(2.0), &mut late);
    assert_eq!((late.quality, late.plan_len), (Quality::Backup, 100));
    assert_ne!(late.plan_mps2[..90], first.plan_mps2[10..100]);
}

#[test]
fn false_numbers_never_reach_the_command() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300];
    let mut law = law();
    let mut output = Output::default();
    for x in bad {
        for field in 0..12 {
            let mut input = red_ahead();
            let mut target = input.target.expect("there is one");
            let mut signal = input.signals[0].expect("there is one");
            match field {
                0 => input.time_s = x,
                1 => input.period_s = x,
                2 => input.ego.position_m = x,
                3 => input.ego.speed_mps = x,
                4 => input.ego.acceleration_mps2 = x,
                5 => target.gap_m = x,
                6 => target.relative_speed_mps = x,
                7 => target.acceleration_mps2 = x,
                8 => signal.distance_m = x,
                9 => signal.intervals[0].ends_in_s = x,
                10 => input.set_speed_mps = x,
                _ => input.speed_limit_mps = x,
            }
            input.target = Some(target);
            input.signals[0] = Some(signal);
            law.reset();
            law.step(&input, &mut output);
            assert!(output.plan_len >= 1);
            for u in &output.plan_mps2[..output.plan_len] {
                assert!((-4.9..=4.9).contains(u), "field {field} at {x}: {u}");
            }
        }
    }
}
#[test]
fn measurement_noise_is_not_passed_on() {
    let (mut law, mut output, mut random) = (law(), Output::default(), Random::new(5));
    let mut noise = |deviation: f64| {
        // The sum of three uniform numbers, scaled to the standard deviation.
        let sum = random.unit() + random.unit() + random.unit() - 1.5;
        2.0 * deviation * sum
    };
    let mut world = with_lead(World::new(15.0, 20.0), 27.5, 15.0);
    let mut squares = 0.0;
    for step in 0..600 {
        let mut input = world.input();
        let mut target = input.target.expect("there is a lead");
        target.gap_m += noise(0.3);
        target.relative_speed_mps += noise(0.1);
        target.acceleration_mps2 += noise(0.3);
        input.target = Some(target);
        law.step(&input, &mut output);
        let before = world.ego.acceleration_mps2;
        world.advance(output.request_mps2()).expect("no breach");
        let jerk = (world.ego.acceleration_mps2 - before) / 0.1;
        squares += if step >= 50 { jerk * jerk } else { 0.0 };
    }
    let rms = (squares / 550.0).sqrt();
    assert!(rms < 0.2, "{rms} m/s³");
    assert!((world.ego.speed_mps - 15.0).abs() < 0.2);
}
