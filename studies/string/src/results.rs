//! The result of a string of cars.

use super::STABLE_GAIN;
use super::limits::{Limits, Point};
use super::scene::Plan;
use super::wave::{Driven, Response, peak};
use report::figures::{MAX_ABS_JERK_MPS3, MIN_GAP_M};
use report::print::{counted, outcome_word};
use report::results::{Column, Object, Schema, Table, count, flag, judged, number, value, word};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;
use supervise::RequirementVerdict;
use supervise::report::{ControlFigures, Outcome};

/// Name of the requirement that the string as a whole is judged by.
pub const STABILITY: &str = "string-stable";

/// The results of the command.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Results {
    schema_version: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Laws, in the order in which they are repeated along the string.
    pub controllers: Vec<String>,
    /// Seed of the first car; each of the others has its own.
    pub seed: u64,
    /// Length of the scenario, s.
    pub duration_s: f64,
    /// The cars, first to last.
    pub vehicles: Vec<Vehicle>,
    /// Norm of the last car's speed over the norm of the speed of the vehicle ahead of the first.
    pub head_to_tail_gain: Option<f64>,
    /// The same of the largest deviations.
    pub head_to_tail_gain_max: Option<f64>,
    /// Smallest gap of all cars, m.
    pub min_gap_m: Option<f64>,
    /// No car amplifies: no frequency where there are some, else not the scenario's disturbance.
    pub string_stable: bool,
    /// Verdict on `string-stable`, if it is required.
    #[schemars(with = "Option<Object>")]
    pub stability: Option<RequirementVerdict>,
    /// The highest point of the gain curve.
    pub peak: Option<Peak>,
    /// The string behind a sine of each frequency.
    pub frequencies: Vec<Response>,
    /// Limit of string stability of each law.
    pub limits: Vec<Limits>,
}

/// The highest point of a gain curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Peak {
    /// Frequency, Hz.
    pub hz: f64,
    /// Gain.
    pub gain: f64,
}

/// The drive of one car in results.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Vehicle {
    /// Place in the string, from 1.
    pub index: usize,
    /// Its law.
    pub controller: String,
    /// End of its drive.
    #[schemars(with = "String")]
    pub outcome: Outcome,
    /// Verdicts on the requirements.
    #[schemars(with = "Vec<Object>")]
    pub requirements: Vec<RequirementVerdict>,
    /// A car ahead of it collided: the vehicle before it braked to a stand.
    pub behind_collision: bool,
    /// Norm of its speed over that of the vehicle ahead.
    pub speed_gain_l2: Option<f64>,
    /// The same of the largest deviations.
    pub speed_gain_max: Option<f64>,
    /// Norm of its gap error over that of the car before it.
    pub gap_error_gain_l2: Option<f64>,
    /// The same of the largest errors.
    pub gap_error_gain_max: Option<f64>,
    /// Smallest gap, m.
    pub min_gap_m: Option<f64>,
    /// Largest gap error, m.
    pub max_abs_gap_error_m: Option<f64>,
    /// Largest magnitude of the jerk, m/s³.
    pub max_abs_jerk_mps3: Option<f64>,
    /// Root mean square of the jerk, m/s³.
    pub rms_jerk_mps3: Option<f64>,
}

impl Vehicle {
    /// The drive was not cut short; a requirement is judged after it.
    pub fn reached_the_end(&self) -> bool {
        matches!(self.outcome, Outcome::Completed | Outcome::RequirementBroken)
    }
}

impl Results {
    /// The results judged by `string-stable` as well: the limit of the gain minus the largest one.
    pub fn judged_by_stability(self) -> Self {
        let of_cars = self.vehicles.iter().filter_map(|car| car.speed_gain_l2).reduce(f64::max);
        let largest = match self.frequencies.as_slice() {
            [] => of_cars,
            _ => self.peak.map(|peak| peak.gain),
        };
        let verdict = RequirementVerdict {
            requirement: STABILITY.to_owned(),
            formula: format!("{STABLE_GAIN} minus the largest gain of a car"),
            margin: largest.map(|gain| STABLE_GAIN - gain),
            unit: "1".to_owned(),
            at_s: 0.0,
            met: self.string_stable,
        };
        Self { stability: Some(verdict), ..self }
    }

    /// Every requirement holds, of each car and of the string.
    pub fn meets_requirements(&self) -> bool {
        let of_cars = self.vehicles.iter().flat_map(|vehicle| &vehicle.requirements);
        of_cars.chain(&self.stability).all(|verdict| verdict.met)
    }

    /// Makes the result of the driven cars.
    pub fn new(
        plan: &Plan,
        cars: &[Driven],
        frequencies: Vec<Response>,
        limits: Vec<Limits>,
    ) -> Self {
        let vehicles = vehicles(cars);
        let whole = vehicles.iter().all(Vehicle::reached_the_end);
        let ends = cars.first().zip(cars.last()).filter(|_| whole);
        let (head_to_tail_gain, head_to_tail_gain_max) = ends
            .and_then(|(first, last)| Some(last.measured.speed?.over(first.measured.ahead)))
            .unwrap_or_default();
        let amplifies = |vehicle: &Vehicle| vehicle.speed_gain_l2.is_some_and(|g| g > STABLE_GAIN);
        let peak = peak(&frequencies).map(|(hz, gain)| Peak { hz, gain });
        let string_stable = whole
            && match frequencies.as_slice() {
                [] => !vehicles.iter().any(amplifies),
                _ => peak.is_some_and(|peak| peak.gain <= STABLE_GAIN),
            };
        let first = &plan.laws[0];
        Self {
            schema_version: 1,
            scenario: first.name.as_str().to_owned(),
            controllers: plan
                .laws
                .iter()
                .map(|scenario| scenario.controller.name.as_str().to_owned())
                .collect(),
            seed: plan.seed(),
            duration_s: first.duration_s.value(),
            min_gap_m: vehicles.iter().filter_map(|vehicle| vehicle.min_gap_m).reduce(f64::min),
            vehicles,
            head_to_tail_gain,
            head_to_tail_gain_max,
            string_stable,
            stability: None,
            peak,
            frequencies,
            limits,
        }
    }

    pub fn verdict(&self) -> String {
        let mut measured = self.vehicles.iter().filter(|car| car.speed_gain_l2.is_some());
        let is_measured = self.peak.is_some() || measured.next().is_some();
        let stable = match self.string_stable {
            true if is_measured => "string stable",
            true => "string stable, with no disturbance to amplify",
            false => "NOT string stable",
        };
        let peak = self.peak.map_or_else(String::new, |peak| {
            format!(", peak gain {:.3} at {:.4} Hz", peak.gain, peak.hz)
        });
        let collided = |car: &&Vehicle| car.outcome == Outcome::Collision;
        let collisions = match self.vehicles.iter().filter(collided).count() {
            0 => String::new(),
            count => format!(", {} collided", counted(count as u64, "car")),
        };
        let head_to_tail = self
            .head_to_tail_gain
            .map_or_else(String::new, |gain| format!(", head-to-tail gain {gain:.3}"));
        let broken = if self.meets_requirements() { "" } else { ", a requirement is BROKEN" };
        format!("{stable}{peak}{head_to_tail}{collisions}{broken}")
    }
}

fn vehicles(cars: &[Driven]) -> Vec<Vehicle> {
    let mut before: Option<&Driven> = None;
    let mut behind_collision = false;
    let mut vehicles = Vec::with_capacity(cars.len());
    for car in cars {
        let measured = &car.measured;
        let speed = measured.speed.map(|speed| speed.over(measured.ahead)).unwrap_or_default();
        let gap_before = before.and_then(|before| before.measured.gap_error);
        let gap = measured.gap_error.map(|error| error.over(gap_before)).unwrap_or_default();
        let ControlFigures { min_gap_m, max_abs_jerk_mps3, rms_jerk_mps3, .. } = car.figures;
        vehicles.push(Vehicle {
            index: car.index,
            controller: car.controller.clone(),
            outcome: car.outcome,
            requirements: car.requirements.clone(),
            behind_collision,
            speed_gain_l2: speed.0,
            speed_gain_max: speed.1,
            gap_error_gain_l2: gap.0,
            gap_error_gain_max: gap.1,
            min_gap_m,
            max_abs_gap_error_m: measured.gap_error.map(|error| error.max),
            max_abs_jerk_mps3,
            rms_jerk_mps3,
        });
        behind_collision |= car.outcome == Outcome::Collision;
        before = Some(car);
    }
    vehicles
}

/// Most cars that a terminal shows.
const MOST_CARS: usize = 16;

const CARS: &[Column<Vehicle>] = &[
    count("index", "car", "Place in the string, from 1"),
    word("controller", "law", "Control law"),
    number("speed_gain_l2", "speed L2", "", 3, "Norm of its speed over that of the vehicle ahead")
        .limit(STABLE_GAIN),
    number("speed_gain_max", "speed max", "", 3, "The same of the largest deviations")
        .limit(STABLE_GAIN)
        .weight(2),
    number(
        "gap_error_gain_l2",
        "gap error L2",
        "",
        3,
        "Norm of its gap error over that of the car before",
    )
    .limit(STABLE_GAIN)
    .weight(1),
    number("gap_error_gain_max", "gap error max", "", 3, "The same of the largest errors")
        .limit(STABLE_GAIN)
        .weight(2),
    MIN_GAP_M.column(),
    MAX_ABS_JERK_MPS3.column(),
    judged("", "outcome", "How the drive ended").of(|car| {
        let after = if car.behind_collision { ", behind a collision" } else { "" };
        let text = format!("{}{after}", outcome_word(car.outcome));
        json!({"text": text, "ok": car.outcome == Outcome::Completed})
    }),
    word("", "requirements", "Margins of the requirements")
        .of(|car| json!(report::verdicts::words(&car.requirements))),
];

const CURVE: &[Column<Response>] = &[
    number("hz", "frequency", "Hz", 4, "Frequency of the lead's sine"),
    number("gain", "gain", "", 3, "Largest gain from one car to the next").limit(STABLE_GAIN),
    number("head_to_tail_gain", "head to tail", "", 3, "Gain from the lead to the last car"),
];

/// Columns of the values of a swept key.
const POINTS: &[Column<Point>] = &[
    value("value", "", "Value of the key"),
    number("peak_gain", "peak gain", "", 3, "Largest gain at any frequency").limit(STABLE_GAIN),
    number("peak_hz", "at", "Hz", 4, "Frequency of the largest gain"),
    flag("string_stable", "", ("stable", "unstable"), "No frequency is amplified"),
];

/// Contents of the JSON.
pub fn schema() -> Schema {
    Schema::of::<Results>("string")
}

pub fn cars(results: &Results) -> Table {
    Table::new("Cars", CARS, &results.vehicles).most_rows(MOST_CARS)
}

pub fn curve(results: &Results) -> Table {
    Table::new("Behind a sine of the lead's speed", CURVE, &results.frequencies).without_cases()
}

/// A law over the values of a key.
pub fn limit(limits: &Limits) -> Table {
    let mut columns = POINTS.to_vec();
    columns[0].head.heading = limits.key.clone().into();
    Table::new(&limits.controller, &columns, &limits.points).without_cases()
}
