//! The choice by a Gaussian process: expected improvement below the best value, or below 0 after a violation.
//!
//! The neighbourhood of each violation loses its credit, so that the search goes on to other ones:
//!
//! ```text
//! score(x) = EI(x) · Π over violations v (1 − exp(−|x − v|² / (2 (0.1 √d)²)))      words: |x − v| infinite if they differ
//! ```
//!
//! Values enter as `asinh`: margins far from 0 show little of its place. A point whose nearest known one is not
//! admissible is hardly tried: its score counts a twentieth.

use gaussian_process::{Hyperparameters, Kind, Process, Watched, expected_improvement, fit};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use supervise::Error;

use super::scan::{Admit, Proposal};
use super::{Sobol, seed_of};

/// Points that hyperparameters are fitted to at most: the cost grows with the cube.
const MOST_FITTED: usize = 90;
/// Data that a process holds at the most after a fit: its cost grows with their square. Without a limit a choice took as
/// long as a run at 1,000 runs.
const MOST_KNOWN: usize = 400;
/// Points of the whole box that are looked at for a choice. They stay until the next fit: looking again costs little.
const EVEN: usize = 1024;
/// Best points whose surroundings are looked at, and points looked at around each.
const AROUND: (usize, usize) = (6, 24);
/// Steps to a better point near a chosen one: how far, and points that are looked at in each.
const CLIMB: ([f64; 3], usize) = ([0.06, 0.03, 0.015], 8);
/// Points with the best scores whose neighbours are looked at.
const LOOKED_AT: usize = 64;
/// Radius of the lost credit around a violation, in diagonals of the cube.
const CREDIT_RADIUS: f64 = 0.1;
/// Points of one choice that may turn out not to be admissible.
const MOST_REFUSED: usize = 12;

/// Share of the score that is left to a point beside one that is not admissible.
const BESIDE_REFUSED: f64 = 0.05;

/// A value of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Datum {
    pub point: Vec<f64>,
    pub value: f64,
}

/// Data of one search, in the order of its runs, as far as a choice may use them.
#[derive(Clone, Debug)]
pub(super) struct Model {
    kinds: Vec<Kind>,
    seed: u64,
    /// Number of data that the hyperparameters were fitted to, and what came out.
    fitted: Option<(usize, Fitted)>,
    process: Option<Process>,
    /// Number of data that the process has seen.
    seen: usize,
    /// Even points of the whole box.
    even: Watched,
}

#[derive(Clone, Debug)]
struct Fitted {
    parameters: Hyperparameters,
    mean: f64,
    deviation: f64,
}

impl Fitted {
    fn scaled(&self, value: f64) -> f64 {
        (libm::asinh(value) - self.mean) / self.deviation
    }
}

impl Model {
    pub fn new(kinds: Vec<Kind>, seed: u64) -> Self {
        Self { kinds, seed, fitted: None, process: None, seen: 0, even: Watched::new(Vec::new()) }
    }

    /// Takes the data; hyperparameters are those of the first `fit_to`.
    pub fn know(&mut self, data: &[Datum], fit_to: usize) {
        if self.fitted.as_ref().is_none_or(|(count, _)| *count != fit_to) {
            self.fitted = Some((fit_to, self.fit(&data[..fit_to])));
            self.process = None;
            let sobol = Sobol::new(self.kinds.len(), Some(seed_of(self.seed, 4, fit_to as u64)));
            self.even = Watched::new((0..EVEN).map(|k| sobol.point(k as u64)).collect());
        }
        let (_, fitted) = self.fitted.as_ref().expect("it was fitted");
        let scaled = |one: &Datum| (one.point.clone(), fitted.scaled(one.value));
        match &mut self.process {
            Some(process) => process.extend(data[self.seen..].iter().map(scaled)),
            None => {
                let (old, new) = data.split_at(fit_to);
                let old = telling(old, MOST_KNOWN).into_iter().map(|place| &old[place]);
                let (points, values) = old.chain(new).map(scaled).unzip();
                let parameters = fitted.parameters.clone();
                self.process = Some(Process::new(&self.kinds, parameters, points, values));
            }
        }
        self.seen = data.len();
    }

    fn fit(&self, data: &[Datum]) -> Fitted {
        let squashed: Vec<f64> = data.iter().map(|one| libm::asinh(one.value)).collect();
        let count = squashed.len() as f64;
        let mean = squashed.iter().sum::<f64>() / count;
        let variance = squashed.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
        let deviation = (variance / count).sqrt().max(1e-3);
        let places = telling(data, MOST_FITTED);
        let points: Vec<Vec<f64>> = places.iter().map(|place| data[*place].point.clone()).collect();
        let values: Vec<f64> =
            places.iter().map(|place| (squashed[*place] - mean) / deviation).collect();
        Fitted { parameters: fit(&self.kinds, &points, &values), mean, deviation }
    }

    /// Chooses `count` points. `pending` are driven now: they count as they are expected. `refused` are not admissible.
    pub fn choose(
        &mut self,
        (data, refused): (&[Datum], &[Vec<f64>]),
        pending: &[Vec<f64>],
        (count, batch): (usize, usize),
        admit: &Admit<'_>,
    ) -> Result<Vec<Proposal>, Error> {
        let (_, fitted) = self.fitted.as_ref().expect("it knows the data");
        let least = data.iter().map(|one| one.value).fold(f64::INFINITY, f64::min);
        let target = fitted.scaled(least.max(0.0));
        let mut choice = Choice {
            kinds: &self.kinds,
            process: self.process.as_mut().expect("it knows the data"),
            target,
            admitted: data.iter().map(|one| &one.point).collect(),
            refused: refused.iter().collect(),
            violations: data.iter().filter(|one| one.value < 0.0).map(|one| &one.point).collect(),
            random: Pcg64::seed_from_u64(seed_of(self.seed, 3, batch as u64)),
        };
        for point in pending {
            choice.process.expect(point.clone());
        }
        let mut best: Vec<&Datum> = data.iter().collect();
        best.sort_by(|a, b| a.value.total_cmp(&b.value));
        best.truncate(AROUND.0);
        let mut near = Vec::with_capacity(AROUND.0 * AROUND.1);
        for one in &best {
            for k in 0..AROUND.1 {
                let spread = if k % 2 == 0 { 0.15 } else { 0.04 };
                near.push(choice.near(&one.point, spread));
            }
        }
        let chosen = choice.of(count, [&mut self.even, &mut Watched::new(near)], admit);
        choice.process.forget_expected();
        chosen
    }
}

/// Places of the data with the most information: of more than `most` the lowest half, and others evenly.
fn telling(data: &[Datum], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..data.len()).collect();
    if data.len() > most {
        order.sort_by(|a, b| data[*a].value.total_cmp(&data[*b].value).then(a.cmp(b)));
        let (low, rest) = order.split_at(most / 2);
        let wanted = most - low.len();
        let even = (0..wanted).map(|k| rest[k * rest.len() / wanted]);
        order = low.iter().copied().chain(even).collect();
        order.sort_unstable();
    }
    order
}

struct Choice<'a> {
    kinds: &'a [Kind],
    process: &'a mut Process,
    target: f64,
    admitted: Vec<&'a Vec<f64>>,
    refused: Vec<&'a Vec<f64>>,
    violations: Vec<&'a Vec<f64>>,
    random: Pcg64,
}

impl Choice<'_> {
    /// Chooses among the watched points, one after the other.
    fn of(
        &mut self,
        count: usize,
        mut watched: [&mut Watched; 2],
        admit: &Admit<'_>,
    ) -> Result<Vec<Proposal>, Error> {
        let mut chosen = Vec::with_capacity(count);
        // Violations do not change meanwhile.
        let credits = watched.each_ref().map(|watched| self.credits(watched));
        for _ in 0..count {
            let mut scored = Vec::with_capacity(credits.iter().map(Vec::len).sum());
            for (watched, credits) in watched.iter_mut().zip(&credits) {
                let scores = self.scores(watched, credits);
                scored.extend(scores.into_iter().zip(watched.points()));
            }
            scored.sort_by(|a, b| b.0.total_cmp(&a.0));
            let best = scored.iter().take(LOOKED_AT);
            let best = best.map(|(score, point)| (*score, (*point).clone())).collect();
            let proposal = self.best_of(best, admit)?;
            self.process.expect(proposal.point.clone());
            chosen.push(proposal);
        }
        Ok(chosen)
    }

    fn credits(&self, watched: &Watched) -> Vec<f64> {
        watched.points().iter().map(|point| self.credit(point)).collect()
    }

    fn scores(&self, watched: &mut Watched, credits: &[f64]) -> Vec<f64> {
        let predictions = self.process.predict_watched(watched).into_iter();
        let improvement = predictions.map(|one| expected_improvement(one, self.target));
        improvement.zip(credits).map(|(improvement, credit)| improvement * credit).collect()
    }

    /// The nearest known point is not admissible.
    fn is_beside_refused(&self, point: &[f64]) -> bool {
        let squared = |other: &&Vec<f64>| {
            let parts = point.iter().zip(other.iter()).map(|(a, b)| (a - b) * (a - b));
            parts.sum::<f64>()
        };
        let nearest = |all: &[&Vec<f64>]| all.iter().map(squared).fold(f64::INFINITY, f64::min);
        !self.refused.is_empty() && nearest(&self.refused) < nearest(&self.admitted)
    }

    fn credit(&self, point: &[f64]) -> f64 {
        let radius = CREDIT_RADIUS * CREDIT_RADIUS * self.kinds.len() as f64;
        let share = |violation: &&Vec<f64>| {
            let mut squared = 0.0;
            for ((kind, a), b) in self.kinds.iter().zip(point).zip(violation.iter()) {
                match kind {
                    Kind::Number | Kind::Own => squared += (a - b) * (a - b),
                    Kind::Word(count) | Kind::Branch(count) if same_word(*count, *a, *b) => {}
                    Kind::Word(_) | Kind::Branch(_) => return 1.0,
                }
            }
            1.0 - libm::exp(-0.5 * squared / radius)
        };
        self.violations.iter().map(share).product()
    }

    /// A point around another one. Sometimes a word changes.
    fn near(&mut self, point: &[f64], spread: f64) -> Vec<f64> {
        let mut near = Vec::with_capacity(point.len());
        for (kind, at) in self.kinds.iter().zip(point) {
            let (moved, jump) =
                (random::normal(&mut self.random), random::uniform(&mut self.random));
            let drawn = random::uniform(&mut self.random);
            near.push(match kind {
                Kind::Number | Kind::Own => (at + spread * moved).clamp(0.0, 1.0),
                Kind::Word(_) | Kind::Branch(_) if jump < 0.15 => drawn,
                Kind::Word(_) | Kind::Branch(_) => *at,
            });
        }
        near
    }

    /// The admissible one of some points with the best score, moved to where it is better still.
    fn best_of(
        &mut self,
        mut scored: Vec<(f64, Vec<f64>)>,
        admit: &Admit<'_>,
    ) -> Result<Proposal, Error> {
        for (score, point) in &mut scored {
            *score *= if self.is_beside_refused(point) { BESIDE_REFUSED } else { 1.0 };
        }
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut refused = Vec::new();
        for (score, mut point) in scored {
            let mut reference = admit(&point)?;
            if reference < 0.0 {
                if let Some(better) = self.climb(score, &point) {
                    // The climb may leave the admissible points.
                    let value = admit(&better)?;
                    if value < 0.0 {
                        (point, reference) = (better, value);
                    } else {
                        refused.push(better);
                    }
                }
                let tried = refused.len();
                return Ok(Proposal { point, is_even: false, reference, tried, refused });
            }
            refused.push(point);
            if refused.len() >= MOST_REFUSED {
                break;
            }
        }
        // The model has too few points where the reference fails: an even point, with what was learnt.
        let random = &mut self.random;
        let count = self.kinds.len();
        let points =
            std::iter::repeat_with(|| (0..count).map(|_| random::uniform(random)).collect());
        let found = super::scan::first(points, admit)?;
        Ok(Proposal { is_even: false, tried: found.tried + refused.len(), refused, ..found })
    }

    /// A better point near this one, by steps that shrink; none if there is none.
    fn climb(&mut self, score: f64, point: &[f64]) -> Option<Vec<f64>> {
        let (mut best, mut at) = (score, None);
        for spread in CLIMB.0 {
            let from = at.clone().unwrap_or_else(|| point.to_vec());
            let near = (0..CLIMB.1).map(|_| self.near(&from, spread)).collect();
            let mut near = Watched::new(near);
            let credits = self.credits(&near);
            let scores = self.scores(&mut near, &credits);
            for (score, near) in scores.into_iter().zip(near.points()) {
                if score > best {
                    (best, at) = (score, Some(near.clone()));
                }
            }
        }
        at
    }
}

fn same_word(count: usize, a: f64, b: f64) -> bool {
    let word = |x: f64| ((x * count as f64) as usize).min(count - 1);
    word(a) == word(b)
}
