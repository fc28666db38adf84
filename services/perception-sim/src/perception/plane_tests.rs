//! Perception on roads with a plan.

use super::*;
use crate::radar::scene::PlaneEgo;

const PERIOD_NS: u64 = 50_000_000;
const SPEED_MPS: f64 = 22.0;

/// A lead 60 m ahead, a vehicle on each side, one of which cuts in at 12 s.
fn scenario(road: &str) -> Scenario {
    let text = format!(
        "schema_version = 1\nname = \"plane\"\nseed = 4\nduration_s = 30\n\
         [plant]\ninitial_speed_mps = {SPEED_MPS}\n{road}\n\
         [[actors]]\nname = \"lead\"\ngap_m = 60\ninitial_speed_mps = {SPEED_MPS}\n\
         [[actors]]\nname = \"left\"\ngap_m = 50\ninitial_speed_mps = {SPEED_MPS}\n\
         lateral_offset_m = 3.5\n\
         [[actors]]\nname = \"right\"\ngap_m = 35\ninitial_speed_mps = {SPEED_MPS}\n\
         length_m = 16.5\nlateral_offset_m = -3.5\n\
         lateral = [{{ time_s = 12, to_m = 0, duration_s = 3 }}]\n"
    );
    Scenario::parse("plane", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// Drives on the axis; calls back with the time, s, the perception and its tracks.
fn drive(scenario: &Scenario, scans: u64, mut each: impl FnMut(f64, &Perception, &TrackList)) {
    let mut perception = Perception::new(scenario);
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let axis = scenario.road.plan().map(|plan| plan.axis().clone());
    for scan in 0..scans {
        let time_s = scan as f64 * 0.05;
        let position_m = SPEED_MPS * time_s;
        let ego = Ego { position_m, speed_mps: SPEED_MPS, acceleration_mps2: 0.0 };
        let in_plane = axis.as_ref().map(|axis| {
            let yaw_rate_radps = axis.curvature_perm(position_m) * SPEED_MPS;
            PlaneEgo {
                pose: axis.pose(position_m),
                velocity_mps: (SPEED_MPS, 0.0),
                yaw_rate_radps,
                told_yaw_rate_radps: Some(yaw_rate_radps),
            }
        });
        let list = *perception.step_in_plane(
            scan * PERIOD_NS,
            &ego,
            Some(ego),
            in_plane,
            None,
            &mut detections,
        );
        each(time_s, &perception, &list);
    }
}

#[test]
fn a_plan_of_one_line_changes_no_track() {
    let line = "[road.plan]\npieces = [{ line_m = 3000 }]\n[plant.lateral]\nmodel = \"on-axis\"\n\
                [perception.course]\nsources = []\n";
    let mut straight = Vec::new();
    drive(&scenario(""), 400, |_, _, list| straight.push(*list));
    let mut scan = 0;
    drive(&scenario(line), 400, |time_s, _, list| {
        assert_eq!(*list, straight[scan], "at {time_s} s");
        scan += 1;
    });
}

#[test]
fn in_a_curve_the_lead_is_the_target_and_the_one_that_cuts_in_after_it() {
    for turn in ["left", "right"] {
        let curve = format!(
            "[road.plan]\npieces = [{{ line_m = 80 }}, {{ spiral_m = 60 }}, \
             {{ arc_m = 600, radius_m = 300, turn = \"{turn}\" }}]\n"
        );
        let (mut lost, mut taken, mut scans, mut late) = (0, 0, 0, 0);
        drive(&scenario(&curve), 400, |time_s, perception, list| {
            let lead_m = perception.vehicles()[0].rear_position_m - SPEED_MPS * time_s;
            let target_m = list.target().map(|track| track.gap_m);
            if (1.0..12.0).contains(&time_s) {
                scans += 1;
                let on_lead = target_m.is_some_and(|gap_m| (gap_m - lead_m).abs() < 4.0);
                lost += u32::from(target_m.is_none());
                taken += u32::from(target_m.is_some() && !on_lead);
            } else if time_s > 15.0 {
                late += u32::from(target_m.is_none_or(|gap_m| gap_m > lead_m - 10.0));
            }
        });
        assert!(lost <= scans / 50 && taken <= scans / 50, "{turn}: {lost} {taken} of {scans}");
        assert_eq!(late, 0, "{turn}: the lorry has cut in");
    }
}

#[test]
fn the_course_bends_as_the_road_does() {
    let curve = "[road.plan]\npieces = [{ line_m = 100 }, { spiral_m = 80 }, \
                 { arc_m = 900, radius_m = 400, turn = \"left\" }]\n";
    let radius_m = 400.0;
    let (mut worst_perm, mut worst_m) = (0.0_f64, 0.0_f64);
    drive(&scenario(curve), 400, |time_s, perception, _| {
        // The ego and all of its range are on the arc.
        if time_s > 12.0 && time_s < 19.0 {
            let course = perception.road_ahead().expect("a course").course();
            let off_perm = course.curvature_perm(10.0) - 1.0 / radius_m;
            worst_perm = worst_perm.max(off_perm.abs());
            // Farther ahead few objects show the curvature, but the place decides who is in the lane.
            for sigma_m in [50.0, 80.0] {
                let (sine, cosine) = libm::sincos(sigma_m / radius_m);
                let there = course.locate(radius_m * sine, radius_m * (1.0 - cosine));
                worst_m = worst_m.max(there.d_m.abs());
            }
        }
    });
    assert!(worst_perm < 3e-4, "{worst_perm}");
    assert!(worst_m < 0.875, "a quarter of a lane: {worst_m}");
}
