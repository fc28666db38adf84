//! A scenario that was driven, for the figures of a paper.

use frame::batch::{self, Done};
use report::RunPicture;
use report::summary::Summary;
use scenario::Scenario;
use supervise::{Drive, DriveStep, Error, GroupOptions, ScenarioOptions};

/// A scenario that was driven in lockstep.
pub struct Driven {
    /// The scenario as it took effect.
    pub scenario: Scenario,
    pub drive: Drive,
    pub summary: Summary,
    /// Names of the law's figures in the drive.
    pub figure_names: Vec<&'static str>,
}

impl Driven {
    /// Drives a built-in scenario with these keys set, in this thread.
    pub fn alone(name: &str, keys: &[&str]) -> Result<Self, Error> {
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 10.0, processes: false };
        let scenario = open(name, keys)?;
        let done = batch::lockstep(&scenario, &group, &|| true)?;
        batch::whole(&done.summary)?;
        Ok(Self::of(scenario, done))
    }

    pub(crate) fn of(scenario: Scenario, done: Done) -> Self {
        let figure_names = controller::laws::figure_names(&scenario);
        Self { scenario, drive: done.drive, summary: done.summary, figure_names }
    }

    /// One of the law's figures over the control cycles: (time in s, value).
    pub fn figure(&self, name: &str) -> Vec<(f64, f64)> {
        let index = self.figure_names.iter().position(|figure| *figure == name);
        let index = index.expect("the law has a figure of this name");
        self.points(|step| Some(step.figures?[index]))
    }

    /// A value over time, where it is known.
    pub fn points(&self, value: impl Fn(&DriveStep) -> Option<f64>) -> Vec<(f64, f64)> {
        self.drive.steps.iter().filter_map(|step| Some((step.time_s, value(step)?))).collect()
    }

    /// Its picture, under the scenario's and the controller's names.
    pub fn picture(&self) -> (String, RunPicture) {
        let scenario = &self.scenario;
        let name = format!("{} · {}", scenario.name.as_str(), scenario.controller.name.as_str());
        (name, RunPicture::of_drive(scenario, &self.drive))
    }
}

pub(crate) fn open(name: &str, keys: &[&str]) -> Result<Scenario, Error> {
    let set = keys.iter().map(ToString::to_string).collect();
    supervise::open(name, &ScenarioOptions { set, ..ScenarioOptions::default() })
}
