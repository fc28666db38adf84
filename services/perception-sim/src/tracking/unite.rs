//! Tracks of one vehicle become one.

use scenario::event::VEHICLE_WIDTH_M;

use super::course::Course;
use super::numbers::Numbers;
use super::track::DetectedTrack;

/// Unites tracks of one vehicle; the older one stays.
pub(super) fn unite(
    tracks: &mut Vec<DetectedTrack>,
    course: &Course,
    coast_s: f64,
    numbers: &Numbers,
) {
    let mut newer = 1;
    while newer < tracks.len() {
        // One that is lost is not what is found: its place is a guess.
        let same = (0..newer).find(|&older| {
            tracks[older].unseen_s <= coast_s
                && same(&tracks[older], &tracks[newer], course, numbers)
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

/// Two tracks are of one vehicle: the newer one is on the older one and moves with it. On another lane it may be
/// before the older one by the length of a lorry: its rear comes into view last.
fn same(older: &DetectedTrack, newer: &DetectedTrack, course: &Course, numbers: &Numbers) -> bool {
    let (a, b) = (older.along.estimate(), newer.along.estimate());
    let along_m = b.gap_m - a.gap_m;
    let (a_y, b_y) = (older.across.position_m(), newer.across.position_m());
    let aspect_m = older.aspect_m(course).abs().min(newer.aspect_m(course).abs());
    let aside = aspect_m > VEHICLE_WIDTH_M;
    let before_m = if aside { numbers.lorry_m } else { numbers.same_before_m };
    let is_far_before = along_m <= -numbers.same_before_m && aside;
    let rate_mps = if is_far_before { numbers.same_lorry_mps } else { numbers.same_mps };
    (-before_m..older.length_m).contains(&along_m)
        && (a_y - b_y).abs() < numbers.same_across_m
        && (a.relative_speed_mps - b.relative_speed_mps).abs() < rate_mps
        && (older.unseen_s <= newer.unseen_s || newer.id == 0)
}
