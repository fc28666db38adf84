//! What is counted and kept of the cases.

use frame::batch::ProcessesSample;
use std::collections::BTreeMap;

use crate::Model;
use serde::Serialize;

use super::limits::{Limit, are_few};

/// The whole, as `--json` prints it.
#[derive(Debug, Serialize)]
pub struct Results {
    /// Version of this form.
    pub schema_version: u32,
    /// Whether every law with the emergency brake holds its limits.
    pub ok: bool,
    /// The matrices.
    pub matrices: Vec<MatrixResult>,
    /// The runs that were repeated in process groups.
    pub processes_sample: ProcessesSample,
}

/// A matrix, or a part of it.
#[derive(Debug, Serialize)]
pub struct MatrixResult {
    /// Name of the matrix.
    pub matrix: &'static str,
    /// The figures over all its cases.
    #[serde(flatten)]
    pub all: Figures,
    /// The same of its parts, by name; empty if it has none.
    pub parts: BTreeMap<&'static str, Figures>,
}

/// Figures over some cases.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// Number of cases.
    pub cases: u32,
    /// Collisions of both kinds with each model; null where the model says nothing.
    pub models: BTreeMap<&'static str, Option<u32>>,
    /// The rear-end ones among them.
    pub models_rear_end: BTreeMap<&'static str, Option<u32>>,
    /// Cases in which both models of the regulation end without a collision.
    pub mastered_by_both: u32,
    /// The control laws.
    pub laws: Vec<LawResult>,
    /// What a law with the emergency brake has to hold over these cases.
    #[serde(skip)]
    pub limits: &'static [Limit],
}

/// A law over some cases.
#[derive(Debug, Serialize)]
pub struct LawResult {
    /// Its name.
    pub law: String,
    /// With the emergency brake.
    pub aebs: bool,
    /// Collisions of both kinds.
    pub collisions: u32,
    /// The rear-end ones among them.
    pub rear_end: u32,
    /// Collisions in cases that a model masters.
    pub avoidable: Avoidable,
    /// What `careful-driver` does from the gap that the law keeps; null where there are no cut-outs.
    pub from_its_gap: Option<FromItsGap>,
    /// Mean speed difference at the contact over the collisions, m/s; null without one.
    pub mean_impact_mps: Option<f64>,
    /// The same of `regulation`, or of `careful-driver` where that says nothing, over the same cases.
    pub model_impact_mps: Option<f64>,
}

/// Collisions in cases that a model masters.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Avoidable {
    /// `careful-driver`.
    pub careful_driver: u32,
    /// `regulation`; null where it says nothing.
    pub regulation: Option<u32>,
    /// Both of them.
    pub both: u32,
    /// Those of `both` in which a contact at constant speeds lasts for less than a step of the models, which
    /// they may not see; null where there are no cut-ins.
    pub both_within_a_step: Option<u32>,
}

/// `careful-driver` from the gap that a law keeps.
#[derive(Debug, Serialize)]
pub struct FromItsGap {
    /// Its collisions.
    pub collisions: u32,
    /// Cases that it ends without one.
    pub mastered: u32,
    /// Collisions of the law in those.
    pub avoidable: u32,
}

impl MatrixResult {
    /// Whether every law holds its limits, over the whole and in each part.
    pub fn holds(&self) -> bool {
        let mut all = self.parts.values().chain([&self.all]);
        all.all(|figures| figures.laws.iter().all(|law| figures.holds(law)))
    }
}

impl Figures {
    /// Whether `law` holds all its limits over these cases.
    pub fn holds(&self, law: &LawResult) -> bool {
        self.limits.iter().all(|limit| self.holds_limit(law, *limit) != Some(false))
    }

    /// Whether `law` holds `limit`; `None` where that does not apply: to other cases, or to a law without the
    /// emergency brake.
    pub fn holds_limit(&self, law: &LawResult, limit: Limit) -> Option<bool> {
        if !(law.aebs && self.limits.contains(&limit)) {
            return None;
        }
        match limit {
            Limit::MasteredByBoth => Some(are_few(law.avoidable.both, self.mastered_by_both)),
            Limit::ThirdOfRegulation => {
                let regulation = self.models[Model::Regulation.name()]?;
                Some(3 * law.collisions <= regulation)
            }
            Limit::NoCollision => Some(law.collisions == 0),
            Limit::MasteredFromItsGap => {
                law.from_its_gap.as_ref().map(|model| are_few(model.avoidable, model.mastered))
            }
        }
    }
}
