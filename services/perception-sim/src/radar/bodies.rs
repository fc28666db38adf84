//! The echoes of vehicles.
//!
//! A vehicle reflects at a few places of its body ([`super::body`]). These are the middle of its rear, the rear
//! corners, and the wheelhouses of the side that it shows. A long vehicle has more places along that side. A place is
//! strong when its face is seen squarely; each has a fluctuation of its own. A hidden place is seen only under the
//! other vehicle, weaker. Beside the straight path a wave takes two others:
//!
//! * under the body: it is reflected between the road and the floor. It comes back later from the same direction: an
//!   echo beyond the true range.
//! * by the guard rail: the vehicle's mirror image, farther off and beyond the rail ([`super::rail`]).
//!
//! Sources. The reflecting places are those of Bühren and Yang. Source: Simulation of automotive radar target lists
//! using a novel approach of object representation (IEEE Intelligent Vehicles 2006). The mean cross section of a car,
//! 10 m², is that of ISO 15622's test target. Multipath by guard rails follows Kamann and others, Automotive radar
//! multipath propagation in uncertain environments (ITSC 2018). The strengths of the places and of the detours are
//! chosen, not measured.

use super::body::{Body, Outlines};
use super::echo::{Antenna, Echo, Fluctuation};
use super::numbers::Numbers;
use super::rail::{self, Rail};
use super::receiver::Echoes;
use super::scene::Scene;
use crate::random::Random;
use crate::vehicle::Vehicle;
use road::Axis;

#[derive(Clone, Copy, Debug)]
pub struct Bodies {
    /// Mean cross section of a car's rear, m².
    pub car_m2: f64,
    /// Mean cross section of a lorry's rear, m².
    pub lorry_m2: f64,
    /// Probability that a vehicle is missing from a scan, whatever its echoes are like.
    pub dropout_probability: f64,
    pub fluctuation: Fluctuation,
    /// Factor on the power of what another vehicle hides; 1: nothing hides anything.
    pub hidden_factor: f64,
    pub under_body: UnderBody,
    pub rail: Rail,
    /// Places that reflect.
    pub numbers: Numbers,
}

#[derive(Clone, Copy, Debug)]
pub struct UnderBody {
    pub probability: f64,
    /// Factor on the power of the rear's echo.
    pub factor: f64,
    /// Mean of the additional range, which is exponential, m.
    pub mean_m: f64,
}

impl Bodies {
    /// Adds the echoes of all vehicles of a scene.
    pub(super) fn reflect(
        &self,
        seed: u64,
        (scene, outlines): (&Scene, &Outlines),
        road: Option<&Axis>,
        antenna: &Antenna,
        echoes: &mut Echoes,
    ) {
        for (index, vehicle) in scene.vehicles.iter().enumerate() {
            let Some(body) = outlines.get(index) else { continue };
            if !body.is_ahead() || body.rear_m > antenna.max_range_m {
                continue;
            }
            let mut random = Random::of_scan(seed, index as u64 + 1, scene.time_ns);
            if random.uniform() < self.dropout_probability {
                continue;
            }
            let mut sight =
                Sight { bodies: self, seed, scene, outlines, road, antenna, random, echoes };
            sight.vehicle(index, vehicle, &body);
        }
    }
}

/// One vehicle in one scan.
struct Sight<'a> {
    bodies: &'a Bodies,
    seed: u64,
    scene: &'a Scene,
    outlines: &'a Outlines,
    road: Option<&'a Axis>,
    antenna: &'a Antenna,
    random: Random,
    echoes: &'a mut Echoes,
}

impl Sight<'_> {
    fn vehicle(&mut self, index: usize, vehicle: &Vehicle, body: &Body) {
        let numbers = &self.bodies.numbers;
        let lorry = vehicle.length_m > numbers.longest_car_m;
        let mean_m2 = if lorry { self.bodies.lorry_m2 } else { self.bodies.car_m2 };
        if body.rear_m > 0.0 {
            let middle = (body.rear_m, body.middle_m);
            let squarely = middle.0 / libm::sqrt(middle.0 * middle.0 + middle.1 * middle.1);
            let rear_m2 = mean_m2 * squarely * squarely;
            let echo = self.place(index, body, middle, numbers.rear_share * rear_m2);
            if let Some(echo) = echo {
                self.under_body(&echo);
            }
            let corner_m2 = numbers.corner_share * rear_m2;
            self.place(index, body, (body.rear_m, body.left_m), corner_m2);
            self.place(index, body, (body.rear_m, body.right_m), corner_m2);
            self.mirrored(vehicle, body, rear_m2);
        }
        let side_m = if body.right_m > 0.0 { body.right_m } else { body.left_m };
        if body.right_m > 0.0 || body.left_m < 0.0 {
            self.side(index, body, side_m, numbers.side_share * mean_m2);
        }
    }

    /// The places along a side.
    fn side(&mut self, index: usize, body: &Body, y_m: f64, area_m2: f64) {
        let numbers = &self.bodies.numbers;
        let (first, last) =
            (body.rear_m + numbers.wheelhouse_m, body.front_m - numbers.wheelhouse_m);
        let gaps = ((last - first) / numbers.side_spacing_m).ceil().max(1.0);
        for k in 0..=gaps as u32 {
            let x_m = first + (last - first) * f64::from(k) / gaps;
            let squarely = y_m.abs() / libm::sqrt(x_m * x_m + y_m * y_m);
            self.place(index, body, (x_m, y_m), area_m2 * squarely);
        }
    }

    /// The direct echo of one place in the body's own axes.
    fn place(
        &mut self,
        index: usize,
        body: &Body,
        place: (f64, f64),
        area_m2: f64,
    ) -> Option<Echo> {
        let fluctuation = self.bodies.fluctuation.draw(&mut self.random);
        let seen = body.seen_from_ego(place);
        let velocity = body.velocity_at(place);
        let mut echo = self.antenna.echo(seen, velocity, || area_m2 * fluctuation())?;
        if self.bodies.hidden_factor < 1.0 && self.outlines.hide(Some(index), seen) {
            echo.power *= self.bodies.hidden_factor;
        }
        self.echoes.add(echo);
        Some(echo)
    }

    fn under_body(&mut self, direct: &Echo) {
        let under = &self.bodies.under_body;
        if under.probability > 0.0 && self.random.uniform() < under.probability {
            let range_m = direct.range_m + under.mean_m * self.random.exponential();
            let fluctuation = self.bodies.fluctuation.draw(&mut self.random);
            let power = under.factor * fluctuation() * direct.power;
            self.echoes.add(Echo { range_m, power, ..*direct });
        }
    }

    /// The mirror images in the rails of both sides.
    fn mirrored(&mut self, vehicle: &Vehicle, body: &Body, area_m2: f64) {
        let rail = &self.bodies.rail;
        if rail.share <= 0.0 {
            return;
        }
        for (side, offset_m) in [(0, rail.offset_m), (1, -rail.offset_m)] {
            let Some(image) = rail::image(self.scene, self.road, vehicle, body, offset_m) else {
                continue;
            };
            if !rail.stands(self.seed, side, image.struck_m, &self.bodies.numbers) {
                continue;
            }
            let fluctuation = self.bodies.fluctuation.draw(&mut self.random);
            let area_m2 = || area_m2 * rail.factor * fluctuation();
            if let Some(echo) = self.antenna.echo(image.place_m, image.velocity_mps, area_m2) {
                self.echoes.add(echo);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::Ego;
    use super::*;

    const EXACT: Bodies = Bodies {
        car_m2: 10.0,
        lorry_m2: 30.0,
        dropout_probability: 0.0,
        fluctuation: Fluctuation::None,
        hidden_factor: 0.01,
        under_body: UnderBody { probability: 0.0, factor: 0.1, mean_m: 1.5 },
        rail: Rail { share: 0.0, offset_m: 8.0, factor: 0.03 },
        numbers: Numbers::DEFAULT,
    };

    fn car(rear_m: f64, lateral_m: f64) -> Vehicle {
        Vehicle {
            present: true,
            rear_position_m: rear_m,
            speed_mps: 20.0,
            lateral_m,
            length_m: 4.5,
            width_m: 1.8,
            ..Vehicle::default()
        }
    }

    fn echoes(bodies: &Bodies, vehicles: &[Vehicle]) -> Vec<Echo> {
        let ego = Ego { position_m: 0.0, speed_mps: 25.0, acceleration_mps2: 0.0 };
        let scene = Scene::new(0, ego, vehicles);
        let mut echoes = Echoes::new(64, &Numbers::DEFAULT);
        let mut outlines = Outlines::with_room(vehicles.len());
        outlines.take(&scene);
        bodies.reflect(
            1,
            (&scene, &outlines),
            None,
            &Antenna::new(15.0, 6.0, 60.0, 150.0),
            &mut echoes,
        );
        echoes.list().to_vec()
    }

    #[test]
    fn a_car_ahead_shows_its_rear_and_a_car_beside_its_side_too() {
        let ahead = echoes(&EXACT, &[car(40.0, 0.0)]);
        assert_eq!(ahead.len(), 3);
        assert!(ahead.iter().all(|echo| (echo.range_m - 40.0).abs() < 0.02));
        assert!(ahead.iter().all(|echo| (echo.range_rate_mps + 5.0).abs() < 0.01));
        let power: f64 = ahead.iter().map(|echo| echo.power).sum();
        let expected = 10f64.powf(1.5) * 10.0 * 2.5f64.powi(4);
        assert!((power / expected - 1.0).abs() < 0.01, "{power} of {expected}");

        let beside = echoes(&EXACT, &[car(20.0, 3.5)]);
        assert_eq!(beside.len(), 5);
        let lorry = Vehicle { length_m: 16.0, ..car(20.0, 3.5) };
        assert!(echoes(&EXACT, &[lorry]).len() >= 7);
    }

    #[test]
    fn a_car_that_is_overtaken_is_seen_while_any_of_it_is_ahead() {
        // The rear is behind the radar; the front wheelhouse is 10 m ahead.
        let long = Vehicle { length_m: 13.0, ..car(-2.0, 3.5) };
        assert!(!echoes(&EXACT, &[long]).is_empty());
        assert!(echoes(&EXACT, &[car(-5.0, 3.5)]).is_empty());
    }

    #[test]
    fn a_nearer_vehicle_hides_what_is_behind_it() {
        let near = echoes(&EXACT, &[car(40.0, 0.0)]);
        let both = echoes(&EXACT, &[car(40.0, 0.0), car(20.0, 0.0)]);
        assert_eq!(both.len(), 6);
        for (free, hidden) in near.iter().zip(&both) {
            assert!((hidden.power / free.power - 0.01).abs() < 1e-9);
        }
        // Beside it nothing is hidden, and the nearer one is not hidden by the farther.
        let lanes = echoes(&EXACT, &[car(40.0, 0.0), car(20.0, 3.5)]);
        assert!(near.iter().zip(&lanes).all(|(free, seen)| free.power == seen.power));
        let swapped = echoes(&EXACT, &[car(20.0, 0.0), car(40.0, 0.0)]);
        assert!(swapped[0].power > 0.99 * echoes(&EXACT, &[car(20.0, 0.0)])[0].power);
    }

    #[test]
    fn the_echo_from_under_the_body_comes_late() {
        let under = UnderBody { probability: 1.0, ..EXACT.under_body };
        let all = echoes(&Bodies { under_body: under, ..EXACT }, &[car(40.0, 0.0)]);
        let late: Vec<_> = all.iter().filter(|echo| echo.range_m > 40.05).collect();
        assert_eq!(late.len(), 1);
        assert!((late[0].power / all[0].power - 0.1).abs() < 1e-9);
        assert_eq!(late[0].azimuth_rad, all[0].azimuth_rad);
    }

    #[test]
    fn a_rail_shows_the_mirror_image() {
        let rail = Rail { share: 1.0, ..EXACT.rail };
        let all = echoes(&Bodies { rail, ..EXACT }, &[car(60.0, 2.0)]);
        let (mut left, mut right) = (0, 0);
        for echo in &all {
            let y = echo.range_m * libm::sin(echo.azimuth_rad);
            left += u32::from((y - 14.0).abs() < 1e-6);
            right += u32::from((y + 18.0).abs() < 1e-6);
        }
        assert_eq!((left, right), (1, 1));
    }
}
