use bytemuck::Zeroable;
use proptest::prelude::*;
use scenario::Overrides;

use super::*;
use crate::tracking::Track;

const PERIOD_NS: u64 = 50_000_000;

fn scenario(name: &str, keys: &[&str]) -> Scenario {
    let mut overrides = Overrides::new();
    for key in keys {
        overrides.set(key.parse().unwrap_or_else(|error| panic!("{error}")));
    }
    Scenario::open(name, &overrides, &|_| Ok(Default::default()))
        .unwrap_or_else(|error| panic!("{error}"))
}

const OBJECT_LIST: &str = "perception.radar.model=\"object-list\"";

const EXACT: [&str; 6] = [
    OBJECT_LIST,
    "perception.radar.range_sigma_m=0",
    "perception.radar.range_rate_sigma_mps=0",
    "perception.radar.azimuth_sigma_deg=0",
    "perception.radar.dropout_probability=0",
    "perception.radar.latency_ms=0",
];

/// A perception with a place for its detections.
struct Watch {
    perception: Perception,
    detections: Box<[Detection; MAX_DETECTIONS]>,
}

impl Watch {
    fn new(scenario: &Scenario) -> Self {
        let detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
        Self { perception: Perception::new(scenario), detections }
    }

    fn step(&mut self, time_ns: u64, ego: &Ego) -> TrackList {
        *self.perception.step(time_ns, ego, &mut self.detections)
    }

    fn lead(&self) -> Vehicle {
        self.perception.vehicles()[0]
    }
}

/// The ego at constant speed.
fn ego(time_ns: u64, speed_mps: f64) -> Ego {
    Ego { position_m: speed_mps * time_ns as f64 * 1e-9, speed_mps, acceleration_mps2: 0.0 }
}

#[test]
fn ideal_tracks_are_the_truth_from_the_first_scan_on() {
    let mut watch = Watch::new(&scenario("cacc-b", &[]));
    for k in 0..200 {
        let ego = ego(k * PERIOD_NS, 15.0);
        let list = watch.step(k * PERIOD_NS, &ego);
        let truth = watch.lead();
        let track = *list.target().expect("the lead is in the path");
        assert_eq!(list.acquisition_ns, (k * PERIOD_NS) as i64);
        assert_eq!(track.id, 1);
        assert_eq!(track.gap_m, truth.rear_position_m - ego.position_m);
        assert_eq!(track.relative_speed_mps, truth.speed_mps - 15.0);
        assert_eq!(track.acceleration_mps2, truth.acceleration_mps2);
    }
    assert_eq!(watch.perception.report().gospa_m, 0.0);
}

#[test]
fn a_lead_is_tracked_within_its_filters_errors() {
    for model in [OBJECT_LIST, "perception.radar.model=\"detections\""] {
        let mut watch = Watch::new(&scenario("following", &[model]));
        let (mut gap, mut speed, mut count) = (0.0, 0.0, 0.0);
        for k in 0..600 {
            let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
            if k < 20 {
                continue;
            }
            let track = list.target().expect("the lead is in the path");
            let scene = watch.perception.scanned();
            let truth = scene.vehicles[0];
            gap += (track.gap_m - truth.rear_position_m + scene.ego.position_m).powi(2);
            speed += (track.relative_speed_mps - truth.speed_mps + 22.0).powi(2);
            count += 1.0;
        }
        let (gap, speed): (f64, f64) = ((gap / count).sqrt(), (speed / count).sqrt());
        assert!(gap > 0.01 && gap < 0.25, "{model}: gap off by {gap}");
        assert!(speed > 0.01 && speed < 0.15, "{model}: speed off by {speed}");
    }
}

#[test]
fn detections_have_the_lead_when_the_run_begins() {
    let mut watch = Watch::new(&scenario("following", &["perception.radar.latency_ms=50"]));
    let list = watch.step(0, &ego(0, 22.0));
    let track = list.target().expect("the lead has been there before");
    assert_eq!(list.acquisition_ns, -50_000_000);
    assert!((track.gap_m - 50.0).abs() < 1.0 && track.relative_speed_mps.abs() < 0.5);
}

#[test]
fn a_cut_in_and_a_cut_out_change_the_target_once_each() {
    for model in [OBJECT_LIST, "perception.radar.model=\"detections\""] {
        for seed in 1..=20 {
            let seed = format!("seed={seed}");
            let mut watch = Watch::new(&scenario("cut-in", &[&seed, model]));
            let mut targets: Vec<(f64, Option<u32>)> = Vec::new();
            for k in 0..800 {
                let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
                let id = list.target().map(|track| track.id);
                if targets.last().is_none_or(|last| last.1 != id) {
                    targets.push((k as f64 * 0.05, id));
                }
            }
            // No target, the car, the lorry. Between the two the target may be missing for a moment.
            let seen: Vec<_> = targets.iter().filter_map(|(_, id)| *id).collect();
            assert_eq!(seen.len(), 2, "{model} {seed}: {targets:?}");
            assert_eq!(targets[0].1, None);
            // The bodies overlap at 8.47 s: 3.5 m in 3 s from 7 s on. Noise and latency add to it.
            assert!((7.5..8.8).contains(&targets[1].0), "{model} {seed}: {targets:?}");
            // It leaves the path at 2.2 m, at 26.9 s.
            let lorry = targets.last().expect("there are some").0;
            assert!((26.5..29.0).contains(&lorry), "{model} {seed}: {targets:?}");
            assert_eq!(watch.perception.report().cut_ins, 1);
        }
    }
}

#[test]
fn latency_delays_the_scan_and_nothing_else() {
    let mut keys = EXACT.to_vec();
    keys[5] = "perception.radar.latency_ms=150";
    let mut late = Watch::new(&scenario("following", &keys));
    let mut prompt = Watch::new(&scenario("following", &EXACT));
    let mut history = Vec::new();
    for k in 0..100u64 {
        let ego = ego(k * PERIOD_NS, 22.0);
        history.push(prompt.step(k * PERIOD_NS, &ego));
        let list = late.step(k * PERIOD_NS, &ego);
        assert_eq!(list.acquisition_ns, (k * PERIOD_NS) as i64 - 150_000_000);
        let track = list.target().expect("the lead is in the path");
        if k < 3 {
            // Before the start both kept their speed.
            assert!((track.gap_m - 50.0).abs() < 1e-9);
        } else {
            let then = history[k as usize - 3].target().expect("it was in the path");
            assert!((track.gap_m - then.gap_m).abs() < 1e-6);
            assert!((track.acceleration_mps2 - then.acceleration_mps2).abs() < 0.01);
        }
    }
}

/// The scan of an instant is the same whether it comes out at once or late.
#[test]
fn detections_belong_to_their_scan() {
    let scans = |latency: &str| {
        let mut watch = Watch::new(&scenario("cut-in", &[latency]));
        let mut scans = Vec::new();
        for k in 0..100u64 {
            let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
            let count = watch.perception.received.count;
            scans.push((list.acquisition_ns, watch.detections[..count].to_vec()));
        }
        scans
    };
    let (prompt, late) =
        (scans("perception.radar.latency_ms=0"), scans("perception.radar.latency_ms=100"));
    assert!(prompt.iter().all(|(_, detections)| !detections.is_empty()));
    assert_eq!(prompt[..98], late[2..]);
}

#[test]
fn a_track_out_of_range_coasts_and_then_ends() {
    let mut keys = EXACT.to_vec();
    keys.push("perception.radar.max_range_m=60.2");
    let mut watch = Watch::new(&scenario("following", &keys));
    // The lead at 22 m/s leaves the range of an ego at 12 m/s after one second.
    let mut last = None;
    for k in 0..80 {
        let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 12.0));
        if let Some(track) = list.target() {
            assert_eq!(track.measured, track.gap_m <= 60.2, "{track:?}");
            last = Some(k);
        }
    }
    // It was in the path for long, so that it is carried on for 2.5 s.
    assert_eq!(last, Some(20 + 50));
}

#[test]
fn a_jump_outside_the_gate_begins_the_motion_of_a_known_vehicle_anew() {
    let mut keys = EXACT.to_vec();
    keys.push("actors.0={ name = \"lead\", gap_m = 60, profile.speeds = [[2, 20], [2.01, 2]] }");
    let mut watch = Watch::new(&scenario("following", &keys));
    let tracks: Vec<_> =
        (0..60).map(|k| watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 20.0)).tracks[0]).collect();
    assert!(tracks.iter().all(|track| track.id == 1));
    // The jump is over at 2.01 s: the scans of 2.05, 2.10 and 2.15 s do not fit.
    let speeds_mps = [42, 43, 59].map(|scan: usize| tracks[scan].relative_speed_mps);
    for (found, expected) in speeds_mps.into_iter().zip([0.0, -18.0, -18.0]) {
        assert!((found - expected).abs() < 0.01, "{speeds_mps:?}");
    }
}

#[test]
fn no_actors_no_tracks() {
    let text = "schema_version = 1\nname = \"empty\"\n";
    for model in ["ideal", "object-list", "detections"] {
        let text = format!("{text}[perception.radar]\nmodel = \"{model}\"\n");
        let scenario = Scenario::parse("x", &text).expect("it is right");
        let mut watch = Watch::new(&scenario);
        for k in 0..400 {
            let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 25.0));
            assert_eq!((list.count, list.target), (0, None), "{model} at {k}");
        }
    }
}

/// A queue of standing cars is an obstacle, and so is a single one that was never seen moving.
#[test]
fn a_standing_car_in_the_lane_is_tracked_and_the_roadside_is_not() {
    let text = "schema_version = 1\nname = \"x\"\n\
        [[actors]]\nname = \"a\"\ngap_m = 200\ninitial_speed_mps = 0\n\
        [[actors]]\nname = \"b\"\ngap_m = 220\ninitial_speed_mps = 0\nlateral_offset_m = 3.5\n";
    for seed in 1..=20 {
        let text = text.replacen("name = \"x\"", &format!("name = \"x\"\nseed = {seed}"), 1);
        let mut watch = Watch::new(&Scenario::parse("x", &text).expect("it is right"));
        let mut first_m = None;
        for k in 0..150 {
            let time_ns = k * PERIOD_NS;
            let list = watch.step(time_ns, &ego(time_ns, 20.0));
            if let Some(target) = list.target() {
                first_m.get_or_insert(target.gap_m);
                let truth_m = 200.0 - 20.0 * time_ns as f64 * 1e-9;
                assert!((target.gap_m - truth_m).abs() < 3.0, "{seed}: {target:?}");
                assert!(target.lateral_m.abs() < 1.5, "{seed}: {target:?}");
            }
        }
        assert!(first_m.is_some_and(|gap_m| gap_m > 100.0), "{seed}: seen at {first_m:?} m");
    }
}

/// Every imperfection can be switched off by its keys, and then the tracks are nearly exact.
#[test]
fn without_imperfections_little_is_left_of_the_error() {
    let keys = [
        "perception.radar.detections.snr_at_100_m_db=60",
        "perception.radar.detections.edge_loss_db=0",
        "perception.radar.detections.swerling=0",
        "perception.radar.detections.merge=false",
        "perception.radar.detections.range_floor_m=0",
        "perception.radar.detections.range_rate_floor_mps=0",
        "perception.radar.detections.azimuth_floor_deg=0",
        "perception.radar.detections.hidden_loss_db=0",
        "perception.radar.detections.false_alarms_per_scan=0",
        "perception.radar.detections.standing_objects_per_km=0",
        "perception.radar.detections.under_body_probability=0",
        "perception.radar.detections.guard_rail_share=0",
        "perception.radar.dropout_probability=0",
    ];
    let mut clean = Watch::new(&scenario("following", &keys));
    let mut usual = Watch::new(&scenario("following", &[]));
    for k in 0..600 {
        let ego = ego(k * PERIOD_NS, 22.0);
        clean.step(k * PERIOD_NS, &ego);
        usual.step(k * PERIOD_NS, &ego);
    }
    let (clean, usual) = (clean.perception.report(), usual.perception.report());
    assert!(clean.gospa_m < 0.3, "{clean:?}");
    assert!(clean.gospa_m < 0.7 * usual.gospa_m, "{clean:?} {usual:?}");
    assert!(clean.detections < usual.detections);
}

#[test]
fn more_detections_than_the_message_carries_are_counted() {
    let keys = [
        "perception.radar.max_range_m=400",
        "perception.radar.detections.standing_objects_per_km=2000",
        "perception.radar.detections.standing_object_rcs_dbsm=40",
        "perception.radar.detections.merge=false",
    ];
    let mut watch = Watch::new(&scenario("following", &keys));
    watch.step(0, &ego(0, 22.0));
    let report = watch.perception.report();
    assert_eq!(report.detections, Some(MAX_DETECTIONS as u64));
    assert!(report.detections_left_out.is_some_and(|count| count > 300), "{report:?}");
}

/// A lead 40 m ahead. It brakes with 3 m/s² from 2 s on, and is gone from 3 s on.
const VANISHES: &str = r#"
    schema_version = 1
    name = "x"
    [plant]
    initial_speed_mps = 15
    [[actors]]
    name = "lead"
    gap_m = 40
    leaves_at_s = 3.0
    initial_speed_mps = 15
    profile.steps = [{ time_s = 2.0, speed_mps = 0, acceleration_mps2 = 3.0 }]
"#;

#[test]
fn a_lead_that_is_lost_while_it_brakes_is_taken_to_brake_on_for_a_while() {
    let scenario = Scenario::parse("x.toml", VANISHES).expect("it is right");
    let mut watch = Watch::new(&scenario);
    for k in 0..140 {
        let (time_ns, time_s) = (k * PERIOD_NS, k as f64 * 0.05);
        let list = watch.step(time_ns, &ego(time_ns, 15.0));
        if (3.3..5.3).contains(&time_s) {
            let target = list.target().unwrap_or_else(|| panic!("it is lost at {time_s} s"));
            let braked_s = time_s - 2.0;
            let gap_m = (40.0 - 1.5 * braked_s * braked_s).max(0.0);
            assert!((target.gap_m - gap_m).abs() < 2.0, "{time_s} s: {target:?}, not {gap_m} m");
            assert!((target.relative_speed_mps + 3.0 * braked_s).abs() < 2.0, "{target:?}");
            assert!(target.acceleration_mps2 < -2.0, "{target:?}");
        }
        assert!(time_s < 5.7 || list.target().is_none(), "its time is over at {time_s} s");
    }
}

#[test]
fn a_radar_that_sees_little_reports_it_and_still_finds_its_lead() {
    let keys = ["perception.radar.dropout_probability=0.85"];
    let mut watch = Watch::new(&scenario("following", &keys));
    let mut followed = 0;
    for k in 0..400 {
        let list = watch.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
        followed += u32::from(list.target().is_some());
    }
    assert!(watch.perception.seen_share() < 0.33, "{}", watch.perception.seen_share());
    // A radar with all of its scans confirms by three of four. With 15 of 100 this would be one scan in a hundred.
    assert!(followed > 100, "it is the target in {followed} of 400 scans");
}

proptest! {
    #[test]
    fn equal_inputs_give_equal_bits_and_an_ordered_list(
        seed in 0u64..1000, periods in prop::collection::vec(1u64..5, 1..100),
        speed_mps in 0.0..40.0f64, object_list: bool,
    ) {
        let seed = format!("seed={seed}");
        let keys = if object_list { vec![&*seed, OBJECT_LIST] } else { vec![&*seed] };
        let scenario = scenario("cut-in", &keys);
        let (mut one, mut two) = (Watch::new(&scenario), Watch::new(&scenario));
        let mut now_ns = 0;
        for skip in periods {
            let ego = ego(now_ns, speed_mps);
            let list = one.step(now_ns, &ego);
            prop_assert_eq!(&list, &two.step(now_ns, &ego));
            let tracks = list.tracks();
            prop_assert!(tracks.windows(2).all(|pair| pair[0].gap_m <= pair[1].gap_m));
            let finite = |track: &Track| track.gap_m.is_finite()
                && track.relative_speed_mps.is_finite() && track.acceleration_mps2.is_finite();
            prop_assert!(tracks.iter().all(finite));
            prop_assert_eq!(list.target, tracks.iter().position(|track| track.in_path));
            now_ns += skip * PERIOD_NS;
        }
    }
}
