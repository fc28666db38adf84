//! The assignment of tracks to vehicles with the least GOSPA.

use messages::MAX_TRACKS;

use crate::radar::scene::Scene;
use crate::tracking::TrackList;

/// Distance c beyond which a track belongs to no vehicle, m.
pub(crate) const CUTOFF_M: f64 = 10.0;
/// A track may be this far from the body of a vehicle that is seen in part, m.
const BODY_MARGIN_M: f64 = 3.0;

/// Vehicle of each track.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Assignment {
    /// Places in the scenario, which has fewer than 256 vehicles.
    pub(crate) vehicle_of: [Option<u8>; MAX_TRACKS],
    /// Pairs, and the sum of their squared distances, m².
    pub(crate) count: u64,
    pub(crate) squares: f64,
    /// Tracks of vehicles that are in view in part at most.
    pub(crate) partly: u64,
}

impl Assignment {
    /// The assignment with the least GOSPA.
    ///
    /// Vehicle after vehicle takes one of the tracks or none. `sets` keeps the best of all ways to one set of taken
    /// tracks. So the effort grows only in proportion to the vehicles.
    pub(crate) fn best(
        scene: &Scene,
        in_view: &[bool],
        list: &TrackList,
        sets: &mut Vec<Option<Self>>,
    ) -> Self {
        sets.clear();
        sets.resize(1 << list.count, None);
        sets[0] = Some(Self::default());
        for (vehicle, truth) in scene.vehicles.iter().enumerate().filter(|(i, _)| in_view[*i]) {
            let gap_m = truth.rear_position_m - scene.ego.position_m;
            let mut square_of = [f64::INFINITY; MAX_TRACKS];
            for (square, track) in square_of.iter_mut().zip(list.tracks()) {
                let (x, y) = (track.gap_m - gap_m, track.lateral_m - truth.lateral_m);
                *square = x * x + y * y;
            }
            if square_of.iter().all(|square| *square >= CUTOFF_M * CUTOFF_M) {
                continue;
            }
            // A set grows to a larger number: from the largest on, each way takes this vehicle once.
            for set in (0..sets.len()).rev() {
                let Some(pairs) = sets[set] else { continue };
                for (index, square) in square_of.into_iter().enumerate() {
                    if square < CUTOFF_M * CUTOFF_M && set & 1 << index == 0 {
                        let mut pairs = pairs;
                        pairs.vehicle_of[index] = Some(vehicle as u8);
                        pairs.count += 1;
                        pairs.squares += square;
                        let place = &mut sets[set | 1 << index];
                        if place.is_none_or(|found| pairs.squares < found.squares) {
                            *place = Some(pairs);
                        }
                    }
                }
            }
        }
        let mut best = Self::default();
        for pairs in sets.iter().flatten() {
            if pairs.saved() > best.saved() {
                best = *pairs;
            }
        }
        best.add_partly_seen(scene, in_view, list);
        best
    }

    /// The track of a vehicle.
    pub(crate) fn track_of(&self, vehicle: usize) -> Option<usize> {
        self.vehicle_of.iter().position(|of| of.map(usize::from) == Some(vehicle))
    }

    /// Gives the remaining tracks to the vehicles on whose bodies they are.
    fn add_partly_seen(&mut self, scene: &Scene, in_view: &[bool], list: &TrackList) {
        for (index, track) in list.tracks().iter().enumerate() {
            if self.vehicle_of[index].is_some() {
                continue;
            }
            let owner = (0..scene.vehicles.len()).find(|&vehicle| {
                let truth = &scene.vehicles[vehicle];
                let along_m = track.gap_m + scene.ego.position_m - truth.rear_position_m;
                truth.present
                    && !in_view[vehicle]
                    && self.track_of(vehicle).is_none()
                    && (-BODY_MARGIN_M..truth.length_m + BODY_MARGIN_M).contains(&along_m)
                    && (track.lateral_m - truth.lateral_m).abs() < BODY_MARGIN_M
            });
            if let Some(owner) = owner {
                self.vehicle_of[index] = Some(owner as u8);
                self.partly += 1;
            }
        }
    }

    /// Penalty for missed and false that the pairs save.
    fn saved(&self) -> f64 {
        CUTOFF_M * CUTOFF_M * self.count as f64 - self.squares
    }
}
