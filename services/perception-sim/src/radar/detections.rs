//! The radar that hands out detections.
//!
//! A scan is a function of the seed and the scene alone. Its random numbers belong to the seed and the scan's time, so
//! that any scan can be repeated alone.
//!
//! | part | keys of `[perception.radar.detections]` |
//! |---|---|
//! | [`Antenna`] | `snr_at_100_m_db`, `edge_loss_db` |
//! | [`Bodies`] | `car_rcs_dbsm`, `lorry_rcs_dbsm`, `swerling`, `hidden_loss_db`, `under_body_*`, `guard_rail_*` |
//! | [`Roadside`] | `standing_objects_*` |
//! | [`Receiver`] | `range_*`, `range_rate_*`, `azimuth_*`, `merge`, `threshold_db`, `false_alarms_per_scan` |

use messages::{Detection, MAX_DETECTIONS};
use road::Axis;
use scenario::Scenario;
use scenario::perception::{Detections, Radar, Swerling};
use scenario::plan::Lanes;

use super::bodies::{Bodies, UnderBody};
use super::body::Outlines;
use super::echo::{Antenna, Fluctuation, ratio};
use super::numbers::Numbers;
use super::rail::Rail;
use super::receiver::{Accuracy, Echoes, Received, Receiver};
use super::roadside::Roadside;
use super::scene::Scene;

/// Echoes of one scan for which there is room before they merge.
const ECHOES: usize = 4 * MAX_DETECTIONS;

#[derive(Clone, Debug)]
pub struct DetectionRadar {
    seed: u64,
    antenna: Antenna,
    bodies: Bodies,
    roadside: Roadside,
    /// The lanes of a road with a plan.
    lanes: Lanes,
    receiver: Receiver,
    outlines: Outlines,
    echoes: Echoes,
}

impl DetectionRadar {
    pub fn new(scenario: &Scenario) -> Self {
        Self::with(scenario, &Numbers::DEFAULT)
    }

    /// The radar of a scenario with other numbers, for studies of their effect.
    pub fn with(scenario: &Scenario, numbers: &Numbers) -> Self {
        let radar = &scenario.perception.radar;
        let keys = &radar.detections;
        let fluctuation = match keys.swerling {
            Swerling::Case0 => Fluctuation::None,
            Swerling::Case1 => Fluctuation::ManyParts,
            Swerling::Case3 => Fluctuation::StrongPart,
        };
        Self {
            seed: scenario.seed.value(),
            antenna: Antenna::new(
                keys.snr_at_100_m_db.value(),
                keys.edge_loss_db.value(),
                radar.field_of_view_deg.value(),
                radar.max_range_m.value(),
            ),
            bodies: bodies(radar, fluctuation, numbers),
            roadside: Roadside {
                objects_per_km: keys.standing_objects_per_km.value(),
                offset_m: keys.roadside_offset_m.value(),
                area_m2: ratio(keys.standing_object_rcs_dbsm.value()),
                fluctuation,
                dropout_probability: radar.dropout_probability.value(),
                hidden_factor: ratio(-keys.hidden_loss_db.value()),
                depth_m: numbers.roadside_depth_m,
            },
            lanes: scenario.road.plan().map(|plan| plan.lanes.clone()).unwrap_or_default(),
            receiver: receiver(keys, numbers),
            outlines: Outlines::with_room(scenario.actors.len()),
            echoes: Echoes::new(ECHOES, numbers),
        }
    }

    /// Writes the detections of a scene on its road (if that has a plan), nearest first, up to the room. The rest of
    /// `detections` stays.
    pub fn scan(
        &mut self,
        road: Option<&Axis>,
        scene: &Scene,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) -> Received {
        let (echoes, outlines) = (&mut self.echoes, &mut self.outlines);
        echoes.clear();
        outlines.take(scene);
        self.bodies.reflect(self.seed, (scene, outlines), road, &self.antenna, echoes);
        let road = road.map(|road| (road, &self.lanes));
        self.roadside.reflect(self.seed, (scene, outlines), road, &self.antenna, echoes);
        self.receiver.detect(self.seed, scene.time_ns, &self.antenna, echoes, detections)
    }

    /// The receiver, whose accuracy the tracker uses.
    pub fn receiver(&self) -> &Receiver {
        &self.receiver
    }
}

fn bodies(radar: &Radar, fluctuation: Fluctuation, numbers: &Numbers) -> Bodies {
    let keys = &radar.detections;
    Bodies {
        dropout_probability: radar.dropout_probability.value(),
        car_m2: ratio(keys.car_rcs_dbsm.value()),
        lorry_m2: ratio(keys.lorry_rcs_dbsm.value()),
        fluctuation,
        hidden_factor: ratio(-keys.hidden_loss_db.value()),
        under_body: UnderBody {
            probability: keys.under_body_probability.value(),
            factor: ratio(-keys.under_body_loss_db.value()),
            mean_m: keys.under_body_range_m.value(),
        },
        rail: Rail {
            share: keys.guard_rail_share.value(),
            offset_m: keys.roadside_offset_m.value(),
            factor: ratio(-keys.guard_rail_loss_db.value()),
        },
        numbers: *numbers,
    }
}

fn receiver(keys: &Detections, numbers: &Numbers) -> Receiver {
    Receiver {
        range: Accuracy {
            resolution: keys.range_resolution_m.value(),
            floor: keys.range_floor_m.value(),
        },
        range_rate: Accuracy {
            resolution: keys.range_rate_resolution_mps.value(),
            floor: keys.range_rate_floor_mps.value(),
        },
        azimuth: Accuracy {
            resolution: keys.azimuth_resolution_deg.value().to_radians(),
            floor: keys.azimuth_floor_deg.value().to_radians(),
        },
        merges: keys.merge,
        threshold: ratio(keys.threshold_db.value()),
        false_alarms: keys.false_alarms_per_scan.value(),
        numbers: *numbers,
    }
}
