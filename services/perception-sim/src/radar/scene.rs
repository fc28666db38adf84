//! The scene before the radar at one instant.

use road::{Axis, Pose};

use crate::vehicle::Vehicle;

/// The ego as the radar's platform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ego {
    /// Position of the front bumper along the road, m.
    pub position_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// The ego and the other vehicles at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// When, ns since the start of the run; before it: negative.
    pub time_ns: i64,
    pub ego: Ego,
    /// The ego by its odometry; `None` without usable odometry.
    pub told: Option<Ego>,
    /// The other vehicles, in the scenario's order.
    pub vehicles: Vec<Vehicle>,
    /// Places in the plane, where the road has a plan.
    pub plane: Option<Plane>,
}

/// The ego in the plane, with the road beginning at the origin, along x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneEgo {
    /// Middle of the front bumper and the body's heading.
    pub pose: Pose,
    /// Velocity of the front bumper along the body and to its left, m/s.
    pub velocity_mps: (f64, f64),
    /// Yaw rate, rad/s, left positive.
    pub yaw_rate_radps: f64,
    /// Yaw rate by the ego's sensor; `None` without a usable one.
    pub told_yaw_rate_radps: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    pub ego: PlaneEgo,
    /// The other vehicles before it, in the scene's order.
    pub bodies: Vec<Standing>,
    /// All of it stands along one line, the ego in the middle of its lane: nothing is askew.
    pub is_line: bool,
    /// Cosine and sine of the ego's heading.
    heading: (f64, f64),
}

/// Pose of a vehicle ahead of the ego.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Standing {
    /// Middle of the rear in the ego's axes, m.
    pub rear_m: (f64, f64),
    /// Cosine of the body's heading in the ego's axes.
    pub cosine: f64,
    pub sine: f64,
    pub yaw_rate_radps: f64,
    /// Velocity of the rear's middle relative to the ego's bumper, in the ego's axes, m/s.
    pub velocity_mps: (f64, f64),
}

/// A place of the road before the ego.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// In the ego's axes, m.
    pub(super) at_m: (f64, f64),
    /// Cosine and sine of the road's heading there, in the ego's axes.
    pub(super) cosine: f64,
    pub(super) sine: f64,
    pub(super) curvature_perm: f64,
}

impl Plane {
    pub fn new(road: &Axis, ego: PlaneEgo, vehicles: &[Vehicle]) -> Self {
        let mut plane = Self::default();
        plane.place(road, ego, vehicles);
        plane
    }

    fn place(&mut self, road: &Axis, ego: PlaneEgo, vehicles: &[Vehicle]) {
        let (sine, cosine) = libm::sincos(ego.pose.heading_rad);
        (self.ego, self.heading) = (ego, (cosine, sine));
        self.is_line = ego.pose.heading_rad == 0.0 && ego.pose.y_m == 0.0;
        self.bodies.clear();
        for vehicle in vehicles {
            let place = standing(&ego, (cosine, sine), road, vehicle);
            self.is_line &= !vehicle.present || place.sine == 0.0 && place.yaw_rate_radps == 0.0;
            self.bodies.push(place);
        }
    }

    /// A point beside the road in the ego's axes, m.
    pub(super) fn point(&self, road: &Axis, p_m: f64, l_m: f64) -> (f64, f64) {
        let there = road.point(p_m, l_m);
        seen(&self.ego.pose, self.heading, (there.x_m, there.y_m))
    }

    /// A place of the road in the ego's axes.
    pub(super) fn pose(&self, road: &Axis, p_m: f64, l_m: f64) -> Place {
        place(&self.ego.pose, self.heading, &road.frame(p_m, l_m))
    }
}

/// A place of the road in the ego's axes.
fn place(ego: &Pose, heading: (f64, f64), there: &road::Place) -> Place {
    let (ego_cosine, ego_sine) = heading;
    Place {
        at_m: seen(ego, heading, (there.x_m, there.y_m)),
        cosine: there.cos * ego_cosine + there.sin * ego_sine,
        sine: there.sin * ego_cosine - there.cos * ego_sine,
        curvature_perm: there.curvature_perm,
    }
}

/// A point of the plane in the ego's axes, m.
fn seen(ego: &Pose, (cosine, sine): (f64, f64), (x_m, y_m): (f64, f64)) -> (f64, f64) {
    let (dx, dy) = (x_m - ego.x_m, y_m - ego.y_m);
    (cosine * dx + sine * dy, cosine * dy - sine * dx)
}

/// A body is a rectangle. Its middle lies on its offset from the axis, and it has the heading of the axis there.
fn standing(ego: &PlaneEgo, heading: (f64, f64), road: &Axis, vehicle: &Vehicle) -> Standing {
    if !vehicle.present {
        return Standing::default();
    }
    let half_m = 0.5 * vehicle.length_m;
    let (rear_m, lateral_m) = (vehicle.rear_position_m, vehicle.lateral_m);
    let middle = road.frame(rear_m + vehicle.half_along_m(), lateral_m);
    if vehicle.turned_rad != 0.0 {
        return turned(ego, place(&ego.pose, heading, &middle), vehicle);
    }
    let Place { at_m: (x, y), cosine, sine, curvature_perm } = place(&ego.pose, heading, &middle);
    let yaw_rate_radps = curvature_perm * vehicle.speed_mps / (1.0 - curvature_perm * lateral_m);
    // On a straight the rear is on the axis itself, to the last bit.
    let is_straight = curvature_perm == 0.0 && road.heading_rad(rear_m) == middle.heading_rad;
    let rear_m = if is_straight {
        let rear = road.point(rear_m, lateral_m);
        seen(&ego.pose, heading, (rear.x_m, rear.y_m))
    } else {
        (x - half_m * cosine, y - half_m * sine)
    };
    let across_mps = vehicle.lateral_speed_mps - yaw_rate_radps * half_m;
    Standing {
        rear_m,
        cosine,
        sine,
        yaw_rate_radps,
        velocity_mps: (
            vehicle.speed_mps * cosine - across_mps * sine - ego.velocity_mps.0,
            vehicle.speed_mps * sine + across_mps * cosine - ego.velocity_mps.1,
        ),
    }
}

/// A body at an angle to the axis; `place` is its middle.
fn turned(ego: &PlaneEgo, place: Place, vehicle: &Vehicle) -> Standing {
    let half_m = 0.5 * vehicle.length_m;
    let (along_mps, across_mps) = (vehicle.speed_mps, vehicle.lateral_speed_mps);
    let (turned_sine, turned_cosine) = libm::sincos(vehicle.turned_rad);
    let cosine = place.cosine * turned_cosine - place.sine * turned_sine;
    let sine = place.sine * turned_cosine + place.cosine * turned_sine;
    let (x, y) = place.at_m;
    Standing {
        rear_m: (x - half_m * cosine, y - half_m * sine),
        cosine,
        sine,
        yaw_rate_radps: 0.0,
        velocity_mps: (
            along_mps * place.cosine - across_mps * place.sine - ego.velocity_mps.0,
            along_mps * place.sine + across_mps * place.cosine - ego.velocity_mps.1,
        ),
    }
}

impl Scene {
    pub fn new(time_ns: i64, ego: Ego, vehicles: &[Vehicle]) -> Self {
        Self { time_ns, ego, told: Some(ego), vehicles: vehicles.to_vec(), plane: None }
    }

    /// An empty scene with room for `count` vehicles, in the plane or not.
    pub(crate) fn with_room(count: usize, in_plane: bool) -> Self {
        let plane =
            in_plane.then(|| Plane { bodies: Vec::with_capacity(count), ..Plane::default() });
        Self { vehicles: Vec::with_capacity(count), plane, ..Self::default() }
    }

    /// Becomes the same as another scene. It keeps its room: a loop does not allocate.
    pub(crate) fn copy(&mut self, source: &Self) {
        (self.time_ns, self.ego, self.told) = (source.time_ns, source.ego, source.told);
        self.vehicles.clone_from(&source.vehicles);
        match (&mut self.plane, &source.plane) {
            (Some(own), Some(plane)) => {
                (own.ego, own.is_line, own.heading) = (plane.ego, plane.is_line, plane.heading);
                own.bodies.clone_from(&plane.bodies);
            }
            (own, plane) => own.clone_from(plane),
        }
    }

    pub fn on(mut self, road: &Axis, ego: PlaneEgo) -> Self {
        self.stand_on(road, ego);
        self
    }

    /// Places the vehicles on a road in the plane.
    pub(crate) fn stand_on(&mut self, road: &Axis, ego: PlaneEgo) {
        self.plane.get_or_insert_default().place(road, ego, &self.vehicles);
    }

    /// The scene `back_ns` earlier, if all had kept the present speed and their distance from the axis of `road`.
    pub fn earlier(&self, back_ns: i64, road: Option<&Axis>) -> Self {
        let mut scene = Self::default();
        self.write_earlier(back_ns, road, &mut scene);
        scene
    }

    /// Writes the scene of [`Self::earlier`] into room that is there.
    pub(crate) fn write_earlier(&self, back_ns: i64, road: Option<&Axis>, into: &mut Self) {
        let back_s = back_ns as f64 * 1e-9;
        let earlier = |ego: Ego| Ego {
            position_m: ego.position_m - ego.speed_mps * back_s,
            acceleration_mps2: 0.0,
            ..ego
        };
        into.time_ns = self.time_ns - back_ns;
        (into.ego, into.told) = (earlier(self.ego), self.told.map(earlier));
        into.vehicles.clear();
        into.vehicles.extend(self.vehicles.iter().map(|vehicle| Vehicle {
            rear_position_m: vehicle.rear_position_m - vehicle.speed_mps * back_s,
            acceleration_mps2: 0.0,
            lateral_speed_mps: 0.0,
            ..*vehicle
        }));
        let (Some(plane), Some(road)) = (&self.plane, road) else {
            into.plane = None;
            return;
        };
        let (_, lateral_m) =
            road.project(plane.ego.pose.x_m, plane.ego.pose.y_m, self.ego.position_m);
        let ego = into.ego;
        let yaw_rate_radps = road.curvature_perm(ego.position_m) * ego.speed_mps;
        let before = PlaneEgo {
            pose: road.point(ego.position_m, lateral_m),
            velocity_mps: (ego.speed_mps, 0.0),
            yaw_rate_radps,
            told_yaw_rate_radps: plane.ego.told_yaw_rate_radps.map(|_| yaw_rate_radps),
        };
        into.stand_on(road, before);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use road::Piece;

    /// A car `gap_m` ahead of an ego, both at 20 m/s, `lateral_m` left of the middle of a circle's lane.
    pub(in super::super) fn on_circle(radius_m: f64, gap_m: f64, lateral_m: f64) -> (Scene, Axis) {
        let arc = Piece::Arc { length_m: 200.0, curvature_perm: 1.0 / radius_m };
        let road = Axis::new(&[arc]).expect("a road");
        let ego = Ego { position_m: 10.0, speed_mps: 20.0, acceleration_mps2: 0.0 };
        let car = Vehicle {
            present: true,
            rear_position_m: 10.0 + gap_m,
            speed_mps: 20.0,
            lateral_m,
            length_m: 4.5,
            width_m: 1.8,
            ..Vehicle::default()
        };
        let in_plane = PlaneEgo {
            pose: road.point(10.0, 0.0),
            velocity_mps: (20.0, 0.0),
            yaw_rate_radps: 20.0 / radius_m,
            told_yaw_rate_radps: Some(20.0 / radius_m),
        };
        (Scene::new(0, ego, &[car]).on(&road, in_plane), road)
    }

    #[test]
    fn on_a_circle_the_lead_stands_where_the_chord_ends() {
        let (scene, _) = on_circle(200.0, 40.0, 0.0);
        let lead = scene.plane.expect("a plane").bodies[0];
        let angle = 42.25 / 200.0;
        let (sine, cosine) = libm::sincos(angle);
        let x = 200.0 * sine - 2.25 * cosine;
        let y = 200.0 * (1.0 - cosine) - 2.25 * sine;
        assert!((lead.rear_m.0 - x).abs() < 1e-6 && (lead.rear_m.1 - y).abs() < 1e-6, "{lead:?}");
        assert!((lead.sine - sine).abs() < 1e-9 && (lead.yaw_rate_radps - 0.1).abs() < 1e-12);
        // Seen from the ego it keeps its distance: only its direction turns.
        let (vx, vy) = lead.velocity_mps;
        let (x, y) = (200.0 * sine, 200.0 * (1.0 - cosine));
        let (mx, my) = (vx - 0.1 * 2.25 * sine, vy + 0.1 * 2.25 * cosine);
        assert!((mx * x + my * y).abs() / x.hypot(y) < 1e-6);
    }

    #[test]
    fn a_plan_of_one_line_gives_the_bits_of_the_straight_road() {
        let road = Axis::new(&[Piece::Line { length_m: 500.0 }]).expect("a road");
        let ego = Ego { position_m: 33.3, speed_mps: 21.7, acceleration_mps2: 0.0 };
        let car = Vehicle {
            present: true,
            rear_position_m: 97.123,
            speed_mps: 19.37,
            lateral_m: 3.47,
            lateral_speed_mps: -0.3,
            length_m: 16.5,
            width_m: 2.5,
            ..Vehicle::default()
        };
        let in_plane = PlaneEgo {
            pose: road.point(33.3, 0.0),
            velocity_mps: (21.7, 0.0),
            ..PlaneEgo::default()
        };
        let plane = Scene::new(0, ego, &[car]).on(&road, in_plane).plane.expect("a plane");
        let body = plane.bodies[0];
        assert!(plane.is_line);
        assert_eq!(body.rear_m, (97.123 - 33.3, 3.47));
        assert_eq!(body.velocity_mps, (19.37 - 21.7, -0.3));
        assert_eq!((body.cosine, body.sine, body.yaw_rate_radps), (1.0, 0.0, 0.0));
    }

    #[test]
    fn earlier_all_were_farther_back_on_the_road() {
        let (scene, road) = on_circle(-300.0, 50.0, 3.0);
        let earlier = scene.earlier(500_000_000, Some(&road));
        assert_eq!(earlier.ego.position_m, 0.0);
        let (now, then) = (scene.plane.expect("a plane"), earlier.plane.expect("a plane"));
        assert!((now.bodies[0].rear_m.0 - then.bodies[0].rear_m.0).abs() < 1e-6);
        assert!((now.bodies[0].rear_m.1 - then.bodies[0].rear_m.1).abs() < 1e-6);
    }
}
