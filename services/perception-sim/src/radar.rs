//! The radar at the middle of the ego's front bumper.
//!
//! It measures each visible vehicle at the middle of its rear bumper: range, range rate and azimuth,
//! with independent Gaussian noise on each, and misses it with a given probability. A vehicle is
//! visible when its rear bumper is ahead of the ego's front bumper, within range and field of view;
//! nothing hides behind anything. Which measurement belongs to which vehicle is known.
//!
//! Every vehicle has its own stream of random numbers, drawn whether it is visible or not: what
//! happens to one vehicle does not change the noise on another.

use messages::MAX_TRACKS;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenario::Scenario;

use crate::traffic::Vehicle;

/// The ego as the radar's platform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ego {
    /// Position of the front bumper along the road, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// One measurement of one vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Detection {
    /// Distance from the middle of the front bumper to the middle of the rear bumper, m.
    pub range_m: f64,
    /// Rate of the range, m/s, negative when closing.
    pub range_rate_mps: f64,
    /// Azimuth, rad, left positive.
    pub azimuth_rad: f64,
}

/// What one scan saw, by the vehicle's place in the scenario.
pub type Scan = [Option<Detection>; MAX_TRACKS];

/// The radar with its random numbers.
#[derive(Clone, Debug)]
pub struct Radar {
    max_range_m: f64,
    half_field_of_view_rad: f64,
    range_sigma_m: f64,
    range_rate_sigma_mps: f64,
    azimuth_sigma_rad: f64,
    dropout_probability: f64,
    noise: Vec<Pcg64>,
}

impl Radar {
    /// The radar of a scenario; an ideal one neither errs nor misses.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let radar = &scenario.perception.radar;
        let imperfect = if scenario.perception.ideal { 0.0 } else { 1.0 };
        let seed = scenario.seed.value();
        Self {
            max_range_m: radar.max_range_m.value(),
            half_field_of_view_rad: 0.5 * radar.field_of_view_deg.value().to_radians(),
            range_sigma_m: imperfect * radar.range_sigma_m.value(),
            range_rate_sigma_mps: imperfect * radar.range_rate_sigma_mps.value(),
            azimuth_sigma_rad: imperfect * radar.azimuth_sigma_deg.value().to_radians(),
            dropout_probability: imperfect * radar.dropout_probability.value(),
            noise: (0..scenario.actors.len() as u64).map(|actor| stream(seed, actor)).collect(),
        }
    }

    /// Takes one scan of the vehicles.
    pub fn scan(&mut self, ego: &Ego, vehicles: &[Vehicle]) -> Scan {
        let mut scan = [None; MAX_TRACKS];
        for (i, vehicle) in vehicles.iter().enumerate().take(MAX_TRACKS) {
            let noise = Noise::draw(&mut self.noise[i]);
            scan[i] = self
                .geometry(ego, vehicle)
                .filter(|_| noise.uniform >= self.dropout_probability)
                .map(|exact| Detection {
                    range_m: (exact.range_m + self.range_sigma_m * noise.gaussian[0]).max(0.0),
                    range_rate_mps: exact.range_rate_mps
                        + self.range_rate_sigma_mps * noise.gaussian[1],
                    azimuth_rad: exact.azimuth_rad + self.azimuth_sigma_rad * noise.gaussian[2],
                });
        }
        scan
    }

    /// The exact measurement, when the vehicle is visible. The lateral speed of a lane change is
    /// left out of the range rate: it is perpendicular to the line of sight but for a few degrees.
    fn geometry(&self, ego: &Ego, vehicle: &Vehicle) -> Option<Detection> {
        let (dx, dy) = (vehicle.rear_position_m - ego.position_m, vehicle.lateral_m);
        if !vehicle.present || dx <= 0.0 {
            return None;
        }
        let range_m = (dx * dx + dy * dy).sqrt();
        let azimuth_rad = libm::atan2(dy, dx);
        let visible =
            range_m <= self.max_range_m && azimuth_rad.abs() <= self.half_field_of_view_rad;
        let range_rate_mps = (vehicle.speed_mps - ego.speed_mps) * dx / range_m;
        visible.then_some(Detection { range_m, range_rate_mps, azimuth_rad })
    }
}

/// The random numbers of one vehicle.
fn stream(seed: u64, actor: u64) -> Pcg64 {
    // The golden ratio's odd multiples keep the streams of neighbouring seeds and vehicles apart.
    Pcg64::seed_from_u64(seed.wrapping_add(actor.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// The random part of one measurement.
struct Noise {
    /// Independent standard normal numbers.
    gaussian: [f64; 3],
    /// Uniform in [0, 1).
    uniform: f64,
}

impl Noise {
    fn draw(random: &mut Pcg64) -> Self {
        let (first, second) = gaussian_pair(random);
        let (third, _) = gaussian_pair(random);
        Self { gaussian: [first, second, third], uniform: uniform(random) }
    }
}

/// Two independent standard normal numbers (Box and Muller 1958).
fn gaussian_pair(random: &mut Pcg64) -> (f64, f64) {
    let radius = (-2.0 * libm::log(1.0 - uniform(random))).sqrt();
    let angle = 2.0 * std::f64::consts::PI * uniform(random);
    (radius * libm::cos(angle), radius * libm::sin(angle))
}

/// Uniform in [0, 1), with 53 bits.
fn uniform(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn radar(keys: &str, actors: usize) -> Radar {
        let mut text = format!("schema_version = 1\nname = \"x\"\n[perception.radar]\n{keys}\n");
        for i in 0..actors {
            text += &format!("[[actors]]\nname = \"a{i}\"\ngap_m = 9\ninitial_speed_mps = 0\n");
        }
        Radar::new(&Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}")))
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

    const EGO: Ego = Ego { position_m: 0.0, speed_mps: 25.0, acceleration_mps2: 0.0 };
    const EXACT: &str = "range_sigma_m = 0\nrange_rate_sigma_mps = 0\nazimuth_sigma_deg = 0";

    #[test]
    fn geometry_without_noise() {
        let scan = radar(EXACT, 1).scan(&EGO, &[vehicle(40.0, 3.0)]);
        let detection = scan[0].expect("it is visible");
        let range = (1600.0f64 + 9.0).sqrt();
        assert!((detection.range_m - range).abs() < 1e-12);
        assert!((detection.range_rate_mps + 5.0 * 40.0 / range).abs() < 1e-12);
        assert!((detection.azimuth_rad - libm::atan(3.0 / 40.0)).abs() < 1e-12);
    }

    #[test]
    fn range_and_field_of_view_end_where_they_should() {
        let keys = format!("{EXACT}\nmax_range_m = 100\nfield_of_view_deg = 90");
        let mut radar = radar(&keys, 1);
        let mut sees = |x, y| radar.scan(&EGO, &[vehicle(x, y)])[0].is_some();
        assert!(sees(100.0, 0.0) && !sees(100.001, 0.0));
        assert!(sees(10.0, 9.99) && !sees(10.0, 10.01));
        assert!(sees(10.0, -9.99) && !sees(10.0, -10.01));
        assert!(!sees(0.0, 0.0) && !sees(-5.0, 0.0));
    }

    #[test]
    fn a_vehicle_that_is_not_there_is_not_seen() {
        let absent = Vehicle { present: false, ..vehicle(40.0, 0.0) };
        assert_eq!(radar(EXACT, 1).scan(&EGO, &[absent]), [None; MAX_TRACKS]);
    }

    #[test]
    fn noise_and_dropouts_have_the_stated_statistics() {
        let keys = "range_sigma_m = 0.4\nrange_rate_sigma_mps = 0.15\nazimuth_sigma_deg = 0.3\n\
            dropout_probability = 0.1";
        let mut radar = radar(keys, 1);
        let (n, mut seen, mut sum, mut squares) = (40_000, 0.0, [0.0; 3], [0.0; 3]);
        for _ in 0..n {
            let Some(d) = radar.scan(&EGO, &[vehicle(40.0, 0.0)])[0] else { continue };
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
            let mut radar = Radar::new(&Scenario::parse("x.toml", &text).expect("it is right"));
            [(); 20].map(|()| radar.scan(&EGO, &[vehicle(40.0, 0.0)])[0])
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
            assert_eq!(alone.scan(&EGO, &[first])[0], together.scan(&EGO, &[first, second])[0]);
        }
    }

    /// So that a change of the generator or of its seeding cannot pass unseen.
    #[test]
    fn the_random_numbers_are_the_named_generators() {
        let mut random = stream(1, 0);
        let drawn = [(); 3].map(|()| random.next_u64());
        let first = 15_492_934_433_077_865_799;
        assert_eq!(drawn, [first, 319_104_231_195_455_319, 2_101_115_697_694_094_752]);
    }
}
