//! Cut-in: a slower vehicle beside the ego comes into its lane.
//!
//! Its lateral speed rises by 1.5 m/s² and stays until it is centred. The distance of the case holds at the instant
//! when the lateral speed is reached, 1.6 m beside the ego.

use crate::contact::{Travel, contact};
use crate::{Driver, Model, STEP_S, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, Verdict, View, mps};

/// Clearance at the instant of the case's distance \[m\]: both vehicles centred in lanes of 3.5 m.
pub const CLEARANCE_M: f64 = 1.6;

/// Speed of the ego up to which a case belongs to the low matrix \[km/h\].
pub const LOW_UP_TO_KMH: u32 = 60;

pub const LATERAL_ACCELERATION_MPS2: f64 = 1.5;

/// Lateral speeds in tenths \[0.1 m/s\].
pub const LATERAL_TENTHS_MPS: std::ops::Range<u32> = 0..18;

/// The slowest cut-in reaches the middle of the lane after 35 s.
const LONGEST_S: f64 = 60.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Case {
    pub ego_kmh: u32,
    /// Speed of the other, below the ego's \[km/h\].
    pub other_kmh: u32,
    /// Distance from bumper to bumper when the lateral speed is reached \[m\].
    pub distance_m: u32,
    /// Lateral speed in tenths \[0.1 m/s\].
    pub lateral_tenths_mps: u32,
}

impl Case {
    pub fn lateral_mps(&self) -> f64 {
        f64::from(self.lateral_tenths_mps) * 0.1
    }

    /// End of the case when `model` drives the ego.
    pub fn drive(&self, model: Model) -> Verdict {
        let other_mps = mps(self.other_kmh);
        let mut speed_mps = mps(self.ego_kmh);
        let mut lateral = LateralMotion::new(self.lateral_mps());
        let closed_m = (speed_mps - other_mps) * STEP_S * f64::from(lateral.rising_steps);
        let mut ego = Travel::from_m(0.0);
        let mut other = Travel::from_m(f64::from(self.distance_m) + VEHICLE_LENGTH_M + closed_m);
        let mut driver = Driver::beside(model);
        for _ in 0..(LONGEST_S / STEP_S) as u32 {
            let view = View {
                gap_m: other.gap_to_m(&ego),
                other_speed_mps: other_mps,
                clearance_m: lateral.clearance_m(),
                lateral_speed_mps: lateral.speed_mps(),
            };
            speed_mps = driver.step(speed_mps, Some(&view));
            if driver.needs_no_reaction() {
                return Verdict::NONE;
            }
            ego.step(speed_mps);
            other.step(other_mps);
            lateral.step();
            let gap_m = other.gap_to_m(&ego);
            let outcome = contact(gap_m, lateral.clearance_m());
            if outcome.is_collision() {
                return Verdict { outcome, impact_speed_mps: speed_mps - other_mps };
            }
            if gap_m <= -2.0 * VEHICLE_LENGTH_M {
                return Verdict::NONE;
            }
        }
        Verdict::NONE
    }

    /// True if at constant speeds the contact is shorter than a step of the models, which may miss it.
    pub fn ends_within_a_step(&self) -> bool {
        let closing_mps = mps(self.ego_kmh) - mps(self.other_kmh);
        let passed_s = (f64::from(self.distance_m) + 2.0 * VEHICLE_LENGTH_M) / closing_mps;
        (0.0..=STEP_S).contains(&(passed_s - CLEARANCE_M / self.lateral_mps()))
    }
}

/// The cases up to 60 km/h, in the order of the tables: 15,930.
pub fn low() -> impl Iterator<Item = Case> {
    (10..=LOW_UP_TO_KMH).step_by(10).flat_map(|ego_kmh| grids(ego_kmh, 10))
}

/// The cases from 70 to 130 km/h, in the order of the tables: 14,040.
pub fn high() -> impl Iterator<Item = Case> {
    [70, 90, 110, 130].into_iter().flat_map(|ego_kmh| grids(ego_kmh, 30))
}

/// Distances of the cases at a speed of the ego, and between two of them \[m\].
pub fn distances_m(ego_kmh: u32) -> (impl Iterator<Item = u32> + Clone, usize) {
    let (end_m, step_m) = if ego_kmh <= LOW_UP_TO_KMH { (60, 1) } else { (120, 2) };
    ((1..end_m).step_by(step_m), step_m)
}

/// The cases at a speed of the ego. The other's is from 10 km/h in steps of `step_kmh` below it.
fn grids(ego_kmh: u32, step_kmh: usize) -> impl Iterator<Item = Case> {
    (10..ego_kmh).step_by(step_kmh).flat_map(move |other_kmh| {
        distances_m(ego_kmh).0.flat_map(move |distance_m| {
            LATERAL_TENTHS_MPS.map(move |lateral_tenths_mps| Case {
                ego_kmh,
                other_kmh,
                distance_m,
                lateral_tenths_mps,
            })
        })
    })
}

/// The other's way from the side to the middle of the ego's lane. A step moves with the speed at its beginning.
#[derive(Clone, Debug)]
struct LateralMotion {
    final_mps: f64,
    rising_steps: u32,
    steps: u32,
    /// From where the lateral speed is reached.
    travel: Travel,
}

/// Gain of the lateral speed in a step \[m/s\].
const GAIN_MPS: f64 = 0.15;

impl LateralMotion {
    fn new(final_mps: f64) -> LateralMotion {
        let rising_steps = (final_mps / GAIN_MPS).ceil() as u32;
        let rising_mps: f64 = (0..rising_steps).map(|step| speed_at_mps(step, final_mps)).sum();
        let travel = Travel { start_m: 0.0, speeds_mps: -rising_mps };
        LateralMotion { final_mps, rising_steps, steps: 0, travel }
    }

    fn step(&mut self) {
        self.travel.step(self.speed_mps());
        self.steps += 1;
    }

    /// Between the sides of the two vehicles \[m\].
    fn clearance_m(&self) -> f64 {
        (CLEARANCE_M - self.travel.position_m()).max(-VEHICLE_WIDTH_M)
    }

    fn speed_mps(&self) -> f64 {
        let is_centred = self.clearance_m() <= -VEHICLE_WIDTH_M;
        if is_centred { 0.0 } else { speed_at_mps(self.steps, self.final_mps) }
    }
}

fn speed_at_mps(step: u32, final_mps: f64) -> f64 {
    (GAIN_MPS * f64::from(step)).min(final_mps)
}
