//! Tracks of one vehicle become one.

use super::numbers::Numbers;
use super::track::{DetectedTrack, Life};

/// Unites tracks of one vehicle; the older one stays.
pub(super) fn unite(tracks: &mut Vec<DetectedTrack>, life: &Life, numbers: &Numbers) {
    let mut newer = 1;
    while newer < tracks.len() {
        // One that is lost is not what is found: its place is a guess.
        let same = (0..newer).find(|&older| {
            tracks[older].vehicle.is_none()
                && tracks[older].unseen_s <= life.coast_s
                && same(&tracks[older], &tracks[newer], life, numbers)
        });
        match same {
            Some(older) => {
                let newer = tracks.remove(newer);
                tracks[older].take_over(&newer, numbers);
            }
            None => newer += 1,
        }
    }
}

/// Two tracks are of one vehicle: the newer one is on the older one and moves with it.
///
/// If the older one is not seen, the speeds do not count. Two bodies cannot be in one place, and its speed is a
/// prediction. In both cases the newer one gives its motion to the older one. So it has to be sure first. One echo
/// before a rear, or beside a vehicle that is not seen once, may be noise.
fn same(older: &DetectedTrack, newer: &DetectedTrack, life: &Life, numbers: &Numbers) -> bool {
    let (a, b) = (older.along.estimate(), newer.along.estimate());
    let along_m = b.gap_m - a.gap_m;
    let across_m = newer.across.position_m() - older.across.position_m();
    let is_unseen = older.unseen_s > 0.0;
    let gives_its_motion = is_unseen || along_m < -numbers.rear_depth_m;
    let is_sure = newer.id != 0 || newer.deserves_confirmation(life);
    let moves_alike = (a.relative_speed_mps - b.relative_speed_mps).abs() < numbers.same_mps;
    let took_its_place = is_unseen && newer.unseen_s == 0.0;
    (-numbers.same_before_m..older.length_m).contains(&along_m)
        && across_m.abs() < numbers.same_across_m
        && (is_sure || !gives_its_motion)
        && (took_its_place || moves_alike && older.unseen_s <= newer.unseen_s)
}

#[cfg(test)]
mod tests {
    use super::super::association::tests::point;
    use super::super::longitudinal::{Maneuver, Model};
    use super::super::sighting::Sighting;
    use super::*;

    const NUMBERS: Numbers = Numbers::DEFAULT;
    const COAST_S: f64 = 1.0;

    fn track(gap_m: f64, lateral_m: f64, relative_mps: f64) -> DetectedTrack {
        let quiet = Maneuver { sigma_mps2: 1.0, tau_s: 2.0 };
        let model = Model::new(quiet, 4.0, &NUMBERS);
        let points = [point(gap_m, lateral_m, relative_mps)];
        let sighting = Sighting::of(points.iter(), 0.0, &NUMBERS).expect("a point");
        DetectedTrack::begin(&model, &sighting, true)
    }

    /// Number of tracks left of a lead 60 m ahead, 4.5 m long, and another one, which is sure after `hits`.
    fn left_after(hits: u32, mut lead: DetectedTrack, other: DetectedTrack) -> usize {
        (lead.id, lead.length_m) = (1, 4.5);
        let mut tracks = vec![lead, other];
        let life = Life { hits, scans: hits, coast_s: COAST_S };
        unite(&mut tracks, &life, &NUMBERS);
        assert_eq!(tracks[0].id, 1, "the older one stays");
        tracks.len()
    }

    /// The same with another one that is sure at once.
    fn left(lead: DetectedTrack, other: DetectedTrack) -> usize {
        left_after(1, lead, other)
    }

    #[test]
    fn a_track_on_another_one_that_moves_with_it_is_the_same_vehicle() {
        let lead = track(60.0, 0.0, -2.0);
        for (gap_m, lateral_m, relative_mps, count) in [
            (60.0, 0.0, -2.0, 1),
            (58.1, 0.0, -2.0, 1),
            (57.9, 0.0, -2.0, 2),
            (64.4, 0.0, -2.0, 1),
            (64.6, 0.0, -2.0, 2),
            (60.0, 1.1, -2.0, 1),
            (60.0, -1.1, -2.0, 1),
            (60.0, 1.3, -2.0, 2),
            (60.0, 0.0, -0.6, 1),
            (60.0, 0.0, -3.4, 1),
            (60.0, 0.0, -0.4, 2),
        ] {
            let found = left(lead, track(gap_m, lateral_m, relative_mps));
            assert_eq!(found, count, "{gap_m} {lateral_m} {relative_mps}");
        }
    }

    #[test]
    fn a_sure_track_in_the_place_of_an_unseen_one_is_that_vehicle_unless_that_is_lost() {
        let (lead, same) = (track(60.0, 0.0, -2.0), track(60.0, 0.0, -2.0));
        let unseen = |unseen_s: f64| {
            let mut lead = lead;
            lead.unseen_s = unseen_s;
            lead
        };
        assert_eq!(left(unseen(COAST_S), same), 1);
        assert_eq!(left(unseen(1.01 * COAST_S), same), 2);
        let mut confirmed = same;
        confirmed.id = 2;
        assert_eq!(left(lead, confirmed), 1);
        assert_eq!(left(unseen(0.5), confirmed), 1);
        let slower = track(60.0, 0.0, -9.0);
        assert_eq!(left(unseen(0.5), slower), 1, "the unseen one's speed is a guess");
        assert_eq!(left(lead, slower), 2);
        assert_eq!(left_after(3, unseen(0.5), same), 2, "one echo is not sure");
        assert_eq!(left_after(3, lead, same), 1, "it gives no motion");
        assert_eq!(left_after(3, lead, track(59.0, 0.0, -2.0)), 2, "one echo before the rear");
    }
}
