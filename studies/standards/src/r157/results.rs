//! The verdicts of the models and of each driver, case by case, and the figures over them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{Counts, Held, Limit, Position};
use super::matrix::{Case, Matrix};
use crate::{Model, Outcome, Verdict, cut_in};

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    #[serde(flatten)]
    pub verdict: Verdict,
    /// A requirement of the command is broken; `None` without one.
    pub is_broken: Option<bool>,
}

/// The verdicts of the models and of each driver over the cases of a matrix.
#[derive(Debug)]
pub struct Judged {
    pub matrix: Matrix,
    pub cases: Vec<Case>,
    /// The models' verdicts, case by case; `None` of a model that does not cover the matrix.
    models: [Option<Vec<Verdict>>; 4],
    /// Both of the regulation's models end the case without a collision.
    pub is_mastered: Vec<bool>,
    pub drivers: Vec<Driven>,
}

#[derive(Debug)]
pub struct Driven {
    pub law: String,
    /// With the emergency brake.
    pub aebs: bool,
    pub ends: Vec<End>,
    /// Verdicts of `careful-driver` from the law's gap; `None` without cut-outs.
    pub from_its_gap: Option<Vec<Verdict>>,
}

/// UN R157's matrices.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Results {
    pub schema_version: u32,
    /// No law with the emergency brake is beyond a limit, and no requirement of the command is broken.
    pub ok: bool,
    pub matrices: Vec<MatrixResult>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub struct MatrixResult {
    pub matrix: &'static str,
    /// The figures over all its cases.
    #[serde(flatten)]
    pub all: Figures,
    /// The same figures of each part, by its name; empty without parts.
    pub parts: BTreeMap<&'static str, Figures>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub struct Figures {
    pub cases: u32,
    /// Collisions of both kinds with each model; null where the model covers no case.
    pub models: BTreeMap<&'static str, Option<u32>>,
    /// Rear-end collisions with each model.
    pub models_rear_end: BTreeMap<&'static str, Option<u32>>,
    /// Cases that both models of the regulation end without a collision.
    pub mastered_by_both: u32,
    pub laws: Vec<LawResult>,
    #[serde(skip)]
    pub limit: Option<&'static Limit>,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct LawResult {
    pub law: String,
    /// With the emergency brake.
    pub aebs: bool,
    /// Collisions of both kinds.
    pub collisions: u32,
    /// Rear-end collisions.
    pub rear_end: u32,
    /// Collisions in cases that a model masters.
    pub avoidable: Avoidable,
    /// `careful-driver` from the law's gap; null without cut-outs.
    pub from_its_gap: Option<FromItsGap>,
    /// Cases with a broken requirement of the command; null without one.
    pub requirements_broken: Option<u32>,
    /// Mean speed difference at the contact, m/s; null without one.
    pub mean_impact_mps: Option<f64>,
    /// The same of `regulation`, else of `careful-driver`, over the same cases.
    pub model_impact_mps: Option<f64>,
    /// Its figure by the limit over these cases; null without one.
    pub limit: Option<Held>,
}

/// Collisions in cases that a model masters.
#[derive(Debug, Default, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub struct Avoidable {
    /// `careful-driver`.
    pub careful_driver: Option<u32>,
    /// `regulation`; null where it covers no case.
    pub regulation: Option<u32>,
    /// Both of them.
    pub both: u32,
    /// Those of `both` that the models may miss, since they move in steps; null without cut-ins.
    pub both_within_a_step: Option<u32>,
}

/// `careful-driver` from the gap that a law keeps.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FromItsGap {
    /// Its collisions.
    pub collisions: u32,
    /// Cases that it ends without one.
    pub mastered: u32,
    /// Collisions of the law in those.
    pub avoidable: u32,
}

impl LawResult {
    pub fn driver(&self) -> String {
        format!("{}{}", self.law, if self.aebs { " + AEBS" } else { "" })
    }

    pub fn is_beyond(&self) -> bool {
        self.limit.as_ref().is_some_and(|held| held.verdict == Position::Beyond)
    }

    /// True if it is beyond a limit with the emergency brake, or broke a requirement of the command.
    pub fn is_broken(&self) -> bool {
        self.requirements_broken.is_some_and(|cases| cases > 0) || (self.aebs && self.is_beyond())
    }
}

impl MatrixResult {
    /// The figures with a name: of each part, then of all cases.
    pub fn figures(&self) -> impl Iterator<Item = (String, &Figures)> {
        // Low before high.
        let parts = self.parts.iter().rev();
        let parts = parts.map(|(part, figures)| (format!("{}, {part}", self.matrix), figures));
        parts.chain([(self.matrix.to_owned(), &self.all)])
    }

    pub fn holds(&self) -> bool {
        !self.figures().any(|(_, figures)| figures.laws.iter().any(LawResult::is_broken))
    }
}

impl Judged {
    pub fn new(matrix: Matrix, cases: Vec<Case>) -> Self {
        let drive = |model| cases.iter().map(|case| case.drive(model)).collect();
        let models: [Option<Vec<Verdict>>; 4] = Model::ALL.map(drive);
        let of_both = [Model::CarefulDriver, Model::Regulation];
        let of_both = of_both.map(|model| models[model as usize].as_deref());
        let masters =
            |index: usize| of_both.iter().flatten().all(|verdicts| !verdicts[index].is_collision());
        let is_mastered = (0..cases.len()).map(masters).collect();
        Self { matrix, cases, models, is_mastered, drivers: Vec::new() }
    }

    pub fn result(&self) -> MatrixResult {
        let parts = self.matrix.parts().iter();
        let of_parts = Limit::of_parts(self.matrix);
        MatrixResult {
            matrix: self.matrix.name(),
            all: self.figures(&|_| true, Some(Limit::of_whole(self.matrix))),
            parts: parts.map(|(name, holds)| (*name, self.figures(holds, of_parts))).collect(),
        }
    }

    pub fn is_sample(&self) -> bool {
        self.cases.len() < self.matrix.cases().len()
    }

    fn figures(&self, holds: &dyn Fn(&Case) -> bool, limit: Option<&'static Limit>) -> Figures {
        let chosen = (0..self.cases.len()).filter(|&index| holds(&self.cases[index]));
        let chosen: Vec<usize> = chosen.collect();
        let count = |holds: &dyn Fn(usize) -> bool| count(&chosen, holds);
        let by_model = |is_counted: fn(Outcome) -> bool| {
            let models = Model::ALL.into_iter().zip(&self.models).map(|(model, verdicts)| {
                let verdicts = verdicts.as_deref();
                let counted = verdicts.map(|v| count(&|index| is_counted(v[index].outcome)));
                (model.name(), counted)
            });
            models.collect()
        };
        let mut figures = Figures {
            cases: chosen.len() as u32,
            models: by_model(Outcome::is_collision),
            models_rear_end: by_model(|outcome| outcome == Outcome::RearEnd),
            mastered_by_both: count(&|index| self.is_mastered[index]),
            laws: Vec::new(),
            limit,
        };
        for driven in &self.drivers {
            let mut law = self.law(driven, &chosen);
            let counts = Counts {
                cases: figures.cases,
                collisions: law.collisions,
                mastered_by_both: figures.mastered_by_both,
                avoidable_by_both: law.avoidable.both,
                of_regulation: figures.models[Model::Regulation.name()],
                from_its_gap: law.from_its_gap.as_ref().map(|gap| (gap.avoidable, gap.mastered)),
            };
            law.limit = limit.and_then(|limit| limit.hold(&counts, self.is_sample()));
            figures.laws.push(law);
        }
        figures
    }

    fn law(&self, driven: &Driven, chosen: &[usize]) -> LawResult {
        let Driven { law, aebs, ends, from_its_gap } = driven;
        let is_hit = |index: &usize| ends[*index].verdict.is_collision();
        let hits: Vec<usize> = chosen.iter().copied().filter(is_hit).collect();
        let masters = |verdicts: &[Verdict]| count(&hits, &|index| !verdicts[index].is_collision());
        let [careful_driver, regulation, ..] = self.models.each_ref().map(Option::as_deref);
        let mean_impact_mps = |verdict: &dyn Fn(usize) -> Verdict| {
            let sum_mps: f64 = hits.iter().map(|&index| verdict(index).impact_speed_mps).sum();
            (!hits.is_empty()).then(|| sum_mps / hits.len() as f64)
        };
        let case = |index: usize| self.cases[index].cut_in();
        let is_short = |index| case(index).is_some_and(cut_in::Case::ends_within_a_step);
        let broken = chosen.iter().map(|&index| ends[index].is_broken.map(u32::from));
        LawResult {
            law: law.clone(),
            aebs: *aebs,
            collisions: hits.len() as u32,
            rear_end: count(&hits, &|index| ends[index].verdict.outcome == Outcome::RearEnd),
            avoidable: Avoidable {
                careful_driver: careful_driver.map(masters),
                regulation: regulation.map(masters),
                both: count(&hits, &|index| self.is_mastered[index]),
                both_within_a_step: (self.matrix == Matrix::CutIn)
                    .then(|| count(&hits, &|index| self.is_mastered[index] && is_short(index))),
            },
            from_its_gap: from_its_gap.as_deref().map(|model| {
                let collisions = count(chosen, &|index| model[index].is_collision());
                let mastered = chosen.len() as u32 - collisions;
                FromItsGap { collisions, mastered, avoidable: masters(model) }
            }),
            requirements_broken: broken.sum(),
            mean_impact_mps: mean_impact_mps(&|index| ends[index].verdict),
            model_impact_mps: (regulation.or(careful_driver))
                .and_then(|model| mean_impact_mps(&|index| model[index])),
            limit: None,
        }
    }
}

fn count(cases: &[usize], holds: &dyn Fn(usize) -> bool) -> u32 {
    cases.iter().filter(|index| holds(**index)).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    const HIT: Verdict = Verdict { outcome: Outcome::RearEnd, impact_speed_mps: 4.0 };

    /// A law with the emergency brake that collides in these cases.
    fn hitting(
        mut judged: Judged,
        is_hit: impl Fn(usize) -> bool,
        from: Option<Verdict>,
    ) -> MatrixResult {
        let all = 0..judged.cases.len();
        let end = |index| {
            let verdict = if is_hit(index) { HIT } else { Verdict::NONE };
            End { verdict, is_broken: None }
        };
        let from_its_gap = from.map(|verdict| all.clone().map(|_| verdict).collect());
        judged.drivers = vec![Driven {
            law: "acc-mpc".into(),
            aebs: true,
            ends: all.map(end).collect(),
            from_its_gap,
        }];
        judged.result()
    }

    fn cut_ins(is_hit: impl Fn(&Judged, usize) -> bool) -> MatrixResult {
        let judged = Judged::new(Matrix::CutIn, Matrix::CutIn.cases());
        let is_hit: Vec<bool> = (0..judged.cases.len()).map(|i| is_hit(&judged, i)).collect();
        hitting(judged, |index| is_hit[index], None)
    }

    #[test]
    fn a_law_that_collides_where_nothing_could_be_done_holds() {
        let result = cut_ins(|_, _| false);
        assert_eq!(result.all.cases, 29_970);
        assert_eq!(result.parts["low"].mastered_by_both, 12_124);
        assert_eq!(result.parts["high"].models["regulation"], Some(2869));
        assert!(result.holds());
        assert_eq!(result.all.laws[0].mean_impact_mps, None);
    }

    #[test]
    fn a_law_that_collides_like_the_models_does_not() {
        let result = cut_ins(|judged, index| {
            let regulation = judged.models[Model::Regulation as usize].as_ref();
            regulation.expect("it covers cut-ins")[index].is_collision()
        });
        let law = &result.parts["low"].laws[0];
        assert_eq!((law.collisions, law.avoidable.both), (2252, 0));
        assert_eq!(law.mean_impact_mps, Some(4.0));
        assert!(!result.holds(), "no more than a third of the model's collisions are allowed");
        let mastered = cut_ins(|judged, index| judged.is_mastered[index]);
        assert!(!mastered.holds());
        let Avoidable { both, both_within_a_step, .. } = mastered.all.laws[0].avoidable;
        let within = both_within_a_step.expect("they are cut-ins");
        assert!(both == 22_475 && within > 0 && within < both / 10, "{within} of {both}");
    }

    #[test]
    fn the_share_of_the_mastered_cut_ins_is_that_of_both_parts_together() {
        // 0.5 % of 22,475 are 112, of the 10,351 high ones 51.
        for (hits, holds) in [(112, true), (113, false)] {
            let judged = Judged::new(Matrix::CutIn, Matrix::CutIn.cases());
            let mastered = (0..judged.cases.len()).rev().filter(|&i| judged.is_mastered[i]);
            let hit: Vec<usize> = mastered.take(hits).collect();
            let result = hitting(judged, |index| hit.contains(&index), None);
            assert_eq!(result.parts["high"].laws[0].avoidable.both as usize, hits);
            assert_eq!(result.holds(), holds, "{hits}");
        }
    }

    #[test]
    fn a_cut_out_is_judged_by_the_careful_driver_from_the_laws_own_gap() {
        let result = |hits: usize, from: Verdict| {
            let judged = Judged::new(Matrix::CutOut, Matrix::CutOut.cases());
            hitting(judged, |index| index < hits, Some(from))
        };
        // 0.5 % of 5,850 are 29.
        assert!(result(29, Verdict::NONE).holds() && !result(30, Verdict::NONE).holds());
        let model_collides = result(5850, HIT);
        assert!(model_collides.holds());
        let model = model_collides.all.laws[0].from_its_gap.as_ref().expect("they are cut-outs");
        assert_eq!((model.collisions, model.mastered, model.avoidable), (5850, 0, 0));
    }
}
