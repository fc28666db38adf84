//! True tracks, to judge laws without a sensor's errors. Range and field
//! of view still bound what is seen.

use scenario::Scenario;

use super::list::{Track, TrackList};
use super::numbers::Numbers;
use super::path::{Across, Membership, PathLimits};
use crate::radar::object_list::View;
use crate::radar::scene::Scene;

#[derive(Clone, Debug)]
pub struct ExactTracker {
    view: View,
    limits: PathLimits,
    tracks: Vec<Option<(u32, Membership)>>,
    last_ns: Option<i64>,
    next_id: u32,
}

impl ExactTracker {
    pub fn new(scenario: &Scenario) -> Self {
        let perception = &scenario.perception;
        Self {
            view: View::new(&perception.radar),
            limits: PathLimits::new(&perception.target_selection, true, &Numbers::DEFAULT),
            tracks: vec![None; scenario.actors.len()],
            last_ns: None,
            next_id: 1,
        }
    }

    /// The vehicles in view.
    pub fn step(&mut self, scene: &Scene) -> TrackList {
        let dt_s = self.last_ns.map_or(0.0, |last| (scene.time_ns - last) as f64 * 1e-9);
        self.last_ns = Some(scene.time_ns);
        let mut list = TrackList::new(scene.time_ns);
        for (index, (place, vehicle)) in self.tracks.iter_mut().zip(&scene.vehicles).enumerate() {
            let Some(measurement) = self.view.measure(scene, index) else {
                *place = None;
                continue;
            };
            let (id, mut membership) = place.unwrap_or_else(|| {
                let id = self.next_id;
                self.next_id = self.next_id.wrapping_add(1).max(1);
                (id, Membership::default())
            });
            self.limits.observe(&mut membership, &Across::resting(vehicle.lateral_m), dt_s);
            *place = Some((id, membership));
            list.add(Track {
                id,
                range_m: measurement.range_m,
                range_rate_mps: measurement.range_rate_mps,
                azimuth_rad: measurement.azimuth_rad,
                measured: true,
                gap_m: (vehicle.rear_position_m - scene.ego.position_m).max(0.0),
                relative_speed_mps: vehicle.speed_mps - scene.ego.speed_mps,
                acceleration_mps2: vehicle.acceleration_mps2,
                lateral_m: vehicle.lateral_m,
                lateral_speed_mps: vehicle.lateral_speed_mps,
                length_m: vehicle.length_m,
                width_m: scenario::event::VEHICLE_WIDTH_M,
                in_path: membership.in_path(),
                doubt_share: 0.0,
            });
        }
        list.finish();
        list
    }
}
