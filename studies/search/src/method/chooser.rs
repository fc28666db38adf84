//! The points of all runs, by the results of earlier ones.

use std::collections::BTreeMap;

use gaussian_process::Kind;
use supervise::Error;

use super::gaussian::{Datum, Model};
use super::scan::{Admit, Proposal, Scan, random};
use super::{MethodName, seed_of};

/// Runs that are chosen at once by a Gaussian process; two such halves are under way.
const HALF: usize = 5;
/// Runs of a search before the process chooses, for each of its parameters. These are a length for each variable,
/// signal and noise. The prior on the lengths holds while the data say little, and every fourth point stays an even
/// one. So few points are enough. Small starts were best in Bossek, Doerr, Kerschke, Initial Design Strategies and
/// their Effects on Sequential Model-Based Optimization, GECCO 2020.
const START: usize = 2;
/// Most runs between two fits: what the process takes on meanwhile makes it slower.
const MOST_BETWEEN_FITS: usize = 100;
/// One of this number of points of a process is an even one.
const EVEN_EVERY: usize = 4;

/// Chooses points.
///
/// ```
/// use gaussian_process::Kind;
/// use search::method::{Chooser, MethodName};
///
/// let mut chooser = Chooser::new(MethodName::Gp, &[Kind::Number; 2], 1, 1);
/// let admit = |_: &[f64]| Ok(-1.0);
/// let mut best = f64::INFINITY;
/// for run in 0..60 {
///     let proposal = chooser.propose(run, &admit).unwrap();
///     let [x, y] = proposal.point[..] else { panic!("two variables") };
///     let value = (x - 0.3).hypot(y - 0.8) * 10.0 - 0.1;
///     best = best.min(value);
///     chooser.tell(run, &proposal, value);
/// }
/// assert!(best < 0.0, "the failure takes 0.03 % of the square");
/// ```
#[derive(Clone, Debug)]
pub struct Chooser {
    method: MethodName,
    dimensions: usize,
    seed: u64,
    replicas: Vec<Replica>,
}

/// One of several independent searches; run `r` is number `r / replicas` of replica `r % replicas`.
#[derive(Clone, Debug)]
struct Replica {
    scan: Scan,
    model: Model,
    told: BTreeMap<usize, (Proposal, f64)>,
    chosen: BTreeMap<usize, Proposal>,
    start: usize,
    /// Data of the reported runs as far as they follow each other from 0.
    data: Vec<Datum>,
    /// Points that were refused before these runs, and how many before the end of each.
    refused: Vec<Vec<f64>>,
    ends: Vec<usize>,
}

impl Chooser {
    /// Chooses by a method, for variables of these kinds. Replicas are of use to a Gaussian process alone.
    pub fn new(method: MethodName, kinds: &[Kind], seed: u64, replicas: usize) -> Self {
        let dimensions = kinds.len();
        let start = (START * (dimensions + 2)).next_multiple_of(HALF).max(2 * HALF);
        let replica = |index: usize| {
            let seed = seed_of(seed, 5, index as u64);
            Replica {
                scan: Scan::new(dimensions, seed),
                model: Model::new(kinds.to_vec(), seed),
                told: BTreeMap::new(),
                chosen: BTreeMap::new(),
                start,
                data: Vec::new(),
                refused: Vec::new(),
                ends: Vec::new(),
            }
        };
        Self { method, dimensions, seed, replicas: (0..replicas.max(1)).map(replica).collect() }
    }

    /// True once the results that the choice of this run needs are there.
    pub fn is_ready(&self, run: usize) -> bool {
        let (replica, place) = self.place(run);
        self.method != MethodName::Gp || replica.follows(replica.needs(place))
    }

    /// Chooses the point of a run. `admit` judges points without a run.
    ///
    /// # Panics
    /// If the run is not ready.
    pub fn propose(&mut self, run: usize, admit: &Admit<'_>) -> Result<Proposal, Error> {
        assert!(self.is_ready(run), "run {run} needs results that are not there");
        let (count, dimensions, seed) = (self.replicas.len(), self.dimensions, self.seed);
        let replica = &mut self.replicas[run % count];
        match self.method {
            MethodName::Random => random(dimensions, seed, run, admit),
            MethodName::Sobol => replica.scan.get(run / count, admit),
            MethodName::Gp => replica.propose(run / count, admit),
        }
    }

    pub fn tell(&mut self, run: usize, driven: &Proposal, value: f64) {
        let count = self.replicas.len();
        self.replicas[run % count].tell(run / count, (driven.clone(), value));
    }

    fn place(&self, run: usize) -> (&Replica, usize) {
        let count = self.replicas.len();
        (&self.replicas[run % count], run / count)
    }
}

impl Replica {
    /// Number of runs whose results the choice of this one needs.
    fn needs(&self, place: usize) -> usize {
        if place < self.start { 0 } else { (place / HALF - 1) * HALF }
    }

    fn follows(&self, runs: usize) -> bool {
        self.ends.len() >= runs
    }

    fn tell(&mut self, place: usize, told: (Proposal, f64)) {
        self.told.insert(place, told);
        while let Some((driven, value)) = self.told.get(&self.ends.len()) {
            self.data.push(Datum { point: driven.point.clone(), value: *value });
            self.refused.extend(driven.refused.iter().cloned());
            self.ends.push(self.refused.len());
        }
    }

    fn propose(&mut self, place: usize, admit: &Admit<'_>) -> Result<Proposal, Error> {
        if place < self.start {
            return self.scan.get(place, admit);
        }
        if !self.chosen.contains_key(&place) {
            self.choose(place / HALF, admit)?;
        }
        Ok(self.chosen[&place].clone())
    }

    /// Chooses the points of a half batch.
    fn choose(&mut self, half: usize, admit: &Admit<'_>) -> Result<(), Error> {
        let known = (half - 1) * HALF;
        // The half batch before is under way, unless it was done before an interrupt.
        let mut pending = Vec::with_capacity(HALF);
        for place in known..known + HALF {
            let point = match self.told.get(&place) {
                Some((driven, _)) => driven.point.clone(),
                None => self.propose(place, admit)?.point,
            };
            pending.push(point);
        }
        let is_even = |place: usize| (place - self.start) % EVEN_EVERY == EVEN_EVERY - 1;
        let places: Vec<usize> = (half * HALF..(half + 1) * HALF).collect();
        let (even, led): (Vec<usize>, Vec<usize>) =
            places.into_iter().partition(|place| is_even(*place));
        for place in even {
            let number = self.start + (place - self.start) / EVEN_EVERY;
            let proposal = self.scan.get(number, admit)?;
            self.chosen.insert(place, proposal);
        }
        let fit_to = self.fitted_at(known);
        let (data, refused) = (&self.data[..known], &self.refused[..self.ends[known - 1]]);
        self.model.know(data, fit_to);
        let count = (led.len(), half);
        let chosen = self.model.choose((data, refused), &pending, count, admit)?;
        self.chosen.extend(led.into_iter().zip(chosen));
        Ok(())
    }

    /// Number of runs to which the hyperparameters are fitted when `known` are known. Each time it is a quarter more,
    /// up to 100.
    fn fitted_at(&self, known: usize) -> usize {
        let mut at = self.start - HALF;
        loop {
            let next = at + (at / 4).clamp(HALF, MOST_BETWEEN_FITS);
            if next > known {
                return at;
            }
            at = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(numbers: usize) -> Vec<Kind> {
        let mut all = vec![Kind::Number; numbers];
        all.push(Kind::Word(3));
        all
    }

    /// A ridge of no reference, and a small hole beyond it for one word alone.
    fn admit(point: &[f64]) -> Result<f64, Error> {
        Ok(4.0 * (point[0] - 0.9))
    }

    fn value(point: &[f64]) -> f64 {
        let word = if (0.34..0.66).contains(&point[3]) { 0.0 } else { 1.5 };
        let off = (point[0] - 0.75).hypot(point[1] - 0.2).hypot(point[2] - 0.6);
        8.0 * off - 0.4 + word
    }

    fn drive(method: MethodName, runs: usize) -> Vec<f64> {
        let mut chooser = Chooser::new(method, &kinds(3), 5, 1);
        let mut values = Vec::new();
        for run in 0..runs {
            let driven = chooser.propose(run, &admit).expect("admissible");
            let value = value(&driven.point);
            values.push(value);
            chooser.tell(run, &driven, value);
        }
        values
    }

    #[test]
    fn the_process_finds_what_even_points_do_not() {
        let first = |values: &[f64]| values.iter().position(|value| *value < 0.0);
        assert!(first(&drive(MethodName::Gp, 90)).is_some());
        assert_eq!(first(&drive(MethodName::Sobol, 90)), None);
        assert_eq!(first(&drive(MethodName::Random, 90)), None);
    }

    /// One fault of six breaks something, with a size near 1 that begins at some time: 0.4 % of the cube. The numbers of
    /// the faults mean nothing where no fault acts.
    #[test]
    fn the_fault_that_matters_is_found() {
        let kinds = [Kind::Number, Kind::Own, Kind::Own, Kind::Branch(7)];
        let value = |x: &[f64]| {
            let broken = 8.0 - 12.0 * x[2] + 10.0 * (x[1] - 0.4).abs();
            let is_active = (0.58..0.7).contains(&x[3]);
            2.0 + 3.0 * x[0] + if is_active { broken.min(0.0) } else { 0.0 }
        };
        let all = |_: &[f64]| Ok(-1.0);
        let first = |method, seed| {
            let mut chooser = Chooser::new(method, &kinds, seed, 1);
            for run in 0..150 {
                let driven = chooser.propose(run, &all).expect("one");
                let value = value(&driven.point);
                if value < 0.0 {
                    return run;
                }
                chooser.tell(run, &driven, value);
            }
            150
        };
        let median = |method| {
            let mut all: Vec<usize> = (0..5).map(|seed| first(method, seed)).collect();
            all.sort_unstable();
            all[2]
        };
        let (led, even) = (median(MethodName::Gp), median(MethodName::Random));
        assert!(2 * led < even, "{led} {even}");
    }

    /// Results come in another order, some are there before the others begin: the choice is the same.
    #[test]
    fn the_choice_does_not_depend_on_the_time_of_results() {
        let runs = 50;
        let mut all = Vec::new();
        let mut chooser = Chooser::new(MethodName::Gp, &kinds(3), 5, 1);
        for run in 0..runs {
            let proposal = chooser.propose(run, &admit).expect("admissible");
            chooser.tell(run, &proposal, value(&proposal.point));
            all.push(proposal);
        }
        let tell = |chooser: &mut Chooser, run: usize| {
            chooser.tell(run, &all[run], value(&all[run].point));
        };
        // As after an interrupt: the last half batch is missing two of its runs.
        let mut resumed = Chooser::new(MethodName::Gp, &kinds(3), 5, 1);
        for run in (0..runs).rev().filter(|run| ![42, 46].contains(run)) {
            tell(&mut resumed, run);
        }
        for run in [42, 46] {
            assert!(resumed.is_ready(run));
            assert_eq!(resumed.propose(run, &admit).expect("admissible"), all[run], "run {run}");
            tell(&mut resumed, run);
        }
        let next = resumed.propose(50, &admit).expect("admissible");
        assert_eq!(next, chooser.propose(50, &admit).expect("admissible"));
    }

    #[test]
    fn replicas_are_independent_of_each_other() {
        let mut chooser = Chooser::new(MethodName::Gp, &kinds(2), 5, 2);
        for run in (0..40).step_by(2) {
            let driven = chooser.propose(run, &admit).expect("one");
            chooser.tell(run, &driven, driven.point[0]);
        }
        assert!(chooser.is_ready(40) && chooser.is_ready(1) && !chooser.is_ready(41));
    }
}
