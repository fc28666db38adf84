//! The facts that a drive is judged by, a rule's finding, and the rule of the lateral acceleration, `lateral:A`.

use crate::Drive;
use scenario::Scenario;
use temporal_logic::Unit;

/// A drive with what judges it: the ground truth, and nothing of radar, law and emergency brake.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// The scenario that was driven.
    pub scenario: &'a Scenario,
    pub drive: &'a Drive,
    /// The referee's speed difference at the contact, m/s; `None` without a collision.
    pub impact_speed_mps: Option<f64>,
}

/// Margin by which a rule holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finding {
    /// Distance to violation, in `unit`.
    pub value: f64,
    pub unit: Unit,
    /// Run time of the instant that decides, s.
    pub time_s: f64,
    pub met: bool,
}

impl Finding {
    /// A rule that nothing of the drive decides.
    pub(super) const UNDECIDED: Self =
        Self { value: f64::INFINITY, unit: Unit::METRE, time_s: 0.0, met: true };
}

/// Margin of the largest lateral acceleration to `limit_mps2`.
pub(super) fn lateral(limit_mps2: f64, evidence: &Evidence<'_>) -> Finding {
    let mut worst = Finding { unit: Unit::METRE_PER_SECOND_SQUARED, ..Finding::UNDECIDED };
    for scene in &evidence.drive.plane {
        let value = limit_mps2 - scene.ego.lateral_acceleration_mps2.abs();
        if value < worst.value {
            worst = Finding { value, time_s: scene.time_s, met: value >= 0.0, ..worst };
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Drive;
    use crate::log::{EgoPlace, PlaneScene};
    use scenario::Scenario;

    #[test]
    fn the_sharpest_scan_decides_and_a_straight_road_decides_nothing() {
        let scenario =
            Scenario::parse("a.toml", "schema_version = 1\nname = \"a\"").expect("it is valid");
        let scene = |time_s, lateral_acceleration_mps2| PlaneScene {
            time_s,
            ego: EgoPlace { lateral_acceleration_mps2, ..EgoPlace::default() },
            ..PlaneScene::default()
        };
        let judged = |plane| {
            let drive = Drive { plane, ..Drive::default() };
            lateral(3.0, &Evidence { scenario: &scenario, drive: &drive, impact_speed_mps: None })
        };
        let found = judged(vec![scene(1.0, 2.0), scene(2.0, -3.5), scene(3.0, 1.0)]);
        assert_eq!((found.value, found.time_s, found.met), (-0.5, 2.0, false));
        assert!(judged(vec![scene(1.0, 3.0)]).met && judged(Vec::new()).met);
    }
}
