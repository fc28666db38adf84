//! The admissible points of a sequence, one after the other.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};
use supervise::{Error, UsageError};

use super::{Sobol, seed_of};

/// Points in a row that are tried for an admissible one.
pub const MOST_TRIES: usize = 10_000;
/// Refused points that a proposal names: they show a Gaussian process where the reference fails.
const MOST_REFUSED: usize = 2;

/// Judges a point without a run: its value by the reference alone. Below 0 it is admissible.
pub type Admit<'a> = dyn Fn(&[f64]) -> Result<f64, Error> + 'a;

/// A point to be driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    pub point: Vec<f64>,
    /// It was drawn evenly from the admissible points, not chosen by a model.
    pub is_even: bool,
    /// Value of the point by the reference alone, below 0.
    pub reference: f64,
    /// Points that were tried before it.
    pub tried: usize,
    /// Some of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<Vec<f64>>,
}

/// The first admissible point of `points`.
pub(super) fn first(
    points: impl Iterator<Item = Vec<f64>>,
    admit: &Admit<'_>,
) -> Result<Proposal, Error> {
    let mut refused = Vec::new();
    for (tried, point) in points.take(MOST_TRIES).enumerate() {
        let reference = admit(&point)?;
        if reference < 0.0 {
            return Ok(Proposal { point, is_even: true, reference, tried, refused });
        }
        if refused.len() < MOST_REFUSED {
            refused.push(point);
        }
    }
    let place = "the reference driver";
    let why = format_args!("it avoids none of {MOST_TRIES} points");
    Err(UsageError::at(place, why, "milder ranges, or --reference none").into())
}

/// Draws for itself: run `run` of a random search.
pub(crate) fn random(
    dimensions: usize,
    seed: u64,
    run: usize,
    admit: &Admit<'_>,
) -> Result<Proposal, Error> {
    let mut random = Pcg64::seed_from_u64(seed_of(seed, 2, run as u64));
    let points = std::iter::repeat_with(move || {
        (0..dimensions).map(|_| random::uniform(&mut random)).collect()
    });
    first(points, admit)
}

/// A Sobol sequence whose admissible points are known as far as they were asked for.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    sobol: Sobol,
    next: u64,
    found: Vec<Proposal>,
}

impl Scan {
    pub fn new(dimensions: usize, seed: u64) -> Self {
        Self {
            sobol: Sobol::new(dimensions, Some(seed_of(seed, 1, 0))),
            next: 0,
            found: Vec::new(),
        }
    }

    /// The admissible point of this place in the sequence.
    pub fn get(&mut self, place: usize, admit: &Admit<'_>) -> Result<Proposal, Error> {
        while self.found.len() <= place {
            let points = (self.next..).map(|index| self.sobol.point(index));
            let proposal = first(points, admit)?;
            self.next += proposal.tried as u64 + 1;
            self.found.push(proposal);
        }
        Ok(self.found[place].clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half(point: &[f64]) -> Result<f64, Error> {
        Ok(point[0] - 0.5)
    }

    #[test]
    fn only_admissible_points_are_proposed() {
        let mut scan = Scan::new(3, 7);
        let all: Vec<Proposal> =
            (0..50).map(|k| scan.get(k, &half).expect("half of all")).collect();
        assert!(all.iter().all(|one| one.point[0] < 0.5 && one.is_even));
        let tried: usize = all.iter().map(|one| one.tried).sum();
        assert!((40..60).contains(&tried), "{tried}");
        let mut again = Scan::new(3, 7);
        assert_eq!(again.get(49, &half).expect("the same"), all[49], "whatever was asked before");
        let drawn = random(3, 7, 5, &half).expect("half of all");
        assert_eq!(random(3, 7, 5, &half).expect("the same"), drawn);
    }

    #[test]
    fn a_box_without_an_admissible_point_is_refused() {
        let none = |_: &[f64]| Ok(1.0);
        let said = Scan::new(2, 1).get(0, &none).expect_err("none").to_string();
        assert!(said.contains("none of 10000 points"), "{said}");
    }
}
