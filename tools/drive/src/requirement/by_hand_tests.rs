//! The rules on the ground truth, by motions whose results are known.

use super::{Evidence, RequirementVerdict, requirements};
use crate::{Drive, DriveStep};
use bytemuck::Zeroable;
use messages::{AllVehicles, VehicleTruthItem};
use scenario::Scenario;

/// An ego that keeps 20 m/s until it touches a vehicle `gap_m` ahead. That one brakes, in lane from `appears_s` on.
fn drive(gap_m: f64, lead_mps2: f64, appears_s: f64) -> Drive {
    let mut drive = Drive::default();
    for k in 0..2000_u32 {
        let time_s = f64::from(k) * 0.01;
        let braked_s = if lead_mps2 < 0.0 { time_s.min(20.0 / -lead_mps2) } else { time_s };
        let rear_m = gap_m + (20.0 + 0.5 * lead_mps2 * braked_s) * braked_s;
        let is_there = time_s >= appears_s;
        let mut truth = AllVehicles::with_room(1);
        truth.header.step = k.into();
        truth.header.acquisition_ns = i64::from(k) * 10_000_000;
        truth.vehicles.push(VehicleTruthItem::zeroed());
        let lead = &mut truth.vehicles[0];
        lead.in_lane = is_there.into();
        (lead.rear_position_m, lead.speed_mps) = (rear_m, 20.0 + lead_mps2 * braked_s);
        lead.acceleration_mps2 = if braked_s < time_s { 0.0 } else { lead_mps2 };
        drive.vehicles.push(truth);
        drive.steps.push(DriveStep {
            step: k.into(),
            time_s,
            position_m: 20.0 * time_s,
            speed_mps: 20.0,
            time_to_collision_s: f64::INFINITY,
            stop_line_m: f64::INFINITY,
            ..DriveStep::default()
        });
        if is_there && rear_m <= 20.0 * time_s {
            break;
        }
    }
    drive
}

const LEAD: &str =
    "[[actors]]\nname = \"lead\"\ngap_m = 30\ninitial_speed_mps = 20\nlength_m = 4.5\n";

fn judged(
    name: &str,
    more: &str,
    drive: &Drive,
    impact_speed_mps: Option<f64>,
) -> RequirementVerdict {
    let text = format!(
        "schema_version = 1\nname = \"a\"\nduration_s = 20\n{more}\n[require]\nformulas = [\"{name}\"]"
    );
    let scenario = Scenario::parse("a.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    let evidence = Evidence { scenario: &scenario, drive, impact_speed_mps };
    requirements(&scenario).expect("a name")[0].judge(&evidence)
}

/// Impact speed of a drive that ended in a contact.
fn impact_mps(drive: &Drive) -> f64 {
    let lead = drive.vehicles.last().expect("a lead").vehicles[0];
    assert!(lead.rear_position_m <= drive.steps.last().expect("a step").position_m);
    20.0 - lead.speed_mps
}

fn avoidable(drive: &Drive) -> RequirementVerdict {
    judged("no-avoidable-collision", LEAD, drive, Some(impact_mps(drive)))
}

#[test]
fn a_collision_counts_its_impact_speed_and_a_drive_without_one_its_least_gap() {
    let hit = drive(30.0, -4.0, 0.0);
    let verdict = judged("no-collision", LEAD, &hit, Some(impact_mps(&hit)));
    // 2 d / a after 3.87 s: 15.49 m/s.
    let margin = verdict.margin.expect("a contact");
    assert!((margin + (2.0 * 30.0 * 4.0_f64).sqrt()).abs() < 0.05, "{verdict:?}");
    assert!(!verdict.met && verdict.unit == "m/s");
    assert!((verdict.at_s - hit.steps.last().expect("a step").time_s).abs() < 1e-9);
    let mut apart = drive(30.0, -4.0, 0.0);
    apart.steps.truncate(201);
    let verdict = judged("no-collision", LEAD, &apart, None);
    assert!(verdict.met && verdict.unit == "m" && verdict.at_s == 2.0, "{verdict:?}");
    assert!((verdict.margin.expect("a gap") - 22.0).abs() < 1e-9, "30 - 4 · 2² / 2");
    let alone = judged("no-collision", LEAD, &drive(30.0, 0.0, 100.0), None);
    assert_eq!((alone.margin, alone.met), (None, true));
}

#[test]
fn braking_in_time_would_have_helped() {
    let verdict = avoidable(&drive(30.0, -4.0, 0.0));
    assert!(!verdict.met && verdict.margin.expect("decided") < 0.0, "{verdict:?}");
}

/// Both stop from 20 m/s, the lead with 8 m/s² and the reference with 6. It needs 8.33 m, and 7 m more for its reaction
/// of 0.35 s.
#[test]
fn the_reaction_time_costs_its_distance() {
    let (near, far) = (avoidable(&drive(14.5, -8.0, 0.0)), avoidable(&drive(16.0, -8.0, 0.0)));
    assert!(near.met && !far.met, "{near:?} {far:?}");
    // The reference misses it by 16 − 15.33 m: the ego was as near to "unavoidable".
    let margin = far.margin.expect("decided");
    assert!((margin + (16.0 - 7.0 - 400.0 * (1.0 / 12.0 - 1.0 / 16.0))).abs() < 0.05, "{far:?}");
    assert_eq!((far.unit.as_str(), far.at_s), ("m", 0.0));
    assert_eq!(near.unit, "m/s", "the reference has an impact");
}

#[test]
fn a_vehicle_that_cuts_in_too_late_cannot_be_avoided() {
    // It appears when it stands 8.5 m ahead already.
    assert!(avoidable(&drive(30.0, -8.0, 2.3)).met);
}

/// The record ends with the contact; the lead keeps braking as hard until it stands.
#[test]
fn the_reference_is_followed_past_the_records_end() {
    // Contact after 0.5 s: the lead still drives 16 m/s.
    let close = drive(1.0, -8.0, 0.0);
    assert!(avoidable(&close).met, "15.33 m are needed");
    let weak = "[aebs]\ndeceleration_mps2 = 5\n";
    let hit = drive(24.0, -8.0, 0.0);
    let with = |more: &str| {
        let more = format!("{more}{LEAD}");
        judged("no-avoidable-collision", &more, &hit, Some(impact_mps(&hit))).met
    };
    // 400 / 2 · (1/5 − 1/8) + 7 = 22 m. From 23 m on the weak brakes suffice; at 20 m they do not.
    assert!(!with(weak) && !with(""));
    let hit = drive(20.0, -8.0, 0.0);
    let weak =
        judged("no-avoidable-collision", &format!("{weak}{LEAD}"), &hit, Some(impact_mps(&hit)));
    assert!(weak.met && !avoidable(&hit).met);
}

/// A need long ago, from which the ego fell back, is neither an excuse nor an advantage for the reference.
#[test]
fn an_encounter_ends_when_the_ego_no_longer_approaches() {
    // 3 s at constant distance lie before the same scene.
    let mut later = drive(16.0, -8.0, 0.0);
    let shift = |ns: i64| ns + 3_000_000_000;
    later.steps.iter_mut().for_each(|step| {
        step.time_s += 3.0;
        step.position_m += 60.0;
    });
    later.vehicles.iter_mut().for_each(|truth| {
        truth.header.acquisition_ns = shift(truth.header.acquisition_ns);
        truth.vehicles[0].rear_position_m += 60.0;
    });
    let steady = drive(16.0, 0.0, 0.0);
    later.steps.splice(0..0, steady.steps[..300].iter().copied());
    later.vehicles.splice(0..0, steady.vehicles[..300].iter().cloned());
    let verdict = avoidable(&later);
    assert!(!verdict.met && (verdict.at_s - 3.0).abs() < 0.011, "{verdict:?}");
}

/// 15 m/s past a line at 100 m; the light is red from 5 s to 9 s.
#[test]
fn a_red_light_has_a_margin_in_metres() {
    let signals = |line_m: f64| {
        format!(
            "[[v2x.signals]]\nintersection_id = 1\nstop_line_m = {line_m}\nrepeat = false\nprogram = [\
             {{ phase = \"green\", duration_s = 5 }}, {{ phase = \"red\", duration_s = 4 }}, \
             {{ phase = \"green\", duration_s = 30 }}]\n"
        )
    };
    let mut drive = Drive::default();
    for k in 0..1200_u32 {
        let time_s = f64::from(k) * 0.01;
        let position_m = 15.0 * time_s;
        drive.steps.push(DriveStep { time_s, position_m, speed_mps: 15.0, ..DriveStep::default() });
    }
    let at = |line_m: f64| judged("no-red-light", &signals(line_m), &drive, None);
    let near = |verdict: &RequirementVerdict, margin: f64, at_s: f64| {
        let found = verdict.margin.expect("a light");
        assert!(
            (found - margin).abs() < 1e-6 && (verdict.at_s - at_s).abs() < 0.011,
            "{verdict:?}"
        );
    };
    let passed = at(60.0);
    assert!(passed.met && passed.unit == "m");
    near(&passed, 15.0, 5.0);
    let crossed = at(100.0);
    assert!(!crossed.met);
    near(&crossed, -25.0, 100.0 / 15.0);
    let late = at(150.0);
    assert!(late.met, "it is green again");
    near(&late, 15.0, 9.0);
    assert_eq!(judged("no-red-light", "", &drive, None).margin, None);
}
