//! A string whose caller drives its cars, one after another: with laws of the caller's own, too.

use frame::batch::{Done, ProcessesSample};
use group::Drive;
use report::summary::Summary;
use scenario::Scenario;
use serde_json::Value;

use super::driven::Driven;
use super::motion::Motion;
use super::results::Results;
use super::scene::{Plan, SceneError};

/// A string of which some cars were driven.
///
/// ```
/// use frame::batch;
/// use string::CarByCar;
///
/// let options = group::ScenarioOptions { duration: Some("3".into()), ..Default::default() };
/// let laws = vec![group::open("following", &options).expect("built in")];
/// let mut string = CarByCar::new(laws, 2);
/// while let Some(scenario) = string.next().expect("a short string") {
///     let outcome = group::in_process::run_unsealed(&scenario, &|| false).expect("it drives");
///     let wall = std::time::Duration::from_millis(1);
///     let summary = report::summary::Summary::new(&scenario, runtime::Mode::Lockstep, &outcome, wall);
///     string.drove(&scenario, &summary, outcome.drive);
/// }
/// assert_eq!(string.results()["vehicles"].as_array().map(Vec::len), Some(2));
/// ```
#[derive(Debug)]
pub struct CarByCar {
    plan: Plan,
    cars: Vec<Driven>,
    last: Option<Motion>,
}

impl CarByCar {
    /// A string of `vehicles` cars; the scenarios, one a law, are repeated along it. There must be one.
    #[must_use]
    pub fn new(laws: Vec<Scenario>, vehicles: usize) -> Self {
        assert!(!laws.is_empty(), "a string has a law");
        Self { plan: Plan { laws, vehicles, wave: None }, cars: Vec::new(), last: None }
    }

    /// The scenario of the next car; none when all were driven.
    ///
    /// # Errors
    /// If the string is too long for its road.
    pub fn next(&self) -> Result<Option<Scenario>, SceneError> {
        let Some(place) = self.plan.places().into_iter().nth(self.cars.len()) else {
            return Ok(None);
        };
        match &self.last {
            None => Ok(Some(self.plan.first())),
            Some(motion) => self.plan.behind(place, motion).map(Some),
        }
    }

    /// Takes the drive of the car that was next.
    pub fn drove(&mut self, scenario: &Scenario, summary: &Summary, drive: Drive) {
        let Some(place) = self.plan.places().into_iter().nth(self.cars.len()) else { return };
        self.last = Some(Motion::of(scenario, &drive, summary.outcome));
        let done = Done {
            summary: summary.clone(),
            drive,
            leftovers: Vec::new(),
            samples: Vec::new(),
            repetition: None,
        };
        self.cars.push(Driven::of(&self.plan, place, scenario, &done));
    }

    /// The results of the cars that were driven, as the command's JSON.
    ///
    /// # Panics
    /// Never: results are plain data.
    #[must_use]
    pub fn results(&self) -> Value {
        let sample = ProcessesSample::default();
        let results = Results::new(&self.plan, &self.cars, Vec::new(), Vec::new(), sample);
        serde_json::to_value(&results).expect("results are plain data")
    }
}
