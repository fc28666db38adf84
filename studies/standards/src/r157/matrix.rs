//! The matrices by name, their cases, and the models' verdicts on them.

use crate::{PerModel, Verdict, cut_in, cut_out, following};
use clap::ValueEnum;
use rand_core::Rng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// True for the cases of a part.
type IsOfPart = fn(&Case) -> bool;

/// A matrix of the regulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Matrix {
    /// A slower vehicle comes into the ego's lane.
    CutIn,
    /// The vehicle ahead brakes.
    Following,
    /// The vehicle ahead leaves the lane in front of a standing one.
    CutOut,
}

impl Matrix {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::CutIn => "cut-in",
            Self::Following => "following",
            Self::CutOut => "cut-out",
        }
    }

    /// Its cases, in the order of the tables.
    pub fn cases(self) -> Vec<Case> {
        match self {
            Self::CutIn => cut_in::low().chain(cut_in::high()).map(Case::CutIn).collect(),
            Self::Following => following::matrix().map(Case::Following).collect(),
            Self::CutOut => cut_out::matrix().map(Case::CutOut).collect(),
        }
    }

    /// Parts with tables of their own, each with the test for its cases.
    pub fn parts(self) -> &'static [(&'static str, IsOfPart)] {
        match self {
            Self::CutIn => &[
                ("low", |case| case.ego_kmh() <= cut_in::LOW_UP_TO_KMH),
                ("high", |case| case.ego_kmh() > cut_in::LOW_UP_TO_KMH),
            ],
            Self::Following | Self::CutOut => &[("all", |_| true)],
        }
    }
}

/// A case of any matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// A cut-in.
    CutIn(cut_in::Case),
    /// A braking lead.
    Following(following::Case),
    /// A cut-out.
    CutOut(cut_out::Case),
}

impl Case {
    /// The models' verdicts; `None` for a model that does not cover the case.
    pub fn verdicts(&self) -> PerModel<Option<Verdict>> {
        match self {
            Self::CutIn(case) => PerModel::new(|model| Some(case.drive(model))),
            Self::Following(case) => PerModel::new(|model| case.drive(model)),
            Self::CutOut(case) => PerModel::new(|model| case.drive(model)),
        }
    }

    /// True for a cut-in whose contact at constant speeds lasts for less than a step of the models.
    pub fn ends_within_a_step(&self) -> bool {
        matches!(self, Self::CutIn(case) if case.ends_within_a_step())
    }

    /// Speed of the ego, km/h.
    pub fn ego_kmh(&self) -> u32 {
        match self {
            Self::CutIn(case) => case.ego_kmh,
            Self::Following(case) => case.speed_kmh,
            Self::CutOut(case) => case.speed_kmh,
        }
    }
}

/// `count` of the cases, drawn without repetition by `seed`, in their order; all if there are no more.
pub fn sample(mut cases: Vec<Case>, count: usize, seed: u64) -> Vec<Case> {
    let mut generator = Pcg64::new(u128::from(seed), 0x0157);
    let total = cases.len();
    let mut order: Vec<usize> = (0..total).collect();
    for place in 0..count.min(total) {
        let left = (total - place) as u64;
        let chosen = place + (generator.next_u64() % left) as usize;
        order.swap(place, chosen);
    }
    order.truncate(count);
    order.sort_unstable();
    let mut kept = order.into_iter().peekable();
    let mut index = 0;
    cases.retain(|_| {
        let keep = kept.next_if_eq(&index).is_some();
        index += 1;
        keep
    });
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_repeats_by_its_seed_and_keeps_the_order() {
        let all = Matrix::CutIn.cases();
        let one = sample(all.clone(), 300, 7);
        assert_eq!(one.len(), 300);
        assert_eq!(one, sample(all.clone(), 300, 7));
        assert_ne!(one, sample(all.clone(), 300, 8));
        let places: Vec<_> =
            one.iter().map(|case| all.iter().position(|other| other == case)).collect();
        assert!(places.is_sorted() && places.iter().all(Option::is_some));
        assert_eq!(sample(all.clone(), usize::MAX, 1), all);
    }

    #[test]
    fn the_parts_of_a_matrix_hold_each_case_once() {
        for matrix in Matrix::value_variants() {
            for case in matrix.cases() {
                let parts = matrix.parts().iter().filter(|(_, holds)| holds(&case)).count();
                assert_eq!(parts, 1, "{case:?}");
            }
        }
    }
}
