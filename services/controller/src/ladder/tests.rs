use super::*;
use crate::law::{SignalAhead, Target};
use proptest::prelude::*;

const PERIOD_S: f64 = 0.1;
const BOUNDS_MPS2: (f64, f64) = (-6.0, 2.0);

fn ladder() -> Ladder {
    let text = "schema_version = 1\nname = \"ladder\"\n[[v2x.signals]]\nintersection_id = 1\n\
                stop_line_m = 500\nprogram = [{ phase = \"green\", duration_s = 5 }]";
    Ladder::new(&Scenario::parse("ladder", text).expect("a scenario"))
}

fn input(time_s: f64) -> Input {
    Input {
        time_s,
        period_s: PERIOD_S,
        ego: Ego { position_m: 20.0 * time_s, speed_mps: 20.0, acceleration_mps2: 0.0 },
        target: Some(Target { track_id: 1, gap_m: 40.0, ..Target::default() }),
        signals: [Some(SignalAhead::default()); crate::law::MAX_SIGNALS],
        ..Input::default()
    }
}

/// A drive in which each input can be silent: its newest valid sample ages meanwhile.
struct Drive {
    ladder: Ladder,
    cycle: u32,
    heard_s: [f64; 3],
}

impl Drive {
    fn new() -> Self {
        Self { ladder: ladder(), cycle: 0, heard_s: [0.0; 3] }
    }

    /// One release; `there` says which of odometry, radar and signal timing arrive.
    fn release(&mut self, there: [bool; 3]) -> (Admission, SignalTrust, Input, Ages) {
        let time_s = f64::from(self.cycle) * PERIOD_S;
        self.cycle += 1;
        for (heard_s, there) in self.heard_s.iter_mut().zip(there) {
            if there {
                *heard_s = time_s;
            }
        }
        let age = |k: usize| Some(time_s - self.heard_s[k]);
        let ages = Ages { odometry_s: age(0), radar_s: age(1), spat_s: age(2), ..Ages::default() };
        let trust = self.ladder.look(&ages, time_s);
        let mut input = input(time_s);
        let admission = self.ladder.admit(&mut input, None);
        if admission != Admission::Silence {
            self.ladder.settle(&Output::default(), true);
        }
        (admission, trust, input, ages)
    }

    fn level(&self) -> Level {
        self.ladder.level
    }
}

const ALL: [bool; 3] = [true; 3];

#[test]
fn a_blind_radar_is_predicted_then_braked_for_and_used_again_after_five_samples() {
    let mut drive = Drive::new();
    drive.release(ALL);
    let mut levels = Vec::new();
    for _ in 0..30 {
        drive.release([true, false, true]);
        levels.push(drive.level());
    }
    assert_eq!(levels[0], Level::Full, "one sample late is not a loss");
    assert_eq!(levels[3], Level::LeadPredicted);
    assert_eq!((levels[20], levels[29]), (Level::LeadPredicted, Level::LeadLost));
    let back: Vec<Admission> = (0..6).map(|_| drive.release(ALL).0).collect();
    let expected = [[Admission::Brake; 4].as_slice(), &[Admission::Law; 2]].concat();
    assert_eq!(back, expected);
    assert_eq!(drive.level(), Level::Full);
}

#[test]
fn signal_timing_is_used_as_far_as_it_is_proven_and_then_not_at_all() {
    let mut drive = Drive::new();
    drive.release(ALL);
    let trust: Vec<SignalTrust> = (0..80).map(|_| drive.release([true, true, false]).1).collect();
    assert_eq!(trust[1], SignalTrust::Announced);
    assert_eq!(trust[10], SignalTrust::Proven);
    assert_eq!(trust[60], SignalTrust::None);
    assert_eq!(drive.level(), Level::SignalsLost);
}

#[test]
fn without_odometry_a_last_plan_brakes_and_then_there_is_no_command() {
    let mut drive = Drive::new();
    drive.release(ALL);
    let admissions: Vec<Admission> = (0..5).map(|_| drive.release([false, true, true]).0).collect();
    assert_eq!(admissions[1], Admission::Brake);
    assert_eq!(admissions[2..], [Admission::Silence; 3]);
}

#[test]
fn comfortable_braking_sets_in_gently_and_lasts() {
    let ladder = ladder();
    let mut output = Output::default();
    ladder.brake(&input(0.0).ego, PERIOD_S, BOUNDS_MPS2, &mut output);
    assert_eq!(output.plan_len, MAX_PLAN);
    assert!(
        output.plan_mps2[0] > -0.3 && output.plan_mps2[MAX_PLAN - 1] == -blind::COMFORTABLE_MPS2
    );
    assert!(output.plan_mps2.windows(2).all(|w| w[1] <= w[0] && w[0] - w[1] < 0.26));
}

#[test]
fn hard_braking_goes_on_when_the_lead_is_lost() {
    let mut ladder = ladder();
    let mut output = Output::default();
    output.plan_mps2[0] = -5.0;
    output.plan_len = 1;
    ladder.settle(&output, true);
    ladder.brake(&input(0.0).ego, PERIOD_S, BOUNDS_MPS2, &mut output);
    assert!(output.plan_mps2.iter().all(|request| *request == -5.0));
}

#[test]
fn an_estimated_ego_and_doubted_signals_show() {
    let mut ladder = ladder();
    let ages =
        Ages { odometry_s: Some(0.0), radar_s: Some(0.0), spat_s: Some(0.0), ..Ages::default() };
    ladder.look(&Ages { signals_doubted: true, ..ages }, 0.0);
    assert_eq!(ladder.level, Level::SignalsDoubted);
    ladder.look(&Ages { ego_is_estimated: true, ..ages }, 0.1);
    assert_eq!(ladder.level, Level::EgoEstimated);
}

proptest! {
    /// Random silences of all inputs. The ladder never commands from stale data, never stays stuck,
    /// and is back to full function after the faults end.
    #[test]
    fn whatever_falls_silent(
        faults in prop::collection::vec((any::<[bool; 3]>(), 1_u32..25), 0..30),
    ) {
        let mut drive = Drive::new();
        let mut steps: Vec<[bool; 3]> = vec![ALL];
        for (there, cycles) in faults {
            steps.extend((0..cycles).map(|_| there));
        }
        for there in steps {
            let (admission, trust, input, ages) = drive.release(there);
            let stale = |age: Option<f64>, bound: f64| age.is_none_or(|age| age > bound + 1e-9);
            if admission == Admission::Law {
                prop_assert!(!stale(ages.odometry_s, drive.ladder.stale_odometry_s));
                prop_assert!(!stale(ages.radar_s, drive.ladder.stale_radar_s + PREDICT_S));
                let age_s = input.target.map_or(0.0, |target| target.age_s);
                prop_assert!(age_s <= drive.ladder.stale_radar_s + PREDICT_S + 1e-9);
            }
            if trust == SignalTrust::Announced {
                prop_assert!(!stale(ages.spat_s, drive.ladder.stale_spat_s));
            }
            if trust == SignalTrust::Proven {
                prop_assert!(!stale(ages.spat_s, BELIEVE_SIGNALS_S));
            }
        }
        for _ in 0..5 {
            drive.release(ALL);
        }
        prop_assert_eq!(drive.level(), Level::Full);
    }
}
