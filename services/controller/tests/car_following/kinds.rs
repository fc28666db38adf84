//! Random drives of everyday kinds behind one vehicle, judged by an oracle that has the whole drive.
//!
//! | kind | what happens | what is held |
//! |---|---|---|
//! | pulls away | a faster car cuts in closely | no braking above 3 m/s² where 1.5 is enough |
//! | cut-in | a car cuts in that is 1 to 3 m/s slower | the same |
//! | slow lead | a car ahead has 40 to 70 % of the ego's speed | the same |
//! | falling set speed | the set speed falls on an empty road | braking of 3 m/s² at most |
//! | stop and go | a lead stops again and again | a mean time gap of 3 s, and the same as for a cut-in |
//! | lost tracks | no tracks for 1 to 3 s while the lead brakes | no acceleration while blind, no contact |
//!
//! The oracle integrates constant braking with 1.5 m/s² from the first moment at which the lead was ahead. The lead has
//! its real motion. It shares no code with the laws.

use controller::ladder::{Admission, Ages, Ladder};
use controller::law::{Ego, Input, Law, Output, Target};
use controller::laws;
use rand_pcg::Pcg64;
use scenario::Scenario;

use crate::world::{LAG_S, STEP_S, Vehicle};

/// Steps from one release to the next, and the period, s.
const RELEASE_STEPS: usize = 10;
const PERIOD_S: f64 = 0.1;
/// Braking that is gentle, and that which needs a reason, m/s².
const GENTLE_MPS2: f64 = 1.5;
const HARD_MPS2: f64 = 3.0;
/// Gap that gentle braking must leave to be enough, m.
const ENOUGH_M: f64 = 4.0;
/// Drives of each kind.
const DRIVES: u64 = 40;

/// One drive: the ego, its set speed over time, a lead with its acceleration over time.
struct Drive {
    ego_mps: f64,
    set_mps: fn(f64, f64) -> f64,
    lead: Option<Vehicle>,
    /// Accelerations of the lead from a time on, s and m/s².
    lead_mps2: Vec<(f64, f64)>,
    /// Time without tracks, s.
    blind_s: (f64, f64),
    duration_s: f64,
}

/// Observation of a drive.
struct Seen {
    ego: Vec<Vehicle>,
    lead: Vec<Vehicle>,
    /// Largest request while no tracks came, m/s².
    most_blind_mps2: f64,
    largest_jerk_mps3: f64,
}

fn run(law: &str, drive: &Drive) -> Seen {
    let text = format!("schema_version = 1\nname = \"kinds\"\n[controller]\nname = \"{law}\"\n");
    let scenario = Scenario::parse("kinds", &text).expect("the keys are right");
    let mut law = laws::build(&scenario).unwrap_or_else(|problem| panic!("{law}: {problem:?}"));
    let mut ladder = Ladder::new(&scenario);
    let mut ego = Vehicle { speed_mps: drive.ego_mps, ..Vehicle::default() };
    let mut lead = drive.lead.unwrap_or(Vehicle { position_m: 1e6, ..Vehicle::default() });
    let mut output = Output::default();
    let mut tracked_s = 0.0;
    let mut seen = Seen {
        ego: vec![ego],
        lead: vec![lead],
        most_blind_mps2: f64::NEG_INFINITY,
        largest_jerk_mps3: 0.0,
    };
    for step in 0..(drive.duration_s / STEP_S) as usize {
        let time_s = step as f64 * STEP_S;
        let is_blind = (drive.blind_s.0..drive.blind_s.1).contains(&time_s);
        if step.is_multiple_of(RELEASE_STEPS) {
            tracked_s = if is_blind { tracked_s } else { time_s };
            let target = drive.lead.filter(|_| !is_blind).map(|_| Target {
                track_id: 1,
                gap_m: lead.position_m - ego.position_m,
                relative_speed_mps: lead.speed_mps - ego.speed_mps,
                acceleration_mps2: lead.acceleration_mps2,
                age_s: 0.0,
            });
            let input = Input {
                time_s,
                period_s: PERIOD_S,
                ego: Ego {
                    position_m: ego.position_m,
                    speed_mps: ego.speed_mps,
                    acceleration_mps2: ego.acceleration_mps2,
                },
                target,
                set_speed_mps: (drive.set_mps)(drive.ego_mps, time_s),
                speed_limit_mps: f64::INFINITY,
                ..Input::default()
            };
            ask(&mut ladder, law.as_mut(), input, time_s - tracked_s, &mut output);
            if is_blind && time_s - tracked_s > 0.3 {
                seen.most_blind_mps2 = seen.most_blind_mps2.max(output.request_mps2());
            }
        }
        let before = ego.acceleration_mps2;
        ego.follow(output.request_mps2());
        if ego.speed_mps > 0.0 {
            let jerk = (ego.acceleration_mps2 - before).abs() / STEP_S;
            seen.largest_jerk_mps3 = seen.largest_jerk_mps3.max(jerk);
        }
        let now = drive.lead_mps2.iter().rev().find(|(from_s, _)| *from_s <= time_s);
        lead.advance(now.map_or(0.0, |now| now.1));
        seen.ego.push(ego);
        seen.lead.push(lead);
    }
    seen
}

/// One release, as the control loop does it.
fn ask(ladder: &mut Ladder, law: &mut dyn Law, mut input: Input, age_s: f64, output: &mut Output) {
    let ages = Ages { odometry_s: Some(0.0), radar_s: Some(age_s), ..Ages::default() };
    ladder.look(&ages, input.time_s);
    match ladder.admit(&mut input, None) {
        Admission::Law => {
            law.step(&input, output);
            output.bound_from_above(ladder.most_mps2());
        }
        Admission::Brake => {
            ladder.brake(&input.ego, PERIOD_S, law.request_bounds_mps2(), output);
        }
        Admission::Silence => panic!("odometry is there"),
    }
    ladder.settle(output, true);
}

/// True if gentle braking from the start of the drive keeps a gap to the lead as it really drove.
fn gentle_is_enough(seen: &Seen) -> bool {
    let (mut x, mut v, mut a) = (0.0, seen.ego[0].speed_mps, 0.0);
    seen.lead.iter().all(|lead| {
        a += STEP_S / LAG_S * (-GENTLE_MPS2 - a);
        v = f64::max(v + STEP_S * a, 0.0);
        x += STEP_S * v;
        lead.position_m - x > ENOUGH_M.min(0.7 * seen.lead[0].position_m)
    })
}

fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * random::uniform(rng)
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

/// Behind a lead that drives evenly at a share of the ego's speed plus a difference.
fn steady_lead(ego_mps: f64, gap_m: f64, lead_mps: f64) -> Drive {
    Drive {
        ego_mps,
        set_mps: |ego_mps, _| ego_mps,
        lead: Some(Vehicle { position_m: gap_m, speed_mps: lead_mps, acceleration_mps2: 0.0 }),
        lead_mps2: Vec::new(),
        blind_s: (0.0, 0.0),
        duration_s: 25.0,
    }
}

/// Checks drives of a kind with the law whose aim is comfort.
fn for_each(kind: &str, make: impl Fn(&mut Pcg64) -> Drive, check: impl Fn(&str, &Seen)) {
    for seed in 0..DRIVES {
        let seen = run("six-mode", &make(&mut Pcg64::new(u128::from(seed), 31)));
        let gap_m =
            least(seen.ego.iter().zip(&seen.lead).map(|(e, l)| l.position_m - e.position_m));
        assert!(gap_m > 0.0, "{kind}, seed {seed}: contact");
        check(&format!("{kind}, seed {seed}"), &seen);
    }
}

/// If gentle braking is enough, braking is not hard and the jerk is bounded.
fn is_comfortable(name: &str, seen: &Seen) {
    if gentle_is_enough(seen) {
        let hardest = -least(seen.ego.iter().map(|ego| ego.acceleration_mps2));
        assert!(hardest <= HARD_MPS2, "{name}: {hardest} m/s²");
        assert!(seen.largest_jerk_mps3 <= 5.0, "{name}: {} m/s³", seen.largest_jerk_mps3);
    }
}

#[test]
fn a_faster_car_that_cuts_in_is_let_go() {
    let make = |rng: &mut Pcg64| {
        let ego_mps = uniform(rng, 12.0, 34.0);
        steady_lead(ego_mps, uniform(rng, 3.5, 15.0), ego_mps + uniform(rng, 0.5, 4.0))
    };
    for_each("pulls away", make, is_comfortable);
}

#[test]
fn a_slightly_slower_car_that_cuts_in_is_met_gently() {
    let make = |rng: &mut Pcg64| {
        let ego_mps = uniform(rng, 12.0, 34.0);
        steady_lead(ego_mps, uniform(rng, 15.0, 40.0), ego_mps - uniform(rng, 1.0, 3.0))
    };
    for_each("cut-in", make, is_comfortable);
}

#[test]
fn a_slow_lead_is_approached_gently() {
    let make = |rng: &mut Pcg64| {
        let ego_mps = uniform(rng, 15.0, 34.0);
        steady_lead(ego_mps, uniform(rng, 90.0, 170.0), ego_mps * uniform(rng, 0.4, 0.7))
    };
    for_each("slow lead", make, is_comfortable);
}

#[test]
fn a_set_speed_that_falls_is_followed_gently() {
    let make = |rng: &mut Pcg64| Drive {
        lead: None,
        set_mps: |ego_mps, time_s| if time_s < 5.0 { ego_mps } else { 0.4 * ego_mps },
        ..steady_lead(uniform(rng, 10.0, 35.0), 0.0, 0.0)
    };
    for_each("falling set speed", make, |name, seen| {
        let hardest = -least(seen.ego.iter().map(|ego| ego.acceleration_mps2));
        assert!(hardest <= HARD_MPS2, "{name}: {hardest} m/s²");
        assert!(seen.largest_jerk_mps3 <= 5.0, "{name}: {} m/s³", seen.largest_jerk_mps3);
    });
}

#[test]
fn stop_and_go_keeps_a_gap_that_traffic_accepts() {
    let make = |rng: &mut Pcg64| {
        let (mut lead_mps2, mut time_s) = (vec![], 2.0);
        for _ in 0..4 {
            let (top_mps, up_mps2) = (uniform(rng, 6.0, 14.0), uniform(rng, 0.8, 1.6));
            lead_mps2.push((time_s, up_mps2));
            lead_mps2.push((time_s + top_mps / up_mps2, 0.0));
            time_s += top_mps / up_mps2 + uniform(rng, 4.0, 12.0);
            lead_mps2.push((time_s, -uniform(rng, 0.8, 1.8)));
            time_s += uniform(rng, 20.0, 25.0);
        }
        let set_mps = |_: f64, _: f64| 20.0;
        Drive { lead_mps2, set_mps, duration_s: time_s, ..steady_lead(0.0, 7.5, 0.0) }
    };
    for_each("stop and go", make, |name, seen| {
        let moving = || seen.ego.iter().zip(&seen.lead).filter(|(ego, _)| ego.speed_mps > 2.0);
        let gaps_m: f64 = moving().map(|(ego, lead)| lead.position_m - ego.position_m).sum();
        let speeds_mps: f64 = moving().map(|(ego, _)| ego.speed_mps).sum();
        assert!(gaps_m / speeds_mps <= 3.0, "{name}: {} s", gaps_m / speeds_mps);
        let hardest = -least(seen.ego.iter().map(|ego| ego.acceleration_mps2));
        assert!(hardest <= HARD_MPS2, "{name}: {hardest} m/s²");
        assert!(seen.largest_jerk_mps3 <= 5.0, "{name}: {} m/s³", seen.largest_jerk_mps3);
    });
}

#[test]
fn nothing_accelerates_into_a_lead_whose_tracks_are_lost_while_it_brakes() {
    let make = |rng: &mut Pcg64| {
        let (ego_mps, brakes_s) = (uniform(rng, 14.0, 30.0), uniform(rng, 8.0, 10.0));
        let lost_s = brakes_s + uniform(rng, 0.5, 1.5);
        let lead_mps2 = vec![(brakes_s, -uniform(rng, 1.0, 3.5))];
        let blind_s = (lost_s, lost_s + uniform(rng, 1.0, 3.0));
        let set_mps = |ego_mps: f64, _: f64| ego_mps + 4.0;
        let gap_m = 5.0 + 1.6 * ego_mps;
        Drive { lead_mps2, blind_s, set_mps, ..steady_lead(ego_mps, gap_m, ego_mps) }
    };
    for_each("lost tracks", make, |name, seen| {
        assert!(seen.most_blind_mps2 <= 0.0, "{name}: {} m/s²", seen.most_blind_mps2);
    });
}

#[test]
fn without_any_tracks_on_a_free_road_speed_hardly_grows() {
    let make = |rng: &mut Pcg64| Drive {
        lead: None,
        blind_s: (2.0, 4.0),
        set_mps: |ego_mps, _| ego_mps + 10.0,
        ..steady_lead(uniform(rng, 5.0, 30.0), 0.0, 0.0)
    };
    for_each("blind on a free road", make, |name, seen| {
        assert!(seen.most_blind_mps2 <= 0.3, "{name}: {} m/s²", seen.most_blind_mps2);
    });
}
