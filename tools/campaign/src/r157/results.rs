//! What is counted and kept of the cases.

use crate::batch::ProcessesSample;
use std::collections::BTreeMap;

use regulation::{Model, Outcome, PerModel, Tally, Verdict, is_mastered_by_both};
use serde::Serialize;

use super::drive::Driver;
use super::matrix::{Case, Matrix};

/// Share of the cases that both models master in which a law with the emergency brake may collide.
const AVOIDABLE_SHARE: f64 = 0.005;

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
    /// A law with the emergency brake may not collide at all.
    #[serde(skip)]
    pub allows_none: bool,
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

/// The verdicts of the models and of each driver over the cases of a matrix.
#[derive(Debug)]
pub struct Judged {
    /// The matrix.
    pub matrix: Matrix,
    /// The cases.
    pub cases: Vec<Case>,
    /// The models' verdicts, case by case.
    pub models: Vec<PerModel<Option<Verdict>>>,
    /// Each driver's verdicts, case by case.
    pub laws: Vec<(Driver, Vec<Verdict>)>,
}

impl Judged {
    /// The cases with the models' verdicts.
    pub fn new(matrix: Matrix, cases: Vec<Case>) -> Self {
        let models = cases.iter().map(Case::verdicts).collect();
        Self { matrix, cases, models, laws: Vec::new() }
    }

    /// The matrix's figures.
    pub fn result(&self) -> MatrixResult {
        let parts = self.matrix.parts();
        let parts = if parts.len() > 1 { parts } else { &[] };
        MatrixResult {
            matrix: self.matrix.name(),
            all: self.figures(&|_| true),
            parts: parts.iter().map(|(name, holds)| (*name, self.figures(holds))).collect(),
        }
    }

    fn figures(&self, holds: &dyn Fn(&Case) -> bool) -> Figures {
        let chosen: Vec<usize> =
            (0..self.cases.len()).filter(|&index| holds(&self.cases[index])).collect();
        let mut tally = Tally::default();
        for &index in &chosen {
            tally.count(&self.models[index]);
        }
        let speaks = |model| chosen.iter().any(|&index| self.models[index][model].is_some());
        let by_model = |counts: &PerModel<u32>| {
            let count = |model| speaks(model).then_some(counts[model]);
            Model::ALL.into_iter().map(|model| (model.name(), count(model))).collect()
        };
        Figures {
            cases: tally.cases,
            models: by_model(&tally.collisions),
            models_rear_end: by_model(&tally.rear_ends),
            mastered_by_both: tally.mastered_by_both,
            laws: (self.laws.iter())
                .map(|(driver, verdicts)| self.law(driver, verdicts, &chosen))
                .collect(),
            allows_none: self.matrix == Matrix::Following,
        }
    }

    fn law(&self, driver: &Driver, verdicts: &[Verdict], chosen: &[usize]) -> LawResult {
        let collided: Vec<usize> = (chosen.iter().copied())
            .filter(|&index| verdicts[index].outcome.is_collision())
            .collect();
        let count = |holds: &dyn Fn(usize) -> bool| {
            u32::try_from(collided.iter().filter(|&&index| holds(index)).count())
                .expect("a matrix has few cases")
        };
        let masters = |index: usize, model| {
            self.models[index][model].is_some_and(|verdict| !verdict.outcome.is_collision())
        };
        let speaks = |model| chosen.iter().any(|&index| self.models[index][model].is_some());
        let model =
            if speaks(Model::Regulation) { Model::Regulation } else { Model::CarefulDriver };
        LawResult {
            law: driver.law.clone(),
            aebs: driver.aebs,
            collisions: count(&|_| true),
            rear_end: count(&|index| verdicts[index].outcome == Outcome::RearEnd),
            avoidable: Avoidable {
                careful_driver: count(&|index| masters(index, Model::CarefulDriver)),
                regulation: speaks(Model::Regulation)
                    .then(|| count(&|index| masters(index, Model::Regulation))),
                both: count(&|index| is_mastered_by_both(&self.models[index])),
                both_within_a_step: (self.matrix == Matrix::CutIn).then(|| {
                    count(&|index| {
                        is_mastered_by_both(&self.models[index])
                            && self.cases[index].ends_within_a_step()
                    })
                }),
            },
            mean_impact_mps: mean(collided.iter().map(|&index| verdicts[index].impact_speed_mps)),
            model_impact_mps: mean(
                (collided.iter())
                    .filter_map(|&index| self.models[index][model])
                    .map(|verdict| verdict.impact_speed_mps),
            ),
        }
    }
}

impl MatrixResult {
    /// Whether a law with the emergency brake holds its limits in each part; one alone has none.
    pub fn holds(&self) -> bool {
        let parts: Vec<&Figures> =
            if self.parts.is_empty() { vec![&self.all] } else { self.parts.values().collect() };
        parts.iter().all(|part| part.laws.iter().all(|law| part.holds(law)))
    }
}

impl Figures {
    /// Whether `law` holds its limits: in cut-ins (where `regulation` speaks) by the shares of what the
    /// models master and of `regulation`'s collisions, in following without any collision, in cut-outs
    /// without an avoidable one.
    pub fn holds(&self, law: &LawResult) -> bool {
        if !law.aebs {
            return true;
        }
        match self.models[Model::Regulation.name()] {
            Some(regulation) => {
                let most = AVOIDABLE_SHARE * f64::from(self.mastered_by_both);
                f64::from(law.avoidable.both) <= most && 3 * law.collisions <= regulation
            }
            None if self.allows_none => law.collisions == 0,
            None => law.avoidable.both == 0,
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HIT: Verdict = Verdict { outcome: Outcome::RearEnd, impact_speed_mps: 4.0 };

    fn judged(hit: impl Fn(&PerModel<Option<Verdict>>) -> bool) -> MatrixResult {
        let mut judged = Judged::new(Matrix::CutIn, Matrix::CutIn.cases());
        let verdicts =
            judged.models.iter().map(|models| if hit(models) { HIT } else { Verdict::NONE });
        let driver = Driver { law: "acc-mpc".into(), aebs: true };
        judged.laws = vec![(driver, verdicts.collect())];
        judged.result()
    }

    #[test]
    fn a_law_that_collides_where_nothing_could_be_done_holds() {
        let result = judged(|_| false);
        assert_eq!(result.all.cases, 29_970);
        assert_eq!(result.parts["low"].mastered_by_both, 12_124);
        assert_eq!(result.parts["high"].models["regulation"], Some(2869));
        assert!(result.holds());
        assert_eq!(result.all.laws[0].mean_impact_mps, None);
    }

    #[test]
    fn a_law_that_collides_like_the_models_does_not() {
        let by_regulation = |models: &PerModel<Option<Verdict>>| {
            models[Model::Regulation].is_some_and(|verdict| verdict.outcome.is_collision())
        };
        let result = judged(by_regulation);
        let law = &result.parts["low"].laws[0];
        assert_eq!((law.collisions, law.avoidable.both), (2252, 0));
        assert_eq!(law.mean_impact_mps, Some(4.0));
        assert!(!result.holds(), "no more than a third of the model's collisions are allowed");
        let mastered = judged(is_mastered_by_both);
        assert!(!mastered.holds());
        let Avoidable { both, both_within_a_step, .. } = mastered.all.laws[0].avoidable;
        let within = both_within_a_step.expect("they are cut-ins");
        assert!(within > 0 && within < both / 10, "{within} of {both}");
    }
}
