//! The object list: what a radar with a perfect tracker's knowledge of identities would measure.
//!
//! It measures range, range rate and azimuth of the middle of each visible vehicle's rear bumper. Each has independent
//! Gaussian noise. A vehicle is missed with a given probability. A vehicle is visible if its rear bumper is ahead of
//! the ego's front bumper, within range and field of view. Vehicles do not hide each other. The vehicle of each
//! measurement is known.
//!
//! Every vehicle has its own stream of random numbers, drawn whether it is visible or not. So events of one vehicle do
//! not change the noise on another.

use bytemuck::Zeroable;
use messages::Detection;
use scenario::Scenario;
use scenario::perception::Radar;

use super::Scan;
use super::numbers::Numbers;
use super::receiver::{Accuracy, Receiver};
use super::scene::Scene;
use crate::random::Random;

/// Range and field of view.
#[derive(Clone, Copy, Debug, Default)]
pub struct View {
    max_range_m: f64,
    /// Tangent of half of the opening angle; infinite where that is not below a right angle.
    half_tangent: f64,
}

impl View {
    pub fn new(radar: &Radar) -> Self {
        let half_deg = 0.5 * radar.field_of_view_deg.value();
        Self {
            max_range_m: radar.max_range_m.value(),
            half_tangent: if half_deg < 90.0 {
                libm::tan(half_deg.to_radians())
            } else {
                f64::INFINITY
            },
        }
    }

    /// The middle of the rear of vehicle number `index` is in range and field of view.
    pub fn shows(&self, scene: &Scene, index: usize) -> bool {
        let (dx, dy) = Self::place(scene, index);
        scene.vehicles[index].present
            && dx > 0.0
            && dx * dx + dy * dy <= self.max_range_m * self.max_range_m
            && dy.abs() <= self.half_tangent * dx
    }

    /// The exact measurement of vehicle number `index`, when it is visible. The range rate leaves out the lateral speed
    /// of a lane change. It is perpendicular to the line of sight within a few degrees.
    pub fn measure(&self, scene: &Scene, index: usize) -> Option<Detection> {
        if !self.shows(scene, index) {
            return None;
        }
        let (dx, dy) = Self::place(scene, index);
        let range_m = (dx * dx + dy * dy).sqrt();
        let range_rate_mps = match &scene.plane {
            Some(plane) if !plane.is_line => {
                let (vx, vy) = plane.bodies[index].velocity_mps;
                (vx * dx + vy * dy) / range_m
            }
            _ => (scene.vehicles[index].speed_mps - scene.ego.speed_mps) * dx / range_m,
        };
        let azimuth_rad = libm::atan2(dy, dx);
        Some(Detection { range_m, range_rate_mps, azimuth_rad, ..Detection::zeroed() })
    }

    /// The middle of a vehicle's rear in the ego's axes, m.
    fn place(scene: &Scene, index: usize) -> (f64, f64) {
        let vehicle = &scene.vehicles[index];
        match &scene.plane {
            Some(plane) => plane.bodies[index].rear_m,
            None => (vehicle.rear_position_m - scene.ego.position_m, vehicle.lateral_m),
        }
    }
}

/// The radar with its random numbers.
#[derive(Clone, Debug)]
pub struct ObjectListRadar {
    view: View,
    receiver: Receiver,
    dropout_probability: f64,
    noise: Vec<Random>,
    detections: Vec<Detection>,
    vehicles: Vec<usize>,
}

impl ObjectListRadar {
    pub fn new(scenario: &Scenario) -> Self {
        let radar = &scenario.perception.radar;
        let seed = scenario.seed.value();
        let actors = scenario.actors.len();
        let exact = |floor: f64| Accuracy { resolution: 0.0, floor };
        Self {
            view: View::new(radar),
            receiver: Receiver {
                range: exact(radar.range_sigma_m.value()),
                range_rate: exact(radar.range_rate_sigma_mps.value()),
                azimuth: exact(radar.azimuth_sigma_deg.value().to_radians()),
                merges: false,
                threshold: 1.0,
                false_alarms: 0.0,
                numbers: Numbers::DEFAULT,
            },
            dropout_probability: radar.dropout_probability.value(),
            noise: (0..actors as u64).map(|actor| Random::of_run(seed, actor)).collect(),
            detections: Vec::with_capacity(actors),
            vehicles: Vec::with_capacity(actors),
        }
    }

    /// Its accuracy. It resolves all vehicles, and no signal-to-noise ratio changes its errors.
    pub fn receiver(&self) -> &Receiver {
        &self.receiver
    }

    pub fn scan(&mut self, scene: &Scene) -> Scan<'_> {
        self.detections.clear();
        self.vehicles.clear();
        let Receiver { range, range_rate, azimuth, .. } = self.receiver;
        for (vehicle, random) in self.noise.iter_mut().enumerate() {
            let (first, second) = random.normal_pair();
            let (third, _) = random.normal_pair();
            let uniform = random.uniform();
            let Some(exact) = self.view.measure(scene, vehicle) else { continue };
            if uniform >= self.dropout_probability {
                self.vehicles.push(vehicle);
                self.detections.push(Detection {
                    range_m: (exact.range_m + range.floor * first).max(0.0),
                    range_rate_mps: exact.range_rate_mps + range_rate.floor * second,
                    azimuth_rad: exact.azimuth_rad + azimuth.floor * third,
                    ..exact
                });
            }
        }
        Scan { detections: &self.detections, vehicles: &self.vehicles }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::Ego;
    use super::*;
    use crate::vehicle::Vehicle;

    fn radar(keys: &str, actors: usize) -> ObjectListRadar {
        let mut text = format!(
            "schema_version = 1\nname = \"x\"\n[perception.radar]\nmodel = \"object-list\"\n{keys}\n"
        );
        for i in 0..actors {
            text += &format!("[[actors]]\nname = \"a{i}\"\ngap_m = 9\ninitial_speed_mps = 0\n");
        }
        ObjectListRadar::new(
            &Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}")),
        )
    }

    fn vehicle(rear_position_m: f64, lateral_m: f64) -> Vehicle {
        Vehicle {
            present: true,
            rear_position_m,
            lateral_m,
            speed_mps: 20.0,
            length_m: 4.5,
            ..Vehicle::default()
        }
    }

    fn scene(vehicles: &[Vehicle]) -> Scene {
        Scene::new(0, EGO, vehicles)
    }

    const EGO: Ego = Ego { position_m: 0.0, speed_mps: 25.0, acceleration_mps2: 0.0 };
    const EXACT: &str = "range_sigma_m = 0\nrange_rate_sigma_mps = 0\nazimuth_sigma_deg = 0";

    #[test]
    fn geometry_without_noise() {
        let mut radar = radar(EXACT, 1);
        let detection = radar.scan(&scene(&[vehicle(40.0, 3.0)])).detections[0];
        let range = (1600.0f64 + 9.0).sqrt();
        assert!((detection.range_m - range).abs() < 1e-12);
        assert!((detection.range_rate_mps + 5.0 * 40.0 / range).abs() < 1e-12);
        assert!((detection.azimuth_rad - libm::atan(3.0 / 40.0)).abs() < 1e-12);
    }

    #[test]
    fn range_and_field_of_view_end_where_they_should() {
        let keys = format!("{EXACT}\nmax_range_m = 100\nfield_of_view_deg = 90");
        let mut radar = radar(&keys, 1);
        let mut sees = |x, y| !radar.scan(&scene(&[vehicle(x, y)])).detections.is_empty();
        assert!(sees(100.0, 0.0) && !sees(100.001, 0.0));
        assert!(sees(10.0, 9.99) && !sees(10.0, 10.01));
        assert!(sees(10.0, -9.99) && !sees(10.0, -10.01));
        assert!(!sees(0.0, 0.0) && !sees(-5.0, 0.0));
    }

    #[test]
    fn a_vehicle_that_is_not_there_is_not_seen() {
        let absent = Vehicle { present: false, ..vehicle(40.0, 0.0) };
        assert!(radar(EXACT, 1).scan(&scene(&[absent])).detections.is_empty());
    }

    #[test]
    fn noise_and_dropouts_have_the_stated_statistics() {
        let keys = "range_sigma_m = 0.4\nrange_rate_sigma_mps = 0.15\nazimuth_sigma_deg = 0.3\n\
            dropout_probability = 0.1";
        let mut radar = radar(keys, 1);
        let (n, mut seen, mut sum, mut squares) = (40_000, 0.0, [0.0; 3], [0.0; 3]);
        for _ in 0..n {
            let Some(d) = radar.scan(&scene(&[vehicle(40.0, 0.0)])).detections.first().copied()
            else {
                continue;
            };
            seen += 1.0;
            let errors = [d.range_m - 40.0, d.range_rate_mps + 5.0, d.azimuth_rad.to_degrees()];
            for (i, error) in errors.into_iter().enumerate() {
                sum[i] += error;
                squares[i] += error * error;
            }
        }
        assert!((seen / f64::from(n) - 0.9).abs() < 0.006, "{seen} of {n} seen");
        for (i, sigma) in [0.4, 0.15, 0.3].into_iter().enumerate() {
            let mean: f64 = sum[i] / seen;
            let deviation = (squares[i] / seen).sqrt();
            assert!(mean.abs() < 4.0 * sigma / seen.sqrt(), "mean {mean} of {i}");
            assert!((deviation / sigma - 1.0).abs() < 0.02, "deviation {deviation} of {i}");
        }
    }

    #[test]
    fn equal_seeds_see_equal_things_and_others_do_not() {
        let scans = |seed: u64| {
            let text = format!(
                "schema_version = 1\nname = \"x\"\nseed = {seed}\n[[actors]]\n\
                name = \"a\"\ngap_m = 9\ninitial_speed_mps = 0"
            );
            let mut radar =
                ObjectListRadar::new(&Scenario::parse("x.toml", &text).expect("it is right"));
            [(); 20].map(|()| radar.scan(&scene(&[vehicle(40.0, 0.0)])).detections.first().copied())
        };
        assert_eq!(scans(1), scans(1));
        assert_ne!(scans(1), scans(2));
    }

    #[test]
    fn another_vehicle_does_not_change_the_noise() {
        let (mut alone, mut together) = (radar("", 1), radar("", 2));
        for k in 0..50 {
            let first = vehicle(40.0, 0.0);
            let second = vehicle(20.0 + f64::from(k), -3.5);
            let both = together.scan(&scene(&[first, second]));
            let alone = alone.scan(&scene(&[first]));
            assert_eq!((alone.vehicles.len(), both.vehicles[0]), (1, 0));
            assert_eq!(alone.detections[0], both.detections[0]);
        }
    }
}
