//! Guard rails, and the mirror images of vehicles in them.
//!
//! A rail stands on some stretches of the road. It keeps one distance from the middle of the ego's lane. The image of a
//! vehicle is as far beyond the rail as the vehicle is before it. On a curve the rail mirrors as its tangent does at
//! the place where the wave strikes it. The ways from the radar and from the vehicle make equal angles with that
//! tangent. A bent rail also gathers or spreads the wave; that is left out.

use super::body::Body;
use super::numbers::Numbers;
use super::scene::{Plane, Scene};
use crate::random::{fixed, hash};
use crate::vehicle::Vehicle;
use road::Axis;

/// Slope of the way by the place that is struck at which that place is found: some centimetres of it.
const STRUCK: f64 = 1e-3;

/// Streams of random numbers for the places of rails.
const RAIL_STREAM: u64 = 1 << 32;

/// Guard rails on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Rail {
    /// Share of the road's stretches that have one; 0: none.
    pub share: f64,
    /// Distance from the centre of the ego's lane, m.
    pub offset_m: f64,
    /// Factor on the power of the direct echo.
    pub factor: f64,
}

impl Rail {
    /// It stands on a side at a place of the road, m.
    pub(super) fn stands(&self, seed: u64, side: u64, at_m: f64, numbers: &Numbers) -> bool {
        let stretch = (at_m / numbers.rail_stretch_m).floor() as i64;
        fixed(hash(seed, RAIL_STREAM + side), stretch as u64) < self.share
    }
}

/// A mirror image in the ego's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Image {
    pub(super) place_m: (f64, f64),
    pub(super) velocity_mps: (f64, f64),
    /// Place of the road where the wave strikes the rail, m.
    pub(super) struck_m: f64,
}

/// Image of the middle of a vehicle's rear in a rail at `offset_m`. `None` for a vehicle beyond the rail itself.
pub(super) fn image(
    scene: &Scene,
    road: Option<&Axis>,
    vehicle: &Vehicle,
    body: &Body,
    offset_m: f64,
) -> Option<Image> {
    let rear = (body.rear_m, body.middle_m);
    let (vx, vy) = body.velocity_at(rear);
    if let (Some(plane), Some(road)) = (&scene.plane, road)
        && !plane.is_line
    {
        let lateral_m = vehicle.lateral_m;
        if (offset_m - lateral_m) * offset_m <= 0.0 {
            return None;
        }
        let from_m = scene.ego.position_m;
        let share = offset_m / (2.0 * offset_m - lateral_m);
        let guess_m = from_m + share * (vehicle.rear_position_m - from_m);
        return image_on(plane, road, body.seen_from_ego(rear), (vx, vy), (guess_m, offset_m));
    }
    let (x, y) = rear;
    if (offset_m - y) * offset_m <= 0.0 {
        return None;
    }
    let image_y = 2.0 * offset_m - y;
    let struck_m = scene.ego.position_m + x * offset_m / image_y;
    Some(Image { place_m: (x, image_y), velocity_mps: (vx, -vy), struck_m })
}

/// The image of a point `(x, y)` in the rail of a curved road. The place that the wave strikes makes its way the
/// shortest or longest. Newton's steps on the derivative of the way find it, three at most.
fn image_on(
    plane: &Plane,
    road: &Axis,
    (x, y): (f64, f64),
    (vx, vy): (f64, f64),
    (guess_m, offset_m): (f64, f64),
) -> Option<Image> {
    let mut struck_m = guess_m;
    let mut place = plane.pose(road, struck_m, offset_m);
    for step in 0..=3 {
        let (tx, ty) = (place.cosine, place.sine);
        let (rx, ry) = place.at_m;
        let (dx, dy) = (rx - x, ry - y);
        let (to_ego_m, to_body_m) =
            (libm::sqrt(rx * rx + ry * ry).max(1.0), libm::sqrt(dx * dx + dy * dy).max(1.0));
        let (ux, uy) = (rx / to_ego_m + dx / to_body_m, ry / to_ego_m + dy / to_body_m);
        let slope = tx * ux + ty * uy;
        if slope.abs() < STRUCK {
            break;
        }
        if step == 3 {
            if slope.abs() > 0.02 {
                return None;
            }
            break;
        }
        let (a, b) = ((tx * ry - ty * rx) / to_ego_m, (tx * dy - ty * dx) / to_body_m);
        let curvature = place.curvature_perm;
        let stretch = 1.0 - curvature * offset_m;
        let bend = curvature / stretch * (tx * uy - ty * ux);
        let second = a * a / to_ego_m + b * b / to_body_m + bend;
        if second.abs() < 1e-9 {
            return None;
        }
        struck_m -= (slope / second).clamp(-30.0, 30.0) / stretch;
        place = plane.pose(road, struck_m, offset_m);
    }
    let (nx, ny) = (-place.sine, place.cosine);
    let before_m = (x - place.at_m.0) * nx + (y - place.at_m.1) * ny;
    // Mirrored is the motion over ground, not that relative to the radar.
    let (ex, ey) = plane.ego.velocity_mps;
    let outward_mps = (vx + ex) * nx + (vy + ey) * ny;
    Some(Image {
        place_m: (x - 2.0 * before_m * nx, y - 2.0 * before_m * ny),
        velocity_mps: (vx - 2.0 * outward_mps * nx, vy - 2.0 * outward_mps * ny),
        struck_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::scene::tests::on_circle;

    #[test]
    fn half_of_the_road_has_a_rail_when_half_of_its_stretches_do() {
        let rail = Rail { share: 0.5, offset_m: 8.0, factor: 0.03 };
        let numbers = &Numbers::DEFAULT;
        let seen = (0..400).filter(|k| rail.stands(1, 0, 100.0 * f64::from(*k) + 50.0, numbers));
        assert!((150..250).contains(&seen.count()));
    }

    /// The way over the rail is as long as the way to the image. It strikes the rail on the line to the image.
    #[test]
    fn on_a_curve_the_image_is_behind_the_place_that_the_wave_strikes() {
        for (radius_m, offset_m) in [(300.0, 8.0), (300.0, -8.0), (-500.0, 8.0), (1e6, 8.0)] {
            let (scene, road) = on_circle(radius_m, 60.0, 0.5);
            let vehicle = &scene.vehicles[0];
            let body = Body::of(&scene, 0);
            let image = image(&scene, Some(&road), vehicle, &body, offset_m).expect("a rail");
            let plane = scene.plane.as_ref().expect("a plane");
            let struck = plane.pose(&road, image.struck_m, offset_m).at_m;
            let (x, y) = body.seen_from_ego((body.rear_m, body.middle_m));
            let way_m = struck.0.hypot(struck.1) + (struck.0 - x).hypot(struck.1 - y);
            let (ix, iy) = image.place_m;
            assert!((ix.hypot(iy) - way_m).abs() < 0.02, "{radius_m} {offset_m}");
            let across_m = (struck.0 * iy - struck.1 * ix) / ix.hypot(iy);
            assert!(across_m.abs() < 0.2, "{radius_m} {offset_m}: {across_m}");
        }
    }
}
