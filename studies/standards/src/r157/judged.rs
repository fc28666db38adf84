//! The verdicts of the models and of each driver, case by case, and the figures over them.

use crate::{Model, Outcome, PerModel, Tally, Verdict, is_mastered_by_both};

use super::drive::Driver;
use super::limits::Limit;
use super::matrix::{Case, Matrix};
use super::results::{Avoidable, Figures, FromItsGap, LawResult, MatrixResult};

/// The verdicts of the models and of each driver over the cases of a matrix.
#[derive(Debug)]
pub struct Judged {
    /// The matrix.
    pub matrix: Matrix,
    /// The cases.
    pub cases: Vec<Case>,
    /// The models' verdicts, case by case.
    pub models: Vec<PerModel<Option<Verdict>>>,
    /// The drivers.
    pub laws: Vec<Driven>,
}

/// A driver's verdicts, case by case.
#[derive(Debug)]
pub struct Driven {
    /// The driver.
    pub driver: Driver,
    /// Its verdicts.
    pub verdicts: Vec<Verdict>,
    /// Verdicts of `careful-driver` from the law's gap; `None` without cut-outs.
    pub from_its_gap: Option<Vec<Verdict>>,
    /// True if it broke a requirement, case by case; `None` without requirements.
    pub broken: Option<Vec<bool>>,
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
            all: self.figures(&|_| true, Limit::of_whole(self.matrix)),
            parts: (parts.iter())
                .map(|(name, holds)| (*name, self.figures(holds, Limit::of_parts(self.matrix))))
                .collect(),
        }
    }

    fn figures(&self, holds: &dyn Fn(&Case) -> bool, limits: &'static [Limit]) -> Figures {
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
            laws: self.laws.iter().map(|driven| self.law(driven, &chosen)).collect(),
            limits,
        }
    }

    fn law(&self, driven: &Driven, chosen: &[usize]) -> LawResult {
        let Driven { driver, verdicts, from_its_gap, broken } = driven;
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
            from_its_gap: from_its_gap.as_ref().map(|model| {
                let masters = |index: usize| !model[index].outcome.is_collision();
                let mastered = chosen.iter().filter(|&&index| masters(index)).count();
                let mastered = u32::try_from(mastered).expect("a matrix has few cases");
                let cases = u32::try_from(chosen.len()).expect("a matrix has few cases");
                FromItsGap { collisions: cases - mastered, mastered, avoidable: count(&masters) }
            }),
            requirements_broken: broken.as_ref().map(|broken| {
                let broken = chosen.iter().filter(|&&index| broken[index]).count();
                u32::try_from(broken).expect("a matrix has few cases")
            }),
            mean_impact_mps: mean(collided.iter().map(|&index| verdicts[index].impact_speed_mps)),
            model_impact_mps: mean(
                (collided.iter())
                    .filter_map(|&index| self.models[index][model])
                    .map(|verdict| verdict.impact_speed_mps),
            ),
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
        let verdicts = verdicts.collect();
        judged.laws = vec![Driven { driver, verdicts, from_its_gap: None, broken: None }];
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

    /// A law with the emergency brake that collides in these cases.
    fn hitting(
        mut judged: Judged,
        is_hit: impl Fn(usize) -> bool,
        from: Option<Verdict>,
    ) -> Judged {
        let all = 0..judged.cases.len();
        let driver = Driver { law: "acc-mpc".into(), aebs: true };
        let verdicts = all.clone().map(|index| if is_hit(index) { HIT } else { Verdict::NONE });
        let verdicts = verdicts.collect();
        let from_its_gap = from.map(|verdict| all.map(|_| verdict).collect());
        judged.laws = vec![Driven { driver, verdicts, from_its_gap, broken: None }];
        judged
    }

    #[test]
    fn the_share_of_the_mastered_cut_ins_is_that_of_both_parts_together() {
        // 0.5 % of 22,475 are 112, of the 10,351 high ones 51.
        for (hits, holds) in [(112, true), (113, false)] {
            let judged = Judged::new(Matrix::CutIn, Matrix::CutIn.cases());
            let mastered =
                (0..judged.cases.len()).rev().filter(|&i| is_mastered_by_both(&judged.models[i]));
            let hit: Vec<usize> = mastered.take(hits).collect();
            let result = hitting(judged, |index| hit.contains(&index), None).result();
            assert_eq!(result.parts["high"].laws[0].avoidable.both as usize, hits);
            assert_eq!(result.holds(), holds, "{hits}");
        }
    }

    #[test]
    fn a_cut_out_is_judged_by_the_careful_driver_from_the_laws_own_gap() {
        let result = |hits: usize, from: Verdict| {
            let judged = Judged::new(Matrix::CutOut, Matrix::CutOut.cases());
            hitting(judged, |index| index < hits, Some(from)).result()
        };
        // 0.5 % of 5,850 are 29.
        assert!(result(29, Verdict::NONE).holds() && !result(30, Verdict::NONE).holds());
        let model_collides = result(5850, HIT);
        assert!(model_collides.holds());
        let model = model_collides.all.laws[0].from_its_gap.as_ref().expect("they are cut-outs");
        assert_eq!((model.collisions, model.mastered, model.avoidable), (5850, 0, 0));
    }
}
