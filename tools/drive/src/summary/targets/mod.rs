//! Owner of the selected target, by the ground truth of a drive on a road with a plan.
//!
//! Perception's verdict on itself does not count here. The selected track is a place in the plane, and the nearest body
//! within [`BODY_M`] owns it. That place is the track's last echo, and one echo may come from two bodies. So the owner is
//! the body with most of the track's echoes within [`ECHOES_S`] before and after. The lead is the nearest vehicle ahead
//! whose body reaches into the ego's lane.
//!
//! | verdict | when |
//! | --- | --- |
//! | lead lost | the lead is within [`REACH_M`], and the target is not the lead |
//! | neighbour taken | the target is a vehicle whose body does not reach into the ego's lane |
//! | nothing taken | the target is not a vehicle |
//!
//! A place on the road is an entry, an arc, an exit or straight. The curvatures of the axis at the ego and at the vehicle
//! that matters decide it. That vehicle is the lead, or without one the target's owner, or without that a point
//! [`AHEAD_M`] ahead.

mod sums;

pub use sums::{PlaceSums, Sums, by_place};

use crate::{Drive, PlaneScene};
use serde::{Deserialize, Serialize};

/// Gap up to which a lead counts, m.
pub const REACH_M: f64 = 100.0;
/// A target farther than this from every body belongs to no vehicle, m. It is more than the error of an azimuth at 100
/// m, and less than the distance to the next lane's middle.
pub const BODY_M: f64 = 3.0;
/// Time before and after a scan in which the target's echoes decide whose it is, s.
pub const ECHOES_S: f64 = 0.25;
/// Distance at which the road ahead is looked at without a vehicle, m.
const AHEAD_M: f64 = 50.0;
/// Curvature below which a road is straight, and difference below which two curvatures are the same, 1/m.
const STRAIGHT_PERM: f64 = 1e-4;
/// Distance of a rear behind the ego's front beyond which its vehicle is not ahead, m. It is a car's length, as in
/// [`messages::AllVehicles::nearest_ahead`].
const BEHIND_M: f64 = -5.0;

/// Part of a curve between the ego and the vehicle that matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// No curvature at either.
    Straight,
    /// The curvature grows ahead, or changes its side.
    Entry,
    /// The same curvature at both.
    Arc,
    /// The curvature falls ahead.
    Exit,
}

impl Place {
    pub const ALL: [Self; 4] = [Self::Straight, Self::Entry, Self::Arc, Self::Exit];

    /// The place between two curvatures, 1/m.
    ///
    /// ```
    /// use drive::summary::targets::Place;
    ///
    /// assert_eq!(Place::between(0.0, 0.002), Place::Entry);
    /// assert_eq!(Place::between(0.002, -0.002), Place::Entry, "the next curve of an S");
    /// assert_eq!(Place::between(0.002, 0.0), Place::Exit);
    /// ```
    pub fn between(ego_perm: f64, ahead_perm: f64) -> Self {
        let (ego, ahead) = (ego_perm.abs(), ahead_perm.abs());
        let changes_side = ego_perm * ahead_perm < 0.0 && ahead >= STRAIGHT_PERM;
        if ego < STRAIGHT_PERM && ahead < STRAIGHT_PERM {
            Self::Straight
        } else if changes_side || ahead > ego + STRAIGHT_PERM {
            Self::Entry
        } else if ahead < ego - STRAIGHT_PERM {
            Self::Exit
        } else {
            Self::Arc
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// A vehicle, by its place in `truth/vehicles`.
    Vehicle(usize),
    Nothing,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lead {
    /// Its place in `truth/vehicles`.
    pub vehicle: usize,
    /// Gap along the axis, m.
    pub gap_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedScan {
    /// Run time of the scan, s.
    pub time_s: f64,
    /// Ego's front bumper on the axis, m.
    pub position_m: f64,
    /// Part of a curve.
    pub place: Place,
    /// The lead, at any gap.
    pub lead: Option<Lead>,
    /// Owner of the target; none without a target.
    pub owner: Option<Owner>,
    /// The owner's body does not reach into the ego's lane.
    pub is_beside: bool,
}

impl JudgedScan {
    pub fn lead_within(&self, reach_m: f64) -> Option<Lead> {
        self.lead.filter(|lead| lead.gap_m <= reach_m)
    }

    /// The lead is within reach, and the target is not the lead.
    pub fn is_lead_lost(&self) -> bool {
        let owner = self.owner;
        self.lead_within(REACH_M).is_some_and(|lead| owner != Some(Owner::Vehicle(lead.vehicle)))
    }

    /// The target is a vehicle beside the ego's lane.
    pub fn is_neighbour_taken(&self) -> bool {
        self.is_beside
    }

    /// The target is not a vehicle.
    pub fn is_nothing_taken(&self) -> bool {
        self.owner == Some(Owner::Nothing)
    }
}

/// Judges all scans of a drive whose result is known. `curvature` is that of the axis at a position, 1/m.
pub fn judge(drive: &Drive, curvature: &dyn Fn(f64) -> f64) -> Vec<JudgedScan> {
    let mut steps = drive.steps.iter().peekable();
    let scenes: Vec<_> = drive.plane.iter().filter(|scene| scene.seen.is_some()).collect();
    let owners = owners(&scenes);
    let judged = scenes.into_iter().zip(owners).map(|(scene, owner)| {
        // The step at the scan's time: both come from the same clock.
        let mut position_m = 0.0;
        while let Some(step) = steps.next_if(|step| step.time_s <= scene.time_s + 1e-9) {
            position_m = step.position_m;
        }
        judge_scene(scene, owner, position_m, curvature)
    });
    judged.collect()
}

/// Owners of the targets of these scans.
fn owners(scenes: &[&PlaneScene]) -> Vec<Option<Owner>> {
    let echoes: Vec<_> = scenes.iter().map(|scene| echo(scene)).collect();
    let owner = |(index, echo): (usize, &Option<(u32, Owner)>)| {
        let ((track, own), time_s) = ((*echo)?, scenes[index].time_s);
        let is_near = |scene: &&&PlaneScene| (scene.time_s - time_s).abs() <= ECHOES_S + 1e-9;
        let from = scenes[..index].iter().rev().take_while(is_near).count();
        let to = scenes[index..].iter().take_while(is_near).count();
        let around = echoes[index - from..index + to].iter().flatten();
        let votes = |owner: Owner| around.clone().filter(|echo| **echo == (track, owner)).count();
        let others = around.clone().filter(|echo| echo.0 == track).map(|echo| echo.1);
        // With equal numbers the scan's own echo decides.
        Some(others.fold(own, |most, other| if votes(other) > votes(most) { other } else { most }))
    };
    echoes.iter().enumerate().map(owner).collect()
}

/// Track of a scan's target, and the body that its echo is on.
fn echo(scene: &PlaneScene) -> Option<(u32, Owner)> {
    let target = scene.seen?.target?;
    let distances = scene.bodies.iter().map(|body| body.distance_m(target.x_m, target.y_m));
    let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let nearest = nearest.filter(|(_, distance_m)| *distance_m <= BODY_M);
    Some((target.track_id, nearest.map_or(Owner::Nothing, |(vehicle, _)| Owner::Vehicle(vehicle))))
}

fn judge_scene(
    scene: &PlaneScene,
    owner: Option<Owner>,
    position_m: f64,
    curvature: &dyn Fn(f64) -> f64,
) -> JudgedScan {
    let gaps = scene.bodies.iter().map(|body| body.rear_position_m - position_m);
    let ahead =
        gaps.enumerate().filter(|(index, gap_m)| scene.bodies[*index].in_lane && *gap_m > BEHIND_M);
    let lead =
        ahead.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(vehicle, gap_m)| Lead { vehicle, gap_m });
    let owned = match owner {
        // The list is shorter where a vehicle of SUMO went out of reach.
        Some(Owner::Vehicle(vehicle)) => scene.bodies.get(vehicle),
        Some(Owner::Nothing) | None => None,
    };
    let matters = lead.filter(|lead| lead.gap_m <= REACH_M).map(|lead| lead.gap_m);
    let matters = matters.or(owned.map(|body| body.rear_position_m - position_m));
    let ahead_m = matters.unwrap_or(AHEAD_M).max(0.0);
    JudgedScan {
        time_s: scene.time_s,
        position_m,
        place: Place::between(curvature(position_m), curvature(position_m + ahead_m)),
        lead,
        owner,
        is_beside: owned.is_some_and(|body| !body.in_lane),
    }
}

/// Spans of consecutive scans with a finding: times of the first scan and of the one behind the last, s.
pub fn spans(scans: &[JudgedScan], finding: impl Fn(&JudgedScan) -> bool) -> Vec<(f64, f64)> {
    let mut spans = Vec::new();
    let mut from_s = None;
    for scan in scans {
        match (finding(scan), from_s) {
            (true, None) => from_s = Some(scan.time_s),
            (false, Some(begin_s)) => {
                spans.push((begin_s, scan.time_s));
                from_s = None;
            }
            _ => {}
        }
    }
    let end_s = scans.last().map_or(0.0, |scan| scan.time_s);
    spans.extend(from_s.map(|begin_s| (begin_s, end_s)));
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, DriveStep, EgoPlace, Seen, TargetPlace};

    const STEP_S: f64 = 0.05;

    fn body(rear_position_m: f64, y_m: f64) -> Body {
        Body {
            x_m: rear_position_m + 2.25,
            y_m,
            length_m: 4.5,
            width_m: 1.8,
            rear_position_m,
            in_lane: y_m.abs() < 1.8,
            ..Body::default()
        }
    }

    /// A lead 40 m ahead, a neighbour 42 m ahead, and a target at each of these places.
    fn drive(targets: &[Option<(f64, f64)>]) -> Drive {
        let plane = targets.iter().enumerate().map(|(index, target)| {
            let seen = Seen {
                published_s: 0.0,
                target: target.map(|(x_m, y_m)| TargetPlace {
                    x_m,
                    y_m,
                    // A track of its own at each place.
                    track_id: (10.0 * x_m + 1e3 * y_m) as u32,
                    ..TargetPlace::default()
                }),
            };
            PlaneScene {
                time_s: STEP_S * index as f64,
                ego: EgoPlace::default(),
                bodies: vec![body(42.0, 3.5), body(40.0, 0.1), body(90.0, 0.0)],
                seen: Some(seen),
            }
        });
        let steps = (0..targets.len())
            .map(|index| DriveStep { time_s: STEP_S * index as f64, ..DriveStep::default() });
        Drive { steps: steps.collect(), plane: plane.collect(), ..Drive::default() }
    }

    #[test]
    fn the_nearest_body_owns_the_target() {
        let targets = [Some((40.2, 0.9)), Some((43.0, 3.0)), Some((60.0, 0.0)), None];
        let scans = judge(&drive(&targets), &|_| 0.0);
        let found = |scan: &JudgedScan| {
            (scan.is_lead_lost(), scan.is_neighbour_taken(), scan.is_nothing_taken())
        };
        let all: Vec<_> = scans.iter().map(found).collect();
        assert_eq!(
            all,
            [(false, false, false), (true, true, false), (true, false, true), (true, false, false)]
        );
        assert_eq!(scans[0].lead, Some(Lead { vehicle: 1, gap_m: 40.0 }));
    }

    #[test]
    fn one_echo_of_two_bodies_does_not_change_the_owner_and_a_switch_does() {
        let track = |places: &[(f64, f64)]| {
            let targets: Vec<_> = places.iter().map(|&place| Some(place)).collect();
            let mut drive = drive(&targets);
            for target in drive.plane.iter_mut().filter_map(|scene| scene.seen.as_mut()) {
                target.target.as_mut().expect("each scan has one").track_id = 7;
            }
            judge(&drive, &|_| 0.0).iter().map(|scan| scan.owner).collect::<Vec<_>>()
        };
        let (lead, beside) = ((40.2, 0.2), (42.2, 3.4));
        let mut places = [lead; 12];
        places[5] = beside;
        assert_eq!(track(&places), [Some(Owner::Vehicle(1)); 12]);
        places[6..].fill(beside);
        let owners = track(&places);
        let switched = owners.iter().filter(|owner| **owner == Some(Owner::Vehicle(0))).count();
        assert!((6..=7).contains(&switched), "{owners:?}");
    }

    #[test]
    fn a_farther_vehicle_of_the_lane_is_not_the_lead() {
        let scans = judge(&drive(&[Some((90.5, 0.0))]), &|_| 0.0);
        assert!(scans[0].is_lead_lost() && !scans[0].is_neighbour_taken());
    }

    #[test]
    fn a_lead_out_of_reach_is_not_lost() {
        let mut far = drive(&[None]);
        far.plane[0].bodies = vec![body(101.0, 0.0)];
        assert!(!judge(&far, &|_| 0.0)[0].is_lead_lost());
    }

    #[test]
    fn the_place_is_that_between_ego_and_lead() {
        let place = |curvature: &dyn Fn(f64) -> f64| judge(&drive(&[None]), curvature)[0].place;
        assert_eq!(place(&|p_m| if p_m < 30.0 { 0.0 } else { 0.002 }), Place::Entry);
        assert_eq!(place(&|p_m| if p_m < 50.0 { 0.0 } else { 0.002 }), Place::Straight);
        assert_eq!(place(&|_| -0.002), Place::Arc);
        assert_eq!(place(&|p_m| if p_m < 30.0 { -0.002 } else { 0.0 }), Place::Exit);
    }

    #[test]
    fn spans_end_with_the_next_scan_or_the_drive() {
        let targets = [Some((40.0, 0.0)), None, None, Some((40.0, 0.0)), None, None];
        let scans = judge(&drive(&targets), &|_| 0.0);
        let near = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() + (b - d).abs() < 1e-9;
        let found = spans(&scans, JudgedScan::is_lead_lost);
        assert_eq!(found.len(), 2);
        assert!(near(found[0], (0.05, 0.15)) && near(found[1], (0.2, 0.25)), "{found:?}");
    }
}
