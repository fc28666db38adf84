//! Counts over the cases.

use std::collections::BTreeMap;

use crate::Model;
use serde::Serialize;

use super::limits::{COLLISIONS_OF_REGULATION, Limit, are_few};

/// The whole, as `--json` prints it.
#[derive(Debug, Serialize)]
pub struct Results {
    /// Version of this form.
    pub schema_version: u32,
    /// True if every law with the emergency brake holds its limits.
    pub ok: bool,
    /// The matrices.
    pub matrices: Vec<MatrixResult>,
}

/// A matrix, or a part of it.
#[derive(Debug, Serialize)]
pub struct MatrixResult {
    /// Name of the matrix.
    pub matrix: &'static str,
    /// The figures over all its cases.
    #[serde(flatten)]
    pub all: Figures,
    /// Figures of its parts, by name; empty without parts.
    pub parts: BTreeMap<&'static str, Figures>,
}

/// Figures over some cases.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// Number of cases.
    pub cases: u32,
    /// Collisions of both kinds with each model; null where the model covers no case.
    pub models: BTreeMap<&'static str, Option<u32>>,
    /// The rear-end ones among them.
    pub models_rear_end: BTreeMap<&'static str, Option<u32>>,
    /// Cases in which both models of the regulation end without a collision.
    pub mastered_by_both: u32,
    /// The control laws.
    pub laws: Vec<LawResult>,
    /// Limits over these cases.
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
    /// Figures of `careful-driver` from the law's gap; null without cut-outs.
    pub from_its_gap: Option<FromItsGap>,
    /// Cases in which it broke a requirement of the command; null without one.
    pub requirements_broken: Option<u32>,
    /// Mean speed difference at the contact over the collisions, m/s; null without one.
    pub mean_impact_mps: Option<f64>,
    /// The same figure of `regulation`, else of `careful-driver`, over the same cases.
    pub model_impact_mps: Option<f64>,
}

/// Collisions in cases that a model masters.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Avoidable {
    /// `careful-driver`.
    pub careful_driver: u32,
    /// `regulation`; null where it covers no case.
    pub regulation: Option<u32>,
    /// Both of them.
    pub both: u32,
    /// Collisions of `both` in cases whose contact at constant speeds is shorter than a step of the models. The models
    /// may miss it; null without cut-ins.
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

impl LawResult {
    /// The law, with or without the emergency brake.
    pub fn driver(&self) -> String {
        let with = if self.aebs { " + AEBS" } else { "" };
        format!("{}{with}", self.law)
    }
}

/// A number of cases and its share of `all`.
fn share(count: u32, all: u32) -> String {
    if all == 0 {
        return count.to_string();
    }
    format!("{count} of {all}, {:.2} %", 100.0 * f64::from(count) / f64::from(all))
}

impl MatrixResult {
    /// True if every law holds its limits, over the whole and in each part.
    pub fn holds(&self) -> bool {
        let mut all = self.parts.values().chain([&self.all]);
        all.all(|figures| figures.laws.iter().all(|law| figures.holds(law)))
    }

    /// Cases with a requirement of the command that a law broke, over all laws.
    pub fn requirements_broken(&self) -> u32 {
        self.all.laws.iter().filter_map(|law| law.requirements_broken).sum()
    }
}

impl Figures {
    /// The criterion of these cases, and the laws beyond it, with and without the emergency brake. `None` where no
    /// limit stands.
    pub fn criterion(&self) -> Option<String> {
        let words: Vec<_> = self.limits.iter().map(|limit| limit.criterion()).collect();
        if words.is_empty() || self.laws.is_empty() {
            return None;
        }
        let beyond = |aebs: bool| {
            let laws = self.laws.iter().filter(|law| law.aebs == aebs && !self.is_within(law));
            let named = laws.map(|law| format!("{} ({})", law.driver(), self.blamed(law)));
            let named: Vec<_> = named.collect();
            if named.is_empty() {
                "every law is within it".to_owned()
            } else {
                named.join(", ") + " beyond it"
            }
        };
        let criterion = words.join("; ");
        let (with, alone) = (beyond(true), beyond(false));
        Some(format!("criterion: {criterion}. With the emergency brake {with}; alone {alone}"))
    }

    /// The collisions that break the limits of a law.
    fn blamed(&self, law: &LawResult) -> String {
        let broken = self.limits.iter().find(|limit| self.holds_limit(law, **limit) == Some(false));
        match (broken, &law.from_its_gap) {
            (Some(Limit::MasteredByBoth), _) => share(law.avoidable.both, self.mastered_by_both),
            (Some(Limit::MasteredFromItsGap), Some(model)) => {
                share(model.avoidable, model.mastered)
            }
            _ => format!("{} of {} collide", law.collisions, self.cases),
        }
    }

    /// True if `law` holds all that it has to: a law alone has no limit.
    pub fn holds(&self, law: &LawResult) -> bool {
        !law.aebs || self.is_within(law)
    }

    /// True if `law` is within all limits, alone too.
    pub fn is_within(&self, law: &LawResult) -> bool {
        self.limits.iter().all(|limit| self.holds_limit(law, *limit) != Some(false))
    }

    /// True if `law` is within `limit`; `None` where that does not apply to these cases.
    pub fn holds_limit(&self, law: &LawResult, limit: Limit) -> Option<bool> {
        if !self.limits.contains(&limit) {
            return None;
        }
        match limit {
            Limit::MasteredByBoth => Some(are_few(law.avoidable.both, self.mastered_by_both)),
            Limit::ThirdOfRegulation => {
                let regulation = self.models[Model::Regulation.name()]?;
                Some(COLLISIONS_OF_REGULATION * law.collisions <= regulation)
            }
            Limit::NoCollision => Some(law.collisions == 0),
            Limit::MasteredFromItsGap => {
                law.from_its_gap.as_ref().map(|model| are_few(model.avoidable, model.mastered))
            }
        }
    }
}
