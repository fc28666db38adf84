//! The cars of a string, driven one after another: by the study, or by a caller with laws of its own.

use super::measure::measure;
use super::motion::Motion;
use super::results::Results;
use super::scene::{Place, Plan};
use super::wave::Driven;
use report::summary::Summary;
use scenario::Scenario;
use serde_json::Value;
use supervise::{Drive, UsageError};

const TRACE_POINTS: usize = 400;

/// A string of which some cars were driven.
///
/// ```
/// use string::CarByCar;
///
/// let options = supervise::ScenarioOptions { duration: Some(3.into()), ..Default::default() };
/// let laws = vec![supervise::open("following", &options).expect("built in")];
/// let mut string = CarByCar::new(laws, 2);
/// while let Some(scenario) = string.next().expect("a short string") {
///     let outcome = supervise::in_process::run_watched(&scenario, runtime::Sealing::Unsealed, &|| false, &mut |_| {}).expect("it drives");
///     let wall = std::time::Duration::from_millis(1);
///     let summary = report::summary::Summary::new(&scenario, runtime::Mode::Lockstep, &outcome, wall);
///     string.drove(&scenario, &summary, &outcome.drive);
/// }
/// assert_eq!(string.results()["vehicles"].as_array().map(Vec::len), Some(2));
/// ```
#[derive(Debug)]
pub struct CarByCar {
    plan: Plan,
    places: Vec<Place>,
    pub(crate) cars: Vec<Driven>,
    last: Option<Motion>,
}

impl CarByCar {
    /// A string of `vehicles` cars; the scenarios, one a law, are repeated along it. There must be one.
    pub fn new(laws: Vec<Scenario>, vehicles: usize) -> Self {
        assert!(!laws.is_empty(), "a string has a law");
        Self::of(Plan { laws, vehicles, wave: None })
    }

    pub(crate) fn of(plan: Plan) -> Self {
        Self { places: plan.places(), plan, cars: Vec::new(), last: None }
    }

    /// The scenario of the next car; `None` when all were driven.
    pub fn next(&self) -> Result<Option<Scenario>, UsageError> {
        match (self.places.get(self.cars.len()), &self.last) {
            (None, _) => Ok(None),
            (Some(_), None) => Ok(Some(self.plan.first())),
            (Some(place), Some(motion)) => self.plan.behind(*place, motion).map(Some),
        }
    }

    /// Takes the drive of the car that was next.
    pub fn drove(&mut self, scenario: &Scenario, summary: &Summary, drive: &Drive) {
        let Some(place) = self.places.get(self.cars.len()) else { return };
        self.last = Some(Motion::of(scenario, drive, summary.outcome));
        self.cars.push(Driven {
            index: place.index + 1,
            controller: summary.controller.clone(),
            outcome: summary.outcome,
            requirements: summary.requirements.clone(),
            figures: summary.control.figures.clone(),
            measured: measure(scenario, drive),
            amplitudes: self.plan.wave.and_then(|wave| wave.amplitudes(drive)),
            trace: if self.plan.wave.is_some() { Vec::new() } else { trace(drive, place) },
        });
    }

    /// The results of the cars that were driven, as the command's JSON.
    pub fn results(&self) -> Value {
        let results = Results::new(&self.plan, &self.cars, Vec::new(), Vec::new());
        serde_json::to_value(&results).expect("results are plain data")
    }
}

/// Evenly spread steps of a drive, and its last one.
fn trace(drive: &Drive, place: &Place) -> Vec<[f64; 3]> {
    let stride = drive.steps.len().div_ceil(TRACE_POINTS).max(1);
    let last = drive.steps.len().saturating_sub(1);
    let kept = drive.steps.iter().enumerate().filter(|(k, _)| k % stride == 0 || *k == last);
    kept.map(|(_, step)| [step.time_s, step.position_m - place.behind_first_m, step.speed_mps])
        .collect()
}
