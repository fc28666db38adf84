//! Margins, their order, and their extremes over windows of samples, in linear time.

use std::collections::VecDeque;

/// Margin by which a formula holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Distance to violation, in the formula's unit; negative where it is violated.
    pub value: f64,
    pub sample: usize,
}

impl Margin {
    /// The margin of the contrary.
    pub(crate) fn negative(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

/// The smaller one; of equal ones the earlier.
pub(crate) fn smaller(a: Margin, b: Margin) -> Margin {
    if b.value < a.value || (b.value == a.value && b.sample < a.sample) { b } else { a }
}

/// The larger one; of equal ones the earlier.
pub(crate) fn larger(a: Margin, b: Margin) -> Margin {
    smaller(a.negative(), b.negative()).negative()
}

/// The margins of the contrary.
pub(crate) fn negative(margins: &[Margin]) -> Vec<Margin> {
    margins.iter().map(|margin| margin.negative()).collect()
}

/// Samples `first..=last` after each sample, or before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    pub first: usize,
    /// The last one; all that there are without it.
    pub last: Option<usize>,
}

/// The least margin in the window after each sample; infinite where the window begins after the end.
pub(crate) fn least_after(margins: &[Margin], window: Samples) -> Vec<Margin> {
    let mut least = least_in_turn(margins.iter().rev().copied(), margins.len(), window);
    least.reverse();
    placed(least)
}

/// The largest margin in the window after each sample.
pub(crate) fn largest_after(margins: &[Margin], window: Samples) -> Vec<Margin> {
    negative(&least_after(&negative(margins), window))
}

/// The largest margin in the window before each sample; minus infinity where the window ends before the beginning.
pub(crate) fn largest_before(margins: &[Margin], window: Samples) -> Vec<Margin> {
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
