//! A scene as data: the start of the ego, the other vehicles with their motion, and further tables of its scenario.
//!
//! The motion of a vehicle is known for all times. Along the road its speed is a chain of straight lines, so its
//! position is exact. Across the road it follows the polynomial of fifth order that `lateral` of a scenario stands for:
//!
//! ```text
//! y(s) = y0 + (y1 - y0) s³ (10 - 15 s + 6 s²),   s = (t - begin) / duration
//! ```
//!
//! The simulator integrates the same motion on its own. A test compares the two. A vehicle with `keys` moves as they
//! say, which [`Actor::at`] does not know.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenario::{Setting, Table, table};

pub const CAR_WIDTH_M: f64 = 1.8;
pub const CAR_LENGTH_M: f64 = 4.5;
pub const LANE_M: f64 = 3.5;

pub fn engine() -> Table {
    table! { mass_kg: 1600, max_power_kw: 110 }
}

/// A number as it is written with this number of decimals.
pub fn fixed(number: f64, decimals: i32) -> f64 {
    let scale = 10.0_f64.powi(decimals);
    // The sum makes -0 a 0.
    (number * scale).round() / scale + 0.0
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedChange {
    pub from_s: f64,
    /// Speed at its end, m/s.
    pub to_mps: f64,
    pub rate_mps2: f64,
}

/// A motion across the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralChange {
    pub from_s: f64,
    /// Lateral position at its end, m.
    pub to_m: f64,
    pub lasts_s: f64,
}

/// A vehicle beside the ego.
#[derive(Clone, Debug, PartialEq)]
pub struct Actor {
    pub name: String,
    /// Distance from the ego's front bumper to its rear bumper at the start, m.
    pub gap_m: f64,
    pub speed_mps: f64,
    /// Lateral position at the start, m, left positive.
    pub lateral_m: f64,
    pub length_m: f64,
    pub width_m: f64,
    /// Changes of its speed, in order of time. A change ends where the next one begins.
    pub speeds: Vec<SpeedChange>,
    /// Motions across the road, in order of time and one after the other.
    pub laterals: Vec<LateralChange>,
    pub keys: Table,
}

/// Place and motion of a vehicle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Rear bumper, m from the ego's front bumper at the start.
    pub rear_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Lateral position of its middle, m.
    pub lateral_m: f64,
}

impl Actor {
    /// A car in the ego's lane that keeps its speed.
    pub fn car(name: impl Into<String>, gap_m: f64, speed_mps: f64) -> Self {
        Self {
            name: name.into(),
            gap_m,
            speed_mps,
            lateral_m: 0.0,
            length_m: CAR_LENGTH_M,
            width_m: CAR_WIDTH_M,
            speeds: Vec::new(),
            laterals: Vec::new(),
            keys: Table::new(),
        }
    }

    pub fn at(&self, time_s: f64) -> Place {
        let (mut rear_m, mut speed_mps, mut acceleration_mps2) = (self.gap_m, self.speed_mps, 0.0);
        let first_s = self.speeds.first().map_or(f64::INFINITY, |change| change.from_s);
        rear_m += speed_mps * time_s.min(first_s);
        for (index, change) in self.speeds.iter().enumerate() {
            let end_s = self.speeds.get(index + 1).map_or(f64::INFINITY, |next| next.from_s);
            let lasts_s = time_s.min(end_s) - change.from_s;
            if lasts_s <= 0.0 {
                break;
            }
            let rate_mps2 = change.rate_mps2.copysign(change.to_mps - speed_mps);
            let changes_s = (change.to_mps - speed_mps).abs() / change.rate_mps2;
            let changed_s = lasts_s.min(changes_s);
            rear_m += (speed_mps + 0.5 * rate_mps2 * changed_s) * changed_s;
            speed_mps += rate_mps2 * changed_s;
            rear_m += speed_mps * (lasts_s - changed_s);
            acceleration_mps2 = if lasts_s < changes_s { rate_mps2 } else { 0.0 };
        }
        let lateral_m = self.laterals.iter().fold(self.lateral_m, |from_m, change| {
            let s = ((time_s - change.from_s) / change.lasts_s).clamp(0.0, 1.0);
            from_m + (change.to_m - from_m) * s * s * s * (10.0 - s * (15.0 - 6.0 * s))
        });
        Place { rear_m, speed_mps, acceleration_mps2, lateral_m }
    }

    /// True if its body reaches into the ego's width.
    pub fn is_in_path(&self, place: &Place) -> bool {
        place.lateral_m.abs() < 0.5 * (self.width_m + CAR_WIDTH_M)
    }

    /// The vehicle with places, speeds and times of two decimals.
    pub fn fixed(mut self) -> Self {
        for number in [&mut self.gap_m, &mut self.speed_mps, &mut self.lateral_m] {
            *number = fixed(*number, 2);
        }
        for SpeedChange { from_s, to_mps, rate_mps2 } in &mut self.speeds {
            [from_s, to_mps, rate_mps2].into_iter().for_each(|number| *number = fixed(*number, 2));
        }
        for LateralChange { from_s, to_m, lasts_s } in &mut self.laterals {
            [from_s, to_m, lasts_s].into_iter().for_each(|number| *number = fixed(*number, 2));
        }
        self
    }

    fn table(&self) -> Table {
        let mut table = table! {
            name: self.name.as_str(),
            gap_m: self.gap_m,
            initial_speed_mps: self.speed_mps,
            lateral_offset_m: self.lateral_m,
            length_m: self.length_m,
            width_m: self.width_m,
        };
        table.extend(self.keys.clone());
        let speed = |change: &SpeedChange| {
            let SpeedChange { from_s, to_mps, rate_mps2 } = *change;
            table! { time_s: from_s, speed_mps: to_mps, acceleration_mps2: rate_mps2 }
        };
        if !self.speeds.is_empty() {
            let steps: Vec<Table> = self.speeds.iter().map(speed).collect();
            table.extend(table! { profile: table! { steps: steps } });
        }
        let lateral = |&LateralChange { from_s, to_m, lasts_s }: &LateralChange| {
            table! { time_s: from_s, to_m: to_m, duration_s: lasts_s }
        };
        if !self.laterals.is_empty() {
            let lateral: Vec<Table> = self.laterals.iter().map(lateral).collect();
            table.extend(table! { lateral: lateral });
        }
        table
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Speed of the ego at the start, m/s.
    pub speed_mps: f64,
    pub set_mps: f64,
    pub duration_s: f64,
    pub law: String,
    pub actors: Vec<Actor>,
    /// Vehicles whose motion only the simulator knows.
    pub others: Vec<Table>,
    /// Further keys of `[plant]`.
    pub plant: Table,
    /// Further keys of the scenario.
    pub keys: Vec<Setting>,
}

impl Scene {
    /// A scene without other vehicles.
    pub fn new(speed_mps: f64, set_mps: f64, duration_s: f64) -> Self {
        let (law, plant) = (String::new(), table! { powertrain: engine() });
        let (actors, others, keys) = (Vec::new(), Vec::new(), Vec::new());
        Self { speed_mps, set_mps, duration_s, law, actors, others, plant, keys }
    }

    pub fn with(mut self, actor: Actor) -> Self {
        self.actors.push(actor);
        self
    }

    pub fn settings(&self, name: &str, seed: u64) -> Vec<Setting> {
        let mut plant = self.plant.clone();
        plant.extend(table! { initial_speed_mps: self.speed_mps });
        let actors = self.actors.iter().map(Actor::table).chain(self.others.iter().cloned());
        let own = [
            Setting::new("name", name),
            Setting::new("duration_s", self.duration_s),
            Setting::new("seed", seed as i64),
            Setting::new("set_speed_mps", self.set_mps),
            Setting::new("plant", plant),
            Setting::new("controller.name", self.law.as_str()),
            Setting::new("actors", actors.collect::<Vec<_>>()),
        ];
        [&own[..], &self.keys].concat()
    }
}

/// Share of lorries among the vehicles of a road.
const LORRIES: f64 = 0.2;

/// Random numbers of one scene: a function of its number and of its population's stream.
#[derive(Debug)]
pub struct Draws {
    random: Pcg64,
    pub number: u64,
}

impl Draws {
    /// Numbers of scene `number`; `stream` distinguishes the kinds of scenes.
    pub fn new(number: u64, stream: u64) -> Self {
        Self { random: Pcg64::seed_from_u64(number ^ stream), number }
    }

    /// Numbers of scene `number` from a generator of this state and stream.
    pub fn of(number: u64, state: u128, stream: u128) -> Self {
        Self { random: Pcg64::new(state, stream), number }
    }

    /// Uniform between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * random::uniform(&mut self.random)
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    pub fn side(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.between(0.0, of.len() as f64)) as usize]
    }

    /// 32 random bits, which number another scene.
    pub fn bits(&mut self) -> u32 {
        self.random.next_u32()
    }

    /// Length and width of a vehicle, m.
    pub fn size_m(&mut self) -> (f64, f64) {
        if self.chance(LORRIES) { (12.0, 2.5) } else { (4.5, 1.8) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_speeds_has_the_distance_of_its_triangles() {
        let stop = SpeedChange { from_s: 2.0, to_mps: 0.0, rate_mps2: 4.0 };
        let go = SpeedChange { from_s: 10.0, to_mps: 6.0, rate_mps2: 2.0 };
        let actor = Actor { speeds: vec![stop, go], ..Actor::car("car", 30.0, 20.0) };
        assert_eq!(actor.at(1.0).rear_m, 50.0);
        let braking = actor.at(4.0);
        assert_eq!((braking.rear_m, braking.speed_mps), (102.0, 12.0));
        assert_eq!(braking.acceleration_mps2, -4.0);
        assert_eq!((actor.at(9.0).rear_m, actor.at(9.0).speed_mps), (120.0, 0.0));
        assert_eq!((actor.at(15.0).rear_m, actor.at(15.0).speed_mps), (141.0, 6.0));
        assert_eq!(actor.at(15.0).acceleration_mps2, 0.0);
    }

    #[test]
    fn a_motion_across_the_road_is_half_done_in_its_middle() {
        let comes = LateralChange { from_s: 1.0, to_m: 0.0, lasts_s: 4.0 };
        let leaves = LateralChange { from_s: 6.0, to_m: -3.0, lasts_s: 2.0 };
        let laterals = vec![comes, leaves];
        let actor = Actor { lateral_m: 3.5, laterals, ..Actor::car("car", 30.0, 20.0) };
        let lateral_m = |time_s| actor.at(time_s).lateral_m;
        assert_eq!([lateral_m(0.0), lateral_m(3.0), lateral_m(5.5)], [3.5, 1.75, 0.0]);
        assert_eq!([lateral_m(7.0), lateral_m(9.0)], [-1.5, -3.0]);
        assert!(!actor.is_in_path(&actor.at(2.5)) && actor.is_in_path(&actor.at(3.5)));
    }

    #[test]
    fn a_fixed_number_is_the_one_that_its_digits_stand_for() {
        for number in (0..1_000).map(|number| f64::from(number) / 7.0 - 30.0) {
            for decimals in 1..=3 {
                let text = format!("{number:.*}", decimals as usize);
                assert_eq!(text.parse(), Ok(fixed(number, decimals)), "{number}");
            }
        }
    }
}
