//! The margin of a formula on a trace: margins, their order, and their extremes over windows of samples, in linear time.

use crate::syntax::{Kind, Window};
use crate::{Formula, Unit};
use std::collections::VecDeque;

/// Sampled signals.
#[derive(Clone, Debug)]
pub struct Trace<'a> {
    /// Time between two samples, s.
    pub period_s: f64,
    /// The samples of each signal, all of one length. Their order is that of the signals with which the formula was
    /// read.
    pub samples: Vec<&'a [f64]>,
}

/// The values of a node at each sample.
enum Course {
    Numbers(Vec<f64>),
    Margins(Vec<Margin>),
}

pub(crate) fn margin(formula: &Formula, trace: &Trace<'_>) -> Margin {
    let evaluation = Evaluation::of(formula, trace);
    evaluation.margins(formula.root)[0]
}

struct Evaluation<'a> {
    formula: &'a Formula,
    period_s: f64,
    courses: Vec<Course>,
}

impl<'a> Evaluation<'a> {
    fn of(formula: &'a Formula, trace: &Trace<'_>) -> Self {
        let count = trace.samples.iter().map(|samples| samples.len()).min().unwrap_or(0);
        assert!(count > 0, "a trace has samples");
        let mut evaluation = Self {
            formula,
            period_s: trace.period_s,
            courses: Vec::with_capacity(formula.nodes.len()),
        };
        for node in &formula.nodes {
            let course = evaluation.course(&node.kind, trace, count);
            evaluation.courses.push(course);
        }
        evaluation
    }

    fn course(&self, kind: &Kind, trace: &Trace<'_>, count: usize) -> Course {
        use Course::{Margins, Numbers};
        let pairs = |a: &usize, b: &usize, of: fn(f64, f64) -> f64| {
            let (a, b) = (self.numbers(*a), self.numbers(*b));
            a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect::<Vec<f64>>()
        };
        let both = |a: &usize, b: &usize, of: fn(Margin, Margin) -> Margin| {
            let (a, b) = (self.margins(*a), self.margins(*b));
            Margins(a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect())
        };
        match kind {
            Kind::Number(number) => Numbers(vec![*number; count]),
            Kind::Signal(index) => Numbers(trace.samples[*index][..count].to_vec()),
            Kind::Negative(a) => Numbers(self.numbers(*a).iter().map(|a| -a).collect()),
            Kind::Absolute(a) => Numbers(self.numbers(*a).iter().map(|a| a.abs()).collect()),
            Kind::Sum(a, b) => Numbers(pairs(a, b, |a, b| a + b)),
            Kind::Difference(a, b) => Numbers(pairs(a, b, |a, b| a - b)),
            Kind::Product(a, b) => Numbers(pairs(a, b, |a, b| a * b)),
            Kind::AtLeast(a, b) => Margins(self.compared(*a, *b)),
            Kind::Not(a) => Margins(negative(self.margins(*a))),
            Kind::And(a, b) => both(a, b, smaller),
            Kind::Or(a, b) => both(a, b, larger),
            Kind::Implies(a, b) => both(a, b, |a, b| larger(a.negative(), b)),
            Kind::Always(window, a) => {
                Margins(least_after(self.margins(*a), self.samples(*window)))
            }
            Kind::Eventually(window, a) => {
                Margins(largest_after(self.margins(*a), self.samples(*window)))
            }
            Kind::Once(window, a) => {
                Margins(largest_before(self.margins(*a), self.samples(*window)))
            }
            Kind::Until(window, a, b) => Margins(self.until(self.samples(*window), *a, *b)),
        }
    }

    /// Left minus right. Two infinities of one sign are equal: without a vehicle ahead nothing is compared.
    fn compared(&self, left: usize, right: usize) -> Vec<Margin> {
        let scale = if self.formula.unit() == Unit::Mixed {
            1.0 / self.tolerance(left, right)
        } else {
            1.0
        };
        let pairs = self.numbers(left).iter().zip(self.numbers(right));
        let value = |(left, right): (&f64, &f64)| {
            let difference = (left - right) * scale;
            if difference.is_nan() { 0.0 } else { difference }
        };
        pairs.map(value).enumerate().map(|(sample, value)| Margin { value, sample }).collect()
    }

    fn tolerance(&self, left: usize, right: usize) -> f64 {
        self.formula.units[left].with(self.formula.units[right]).unwrap_or(Unit::Any).tolerance()
    }

    /// `left until[first, last] right`: `right` holds somewhere in the window. `left` holds before the window, and from
    /// its beginning until `right` does.
    fn until(&self, window: Samples, left: usize, right: usize) -> Vec<Margin> {
        let (left, right) = (self.margins(left), self.margins(right));
        let count = left.len();
        let mut unbounded = right.to_vec();
        for sample in (0..count.saturating_sub(1)).rev() {
            unbounded[sample] = larger(right[sample], smaller(left[sample], unbounded[sample + 1]));
        }
        let at_first =
            largest_after(&unbounded, Samples { first: window.first, last: Some(window.first) });
        let in_window = largest_after(right, window);
        let mut margins: Vec<Margin> =
            at_first.into_iter().zip(in_window).map(|(a, b)| smaller(a, b)).collect();
        if let Some(last) = window.first.checked_sub(1) {
            let before = least_after(left, Samples { first: 0, last: Some(last) });
            margins = margins.into_iter().zip(before).map(|(a, b)| smaller(a, b)).collect();
        }
        margins
    }

    fn samples(&self, window: Window) -> Samples {
        // A float that is too large becomes the largest integer; such a window lies behind every trace.
        let samples = |seconds: f64| (seconds / self.period_s).round() as usize;
        Samples { first: samples(window.first_s), last: window.last_s.map(samples) }
    }

    fn numbers(&self, id: usize) -> &[f64] {
        match &self.courses[id] {
            Course::Numbers(numbers) => numbers,
            Course::Margins(_) => unreachable!("the formula was checked"),
        }
    }

    fn margins(&self, id: usize) -> &[Margin] {
        match &self.courses[id] {
            Course::Margins(margins) => margins,
            Course::Numbers(_) => unreachable!("the formula was checked"),
        }
    }
}

/// Margin by which a formula holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Distance to violation, in the formula's unit; negative where it is violated.
    pub value: f64,
    pub sample: usize,
}

impl Margin {
    /// The margin of the contrary.
    fn negative(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

/// The smaller one; of equal ones the earlier.
fn smaller(a: Margin, b: Margin) -> Margin {
    if b.value < a.value || (b.value == a.value && b.sample < a.sample) { b } else { a }
}

/// The larger one; of equal ones the earlier.
fn larger(a: Margin, b: Margin) -> Margin {
    smaller(a.negative(), b.negative()).negative()
}

fn negative(margins: &[Margin]) -> Vec<Margin> {
    margins.iter().map(|margin| margin.negative()).collect()
}

/// Samples `first..=last` after each sample, or before it.
#[derive(Clone, Copy, Debug)]
struct Samples {
    pub first: usize,
    /// The last one; all that there are without it.
    pub last: Option<usize>,
}

/// The least margin in the window after each sample; infinite where the window begins after the end.
fn least_after(margins: &[Margin], window: Samples) -> Vec<Margin> {
    let mut least = least_in_turn(margins.iter().rev().copied(), margins.len(), window);
    least.reverse();
    placed(least)
}

fn largest_after(margins: &[Margin], window: Samples) -> Vec<Margin> {
    negative(&least_after(&negative(margins), window))
}

/// The largest margin in the window before each sample; minus infinity where the window ends before the beginning.
fn largest_before(margins: &[Margin], window: Samples) -> Vec<Margin> {
    negative(&placed(least_in_turn(negative(margins).into_iter(), margins.len(), window)))
}

/// Margins of which the infinite ones are decided by their own sample.
fn placed(mut margins: Vec<Margin>) -> Vec<Margin> {
    for (sample, margin) in margins.iter_mut().enumerate() {
        if margin.value == f64::INFINITY {
            margin.sample = sample;
        }
    }
    margins
}

/// For each element in turn, the least of those that came `first..=last` elements before it.
fn least_in_turn(
    margins: impl Iterator<Item = Margin>,
    count: usize,
    window: Samples,
) -> Vec<Margin> {
    let nothing = Margin { value: f64::INFINITY, sample: 0 };
    // Candidates with their turns, their values ascending: a later, smaller one makes the earlier ones useless.
    let mut candidates: VecDeque<(usize, Margin)> = VecDeque::new();
    let mut waiting: VecDeque<Margin> = VecDeque::with_capacity(window.first.min(count) + 1);
    let mut least = Vec::with_capacity(count);
    for (turn, margin) in margins.enumerate() {
        waiting.push_back(margin);
        if let Some(entered) = turn.checked_sub(window.first) {
            let margin = waiting.pop_front().expect("one was pushed for each turn");
            while candidates.back().is_some_and(|(_, other)| smaller(*other, margin) == margin) {
                candidates.pop_back();
            }
            candidates.push_back((entered, margin));
        }
        let left = window.last.and_then(|last| turn.checked_sub(last + 1));
        if candidates.front().is_some_and(|(entered, _)| left.is_some_and(|left| *entered <= left))
        {
            candidates.pop_front();
        }
        least.push(candidates.front().map_or(nothing, |(_, margin)| *margin));
    }
    least
}
