//! The matrices by name, their cases, and the models' verdicts on them.

use std::fmt::Write;

use clap::ValueEnum;
use rand_core::Rng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use crate::{Model, Verdict, cut_in, cut_out, following};

type IsOfPart = fn(&Case) -> bool;

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
    pub fn name(self) -> &'static str {
        match self {
            Self::CutIn => "cut-in",
            Self::Following => "following",
            Self::CutOut => "cut-out",
        }
    }

    pub fn cases(self) -> Vec<Case> {
        match self {
            Self::CutIn => cut_in::low().chain(cut_in::high()).map(Case::CutIn).collect(),
            Self::Following => following::matrix().map(Case::Following).collect(),
            Self::CutOut => cut_out::matrix().map(Case::CutOut).collect(),
        }
    }

    /// Parts with tables of their own; empty if the matrix has none.
    pub fn parts(self) -> &'static [(&'static str, IsOfPart)] {
        match self {
            Self::CutIn => &[
                ("low", |case| case.ego_kmh() <= cut_in::LOW_UP_TO_KMH),
                ("high", |case| case.ego_kmh() > cut_in::LOW_UP_TO_KMH),
            ],
            Self::Following | Self::CutOut => &[],
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    CutIn(cut_in::Case),
    Following(following::Case),
    CutOut(cut_out::Case),
}

impl Case {
    /// End of the case with a model; `None` of a model that does not cover it.
    pub fn drive(&self, model: Model) -> Option<Verdict> {
        match self {
            Self::CutIn(case) => Some(case.drive(model)),
            Self::Following(case) => case.drive(model),
            Self::CutOut(case) => case.drive(model),
        }
    }

    pub fn cut_in(&self) -> Option<&cut_in::Case> {
        if let Self::CutIn(case) = self { Some(case) } else { None }
    }

    pub fn ego_kmh(&self) -> u32 {
        match self {
            Self::CutIn(case) => case.ego_kmh,
            Self::Following(case) => case.speed_kmh,
            Self::CutOut(case) => case.speed_kmh,
        }
    }
}

/// `count` of the cases, drawn without repetition by `seed`, in their order; all if there are no more.
///
/// Source: Knuth, The Art of Computer Programming, volume 2, 3.4.2, algorithm S.
pub fn sample<T>(mut cases: Vec<T>, count: usize, seed: u64) -> Vec<T> {
    let mut generator = Pcg64::new(u128::from(seed), 0x0157);
    let (mut left, mut wanted) = (cases.len() as u64, count.min(cases.len()) as u64);
    cases.retain(|_| {
        let is_drawn = generator.next_u64() % left < wanted;
        left -= 1;
        wanted -= u64::from(is_drawn);
        is_drawn
    });
    cases
}

/// The models' outcomes of the cut-ins as CSV, one digit for each model: 0 none, 1 side, 2 rear-end.
pub fn csv<'a>(cases: impl IntoIterator<Item = &'a cut_in::Case>) -> String {
    let mut text = "ego_kmh,other_kmh,distance_m,lateral_mps".to_owned();
    for model in Model::ALL {
        text += &format!(",{}", model.name().replace('-', "_"));
    }
    text.push('\n');
    for case in cases {
        let cut_in::Case { ego_kmh, other_kmh, distance_m, lateral_tenths_mps } = *case;
        let (whole, tenth) = (lateral_tenths_mps / 10, lateral_tenths_mps % 10);
        write!(text, "{ego_kmh},{other_kmh},{distance_m},{whole}.{tenth}").expect("memory");
        for model in Model::ALL {
            write!(text, ",{}", case.drive(model).outcome as u8).expect("memory");
        }
        text.push('\n');
    }
    text
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
    fn a_sample_takes_every_case_alike() {
        let mut counts = [0; 20];
        for seed in 0..4_000 {
            sample((0..20).collect(), 3, seed)
                .into_iter()
                .for_each(|case: usize| counts[case] += 1);
        }
        // 600 expected of each, standard deviation 22.6.
        assert!(counts.iter().all(|count| (480..720).contains(count)), "{counts:?}");
    }

    #[test]
    fn the_parts_of_a_matrix_hold_each_case_once() {
        for matrix in Matrix::value_variants().iter().filter(|matrix| !matrix.parts().is_empty()) {
            for case in matrix.cases() {
                let parts = matrix.parts().iter().filter(|(_, holds)| holds(&case)).count();
                assert_eq!(parts, 1, "{case:?}");
            }
        }
    }

    #[test]
    fn a_row_holds_the_case_and_a_digit_for_each_model() {
        let case =
            cut_in::Case { ego_kmh: 60, other_kmh: 20, distance_m: 15, lateral_tenths_mps: 10 };
        assert_eq!(
            csv([&case]),
            "ego_kmh,other_kmh,distance_m,lateral_mps,careful_driver,regulation,rss,fuzzy\n\
             60,20,15,1.0,2,2,2,2\n"
        );
    }

    #[test]
    fn the_matrices_have_the_sizes_of_the_regulation() {
        assert_eq!((cut_in::low().count(), cut_in::high().count()), (15_930, 14_040));
    }
}
