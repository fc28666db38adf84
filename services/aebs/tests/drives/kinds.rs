//! Scenes drawn by chance.

use perception_sim::vehicle::Vehicle;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Course of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Steady,
    Clutter,
    Queue,
    TwoWheeler,
    Slower,
    Braking,
    CutIn,
}

pub const KINDS: [Kind; 7] = [
    Kind::Steady,
    Kind::Clutter,
    Kind::Queue,
    Kind::TwoWheeler,
    Kind::Slower,
    Kind::Braking,
    Kind::CutIn,
];

/// Motion of another vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Actor {
    pub gap_m: f64,
    pub speed_mps: f64,
    pub lateral_m: f64,
    pub width_m: f64,
    pub length_m: f64,
    /// Begin and duration of its way to the ego's lane, s.
    pub comes_s: (f64, f64),
    /// Begin, s, and strength, m/s², of its braking.
    pub brakes: (f64, f64),
}

impl Actor {
    fn car(gap_m: f64, speed_mps: f64) -> Self {
        Self {
            gap_m,
            speed_mps,
            lateral_m: 0.0,
            width_m: 1.8,
            length_m: 4.5,
            comes_s: (f64::INFINITY, 1.0),
            brakes: (f64::INFINITY, 0.0),
        }
    }

    /// The vehicle at a time.
    pub fn at(&self, time_s: f64) -> Vehicle {
        let (from_s, braking) = self.brakes;
        let stops_s = if braking > 0.0 { self.speed_mps / braking } else { 0.0 };
        let braked_s = (time_s - from_s).clamp(0.0, stops_s);
        let speed_mps = self.speed_mps - braking * braked_s;
        let moving_s = if time_s - from_s > stops_s { from_s + stops_s } else { time_s };
        let (begins_s, lasts_s) = self.comes_s;
        let part = ((time_s - begins_s) / lasts_s).clamp(0.0, 1.0);
        let (sine, cosine) = (std::f64::consts::PI * part).sin_cos();
        let is_moving = part > 0.0 && part < 1.0;
        let rate = -0.5 * self.lateral_m * std::f64::consts::PI / lasts_s * sine;
        Vehicle {
            present: true,
            rear_position_m: self.gap_m + self.speed_mps * moving_s
                - 0.5 * braking * braked_s * braked_s,
            speed_mps,
            acceleration_mps2: if braked_s > 0.0 && braked_s < stops_s { -braking } else { 0.0 },
            lateral_m: 0.5 * self.lateral_m * (1.0 + cosine),
            lateral_speed_mps: if is_moving { rate } else { 0.0 },
            length_m: self.length_m,
            width_m: self.width_m,
            touches_within_m: 0.5 * (self.width_m + 1.8),
            turned_rad: 0.0,
        }
    }
}

/// A drive.
#[derive(Clone, Debug)]
pub struct Drive {
    pub seed: u64,
    pub ego_mps: f64,
    pub ego_mps2: f64,
    pub false_alarms: f64,
    pub duration_s: f64,
    pub actors: Vec<Actor>,
    /// Time when the danger begins, s.
    pub danger_s: f64,
    /// The ego's own law brakes with this, m/s², so much later, s.
    pub answer: (f64, f64),
}

/// Draws a drive of a kind.
pub fn draw(kind: Kind, seed: u64) -> Drive {
    let mut random = Pcg64::seed_from_u64(seed.wrapping_mul(31) + kind as u64);
    let mut between = |from: f64, to: f64| {
        from + (to - from) * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    };
    let ego_mps = between(12.0, 33.0);
    let mut drive = Drive {
        seed,
        ego_mps,
        ego_mps2: 0.0,
        false_alarms: 0.5,
        duration_s: 12.0,
        actors: Vec::new(),
        danger_s: 0.0,
        answer: (0.0, f64::INFINITY),
    };
    match kind {
        Kind::Steady | Kind::Clutter => {
            drive.actors.push(Actor::car(ego_mps * between(0.9, 1.8), ego_mps));
            drive.false_alarms = if kind == Kind::Clutter { 50.0 } else { 0.5 };
            drive.duration_s = 20.0;
        }
        Kind::Queue => {
            let side = if between(0.0, 1.0) < 0.5 { 3.5 } else { -3.5 };
            let first_m = between(40.0, 80.0);
            for place in 0..7 {
                let gap_m = first_m + f64::from(place) * between(6.5, 8.0);
                drive.actors.push(Actor { lateral_m: side, ..Actor::car(gap_m, 0.0) });
            }
            drive.ego_mps = between(10.0, 22.0);
        }
        Kind::TwoWheeler => {
            let width_m = between(0.5, 0.8);
            let off_m = 0.9 + between(0.5, 1.0) + 0.5 * width_m;
            let side = if between(0.0, 1.0) < 0.5 { off_m } else { -off_m };
            let rider = Actor::car(between(50.0, 120.0), 0.0);
            drive.actors.push(Actor { lateral_m: side, width_m, length_m: 1.9, ..rider });
            drive.ego_mps = between(8.0, 20.0);
        }
        Kind::Slower => {
            let other_mps = (ego_mps - between(5.0, 33.0)).max(0.0);
            drive.actors.push(Actor::car(between(70.0, 140.0), other_mps));
            drive.ego_mps2 = between(0.0, 0.5);
        }
        Kind::Braking => {
            let braking = between(3.0, 7.0);
            let lead = Actor::car(ego_mps * between(0.8, 1.6), ego_mps);
            drive.danger_s = between(2.0, 4.0);
            drive.actors.push(Actor { brakes: (drive.danger_s, braking), ..lead });
            drive.answer = (between(1.0, 4.9), between(0.8, 2.0));
        }
        Kind::CutIn => {
            let other_mps = ego_mps - between(2.0, 10.0);
            let (begins_s, lasts_s) = (between(1.5, 3.0), between(1.5, 3.0));
            let danger_s = begins_s + 0.5 * lasts_s;
            let distance_m = between(0.4, 1.0) * ego_mps;
            let gap_m = distance_m + (ego_mps - other_mps) * danger_s;
            let car = Actor::car(gap_m, other_mps);
            let brakes = (danger_s + between(0.5, 2.0), between(2.0, 5.0));
            drive.actors.push(Actor {
                lateral_m: if between(0.0, 1.0) < 0.5 { 3.5 } else { -3.5 },
                comes_s: (begins_s, lasts_s),
                brakes,
                ..car
            });
            drive.danger_s = danger_s;
            drive.answer = (between(2.0, 4.9), between(0.3, 1.0));
        }
    }
    drive
}
