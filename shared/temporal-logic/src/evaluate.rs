//! The margin of a formula on a trace.

use crate::margin::{
    Margin, Samples, larger, largest_after, largest_before, least_after, negative, smaller,
};
use crate::syntax::{Kind, Window};
use crate::{Formula, Unit};

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
