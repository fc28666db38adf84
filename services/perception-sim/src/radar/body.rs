//! The outline of a vehicle as the radar sees it.
//!
//! On a curve a vehicle stands askew to the ego. Its outline is given in its own axes, turned about the radar. `rear_m`
//! and `front_m` are along it, `right_m` and `left_m` across it, each from the radar. In these axes the rear shows when
//! it is ahead, and the side on the radar's side shows. On a straight road the axes are the ego's own.

use std::ops::RangeInclusive;

use scenario::actor::MAX_ACTORS;

use super::scene::Scene;

/// An outline in the vehicle's axes, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) rear_m: f64,
    pub(super) front_m: f64,
    pub(super) right_m: f64,
    pub(super) left_m: f64,
    /// The middle between the sides.
    pub(super) middle_m: f64,
    turn: Option<Turn>,
    /// Velocity of the rear's middle relative to the radar, in the ego's axes, m/s.
    velocity_mps: (f64, f64),
}

/// Pose of a vehicle relative to the ego.
#[derive(Clone, Copy, Debug)]
struct Turn {
    cosine: f64,
    sine: f64,
    yaw_rate_radps: f64,
}

impl Turn {
    fn to_ego(self, (along, across): (f64, f64)) -> (f64, f64) {
        (self.cosine * along - self.sine * across, self.sine * along + self.cosine * across)
    }

    fn to_body(self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.cosine * x + self.sine * y, self.cosine * y - self.sine * x)
    }
}

impl Body {
    pub(super) fn of(scene: &Scene, index: usize) -> Self {
        let vehicle = &scene.vehicles[index];
        let straight = |rear_m: f64, middle_m: f64, velocity_mps: (f64, f64)| Self {
            rear_m,
            front_m: rear_m + vehicle.length_m,
            right_m: middle_m - 0.5 * vehicle.width_m,
            left_m: middle_m + 0.5 * vehicle.width_m,
            middle_m,
            turn: None,
            velocity_mps,
        };
        let Some(plane) = &scene.plane else {
            let speed_mps = vehicle.speed_mps - scene.ego.speed_mps;
            return straight(
                vehicle.rear_position_m - scene.ego.position_m,
                vehicle.lateral_m,
                (speed_mps, vehicle.lateral_speed_mps),
            );
        };
        let pose = &plane.bodies[index];
        if pose.sine == 0.0 && pose.yaw_rate_radps == 0.0 && pose.cosine == 1.0 {
            return straight(pose.rear_m.0, pose.rear_m.1, pose.velocity_mps);
        }
        let turn =
            Turn { cosine: pose.cosine, sine: pose.sine, yaw_rate_radps: pose.yaw_rate_radps };
        let (rear_m, middle_m) = turn.to_body(pose.rear_m);
        Self { turn: Some(turn), ..straight(rear_m, middle_m, pose.velocity_mps) }
    }

    pub(super) fn is_ahead(&self) -> bool {
        let Some(turn) = self.turn else { return self.front_m > 0.0 };
        let ahead = |along, across| turn.to_ego((along, across)).0 > 0.0;
        ahead(self.front_m, self.left_m)
            || ahead(self.front_m, self.right_m)
            || ahead(self.rear_m, self.left_m)
            || ahead(self.rear_m, self.right_m)
    }

    /// A place of its own axes in the ego's.
    pub(super) fn seen_from_ego(&self, place: (f64, f64)) -> (f64, f64) {
        self.turn.map_or(place, |turn| turn.to_ego(place))
    }

    /// Velocity of a place relative to the radar, in the ego's axes.
    pub(super) fn velocity_at(&self, (along_m, across_m): (f64, f64)) -> (f64, f64) {
        let (vx, vy) = self.velocity_mps;
        let Some(turn) = self.turn else { return (vx, vy) };
        let (dx, dy) = turn.to_ego((along_m - self.rear_m, across_m - self.middle_m));
        (vx - turn.yaw_rate_radps * dy, vy + turn.yaw_rate_radps * dx)
    }

    /// The straight line from the radar to a point of the ego's axes passes through the body before the point.
    pub(super) fn hides(&self, (x_m, y_m): (f64, f64)) -> bool {
        match self.turn {
            Some(turn) => self.hides_askew(turn.to_body((x_m, y_m))),
            None => self.hides_ahead(x_m, y_m),
        }
    }

    fn hides_ahead(&self, x_m: f64, y_m: f64) -> bool {
        if self.front_m <= 0.0 || self.rear_m >= x_m {
            return false;
        }
        let slope = y_m / x_m;
        let (mut enter, mut leave) = (self.rear_m.max(0.0), self.front_m.min(x_m - NEAR_M));
        if slope.abs() < 1e-9 {
            return self.right_m < y_m && y_m < self.left_m && enter < leave;
        }
        let (a, b) = (self.right_m / slope, self.left_m / slope);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
        enter < leave
    }

    /// The same of a point in its own axes, in any direction. The result is shares of the line inside the slab of each
    /// axis.
    fn hides_askew(&self, (along_m, across_m): (f64, f64)) -> bool {
        let (mut enter, mut leave) = (0.0, 1.0);
        let slabs = [(along_m, self.rear_m, self.front_m), (across_m, self.right_m, self.left_m)];
        for (way_m, low_m, high_m) in slabs {
            if way_m.abs() < 1e-9 {
                if !(low_m < 0.0 && 0.0 < high_m) {
                    return false;
                }
                continue;
            }
            // Most bodies are behind the radar, or beyond the point: no need to divide.
            let is_apart = match way_m > 0.0 {
                true => high_m <= 0.0 || low_m >= way_m,
                false => low_m >= 0.0 || high_m <= way_m,
            };
            if is_apart {
                return false;
            }
            let (a, b) = (low_m / way_m, high_m / way_m);
            enter = a.min(b).max(enter);
            leave = a.max(b).min(leave);
        }
        let length_m = libm::sqrt(along_m * along_m + across_m * across_m);
        enter < leave.min(1.0 - NEAR_M / length_m.max(NEAR_M))
    }

    /// The sectors of [`Outlines`] that it is in; `None` for one that is behind the radar.
    fn sectors(&self) -> Option<RangeInclusive<usize>> {
        let corners = [self.rear_m, self.front_m]
            .map(|along_m| [self.right_m, self.left_m].map(|m| self.seen_from_ego((along_m, m))));
        let (mut first, mut last) = (SECTORS, 0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut right, mut left) = (f64::INFINITY, f64::NEG_INFINITY);
        for &(x_m, y_m) in corners.as_flattened() {
            let sector = sector(x_m, y_m);
            (first, last) = (first.min(sector), last.max(sector));
            (least, most) = (least.min(x_m), most.max(x_m));
            (right, left) = (right.min(y_m), left.max(y_m));
        }
        // A body beside the radar or around it may reach from one side to the other behind it.
        let is_around = least <= 0.0 && right <= 0.0 && left >= 0.0;
        (most > 0.0).then_some(if is_around { 0..=SECTORS - 1 } else { first..=last })
    }
}

/// Sectors of the half plane ahead of the radar.
const SECTORS: usize = 256;

/// The sector of a point of the ego's axes, from right to left. A point behind the radar is in the first or the last.
fn sector(x_m: f64, y_m: f64) -> usize {
    let share = y_m / (x_m.max(0.0) + y_m.abs() + f64::MIN_POSITIVE);
    ((0.5 * SECTORS as f64 * (1.0 + share)) as usize).min(SECTORS - 1)
}

/// Distance before a point within which nothing hides it: it is on the body itself, m.
const NEAR_M: f64 = 0.01;

/// The outlines of a scene's vehicles, for one scan.
#[derive(Clone, Debug)]
pub(super) struct Outlines {
    /// In the scene's order; `None` of a vehicle that is not present.
    list: Vec<Option<Body>>,
    /// A bit for each vehicle in a sector: only these can hide a point in it.
    sectors: Box<[u64; SECTORS]>,
}

const _: () = assert!(MAX_ACTORS <= u64::BITS as usize);

impl Outlines {
    pub(super) fn with_room(count: usize) -> Self {
        Self { list: Vec::with_capacity(count), sectors: Box::new([0; SECTORS]) }
    }

    pub(super) fn take(&mut self, scene: &Scene) {
        self.list.clear();
        self.sectors.fill(0);
        for (index, vehicle) in scene.vehicles.iter().enumerate() {
            let body = vehicle.present.then(|| Body::of(scene, index));
            let sectors = body.as_ref().and_then(Body::sectors);
            for sector in sectors.map_or(&mut [][..], |sectors| &mut self.sectors[sectors]) {
                *sector |= 1 << index;
            }
            self.list.push(body);
        }
    }

    /// The outline of the vehicle number `index`, if it is present.
    pub(super) fn get(&self, index: usize) -> Option<Body> {
        self.list[index]
    }

    /// True if a vehicle, other than number `itself`, stands between the radar and a point of the ego's axes.
    pub(super) fn hide(&self, itself: Option<usize>, point: (f64, f64)) -> bool {
        let mut left = self.sectors[sector(point.0, point.1)];
        left &= !itself.map_or(0, |index| 1 << index);
        while left != 0 {
            let body = &self.list[left.trailing_zeros() as usize];
            if body.as_ref().is_some_and(|body| body.hides(point)) {
                return true;
            }
            left &= left - 1;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn body(rear_m: f64, middle_m: f64, turn_rad: f64) -> Body {
        let (sine, cosine) = libm::sincos(turn_rad);
        Body {
            rear_m,
            front_m: rear_m + 4.5,
            right_m: middle_m - 0.9,
            left_m: middle_m + 0.9,
            middle_m,
            turn: Some(Turn { cosine, sine, yaw_rate_radps: 0.0 }),
            velocity_mps: (0.0, 0.0),
        }
    }

    proptest! {
        #[test]
        fn an_outline_that_stands_straight_hides_the_same_by_both_tests(
            rear_m in 0.5_f64..60.0, middle_m in -8.0_f64..8.0,
            x_m in 1.0_f64..150.0, y_m in -20.0_f64..20.0,
        ) {
            prop_assume!((rear_m - x_m).abs() > 0.05);
            let body = body(rear_m, middle_m, 0.0);
            prop_assert_eq!(body.hides_ahead(x_m, y_m), body.hides_askew((x_m, y_m)));
        }

        /// A turn of body and point about the radar changes nothing.
        #[test]
        fn what_is_hidden_does_not_depend_on_the_direction(
            rear_m in 2.0_f64..60.0, middle_m in -8.0_f64..8.0,
            along_m in 1.0_f64..150.0, across_m in -20.0_f64..20.0, turn_rad in -1.5_f64..1.5,
        ) {
            prop_assume!((rear_m - along_m).abs() > 0.05);
            let straight = body(rear_m, middle_m, 0.0).hides_ahead(along_m, across_m);
            let turned = body(rear_m, middle_m, turn_rad);
            let seen = turned.seen_from_ego((along_m, across_m));
            // Rounding decides for a line that grazes a corner.
            let grown = |by_m: f64| {
                let body = Body { right_m: turned.right_m - by_m, left_m: turned.left_m + by_m, ..turned };
                body.hides(seen)
            };
            prop_assume!(grown(1e-9) == grown(-1e-9));
            prop_assert_eq!(straight, turned.hides(seen));
        }
    }

    proptest! {
        /// The sectors leave out no body that hides a point.
        #[test]
        fn what_hides_a_point_is_in_its_sector(
            rear_m in -6.0_f64..60.0, middle_m in -8.0_f64..8.0, turn_rad in -3.0_f64..3.0,
            x_m in 0.1_f64..150.0, y_m in -50.0_f64..50.0,
        ) {
            let body = body(rear_m, middle_m, turn_rad);
            let holds = body.sectors().is_some_and(|sectors| sectors.contains(&sector(x_m, y_m)));
            prop_assert!(holds || !body.hides((x_m, y_m)));
        }
    }

    #[test]
    fn a_body_that_turns_moves_faster_on_the_outside() {
        let mut body = body(40.0, 0.0, 0.0);
        body.turn = Some(Turn { cosine: 1.0, sine: 0.0, yaw_rate_radps: 0.1 });
        body.velocity_mps = (-2.0, 0.0);
        // It turns to the left: the left corner is slower, and the front swings to the left.
        assert_eq!(body.velocity_at((40.0, 0.9)), (-2.0 - 0.09, 0.0));
        let (vx, vy) = body.velocity_at((44.5, 0.0));
        assert!(vx == -2.0 && (vy - 0.45).abs() < 1e-12);
    }
}
