//! Whether an axis crosses itself.

use crate::{AxisError, CROSSING_WITHIN_M, Pose};

/// Length of the chords that stand for the axis, m.
const CHORD_M: f64 = 5.0;

/// Checks that branches near each other along an axis of `length_m` do not cross. Its pieces begin at `starts`.
pub fn uncrossed(
    length_m: f64,
    starts: &[f64],
    pose: impl Fn(f64) -> Pose,
) -> Result<(), AxisError> {
    let chords = libm::ceil(length_m / CHORD_M) as usize;
    let window = (CROSSING_WITHIN_M / CHORD_M) as usize;
    let at = |i: usize| pose((CHORD_M * i as f64).min(length_m));
    let poses: Vec<_> = (0..=chords).map(at).collect();
    for i in 0..chords {
        let (mut least, mut most) = (poses[i].heading_rad, poses[i].heading_rad);
        for j in i + 1..chords.min(i + window + 1) {
            for pose in &poses[j..=j + 1] {
                least = least.min(pose.heading_rad);
                most = most.max(pose.heading_rad);
            }
            // A curve that turns by less than half a circle cannot meet itself.
            if most - least < std::f64::consts::PI || j == i + 1 {
                continue;
            }
            let ends = [&poses[i], &poses[i + 1], &poses[j], &poses[j + 1]].map(|p| (p.x_m, p.y_m));
            if cross(ends) {
                let (first_m, second_m) = (CHORD_M * i as f64, CHORD_M * j as f64);
                let begun = starts.partition_point(|start| *start <= second_m);
                let piece = begun.saturating_sub(1);
                return Err(AxisError::Crossing { piece, first_m, second_m });
            }
        }
    }
    Ok(())
}

/// True if the chords `a b` and `c d` cross.
fn cross([a, b, c, d]: [(f64, f64); 4]) -> bool {
    let side = |p: (f64, f64), q: (f64, f64), r: (f64, f64)| {
        (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)
    };
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}
