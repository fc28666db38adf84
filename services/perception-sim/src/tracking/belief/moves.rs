//! Draws of hypotheses: from the prior, and small steps from one that is known.
//!
//! All steps are symmetric, so that Metropolis' rule accepts them by the ratio of the densities.

use super::likelihood::{
    ARC_M, EDGE_M, MEAN_ARC_M, MEAN_RAMP_M, RADIUS_M, RAMP_M, SHORT_M, STRAIGHT_M,
};
use super::road::{BENDS, Bend, Hypothesis};
use crate::random::Random;

/// Start of the first curve of a new hypothesis, m.
const FIRST_FROM_M: (f64, f64) = (-100.0, STRAIGHT_M);
/// Steps of a curve's start, m, curvature, 1/m, clothoid, m, and arc, m, of the heading, rad, and of the offset, m. They
/// are some of the posterior's standard deviations at medium distance, where the decisions fall.
const STEPS: [f64; 6] = [4.0, 1.5e-4, 6.0, 8.0, 0.0012, 0.06];
/// Step of an edge, m.
const EDGE_STEP_M: f64 = 0.3;
/// Factors of the steps: far roads are vague and near ones exact.
const SCALES: [f64; 4] = [0.2, 0.6, 1.5, 4.0];

/// Shares of steps that draw curves anew, and, with them, of those along the difference of two others.
const REDRAWN: f64 = 0.1;
const DIFFERENT: f64 = 0.8;

/// Change of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Some numbers a little: prior and likelihood decide.
    Walk,
    /// Curves anew from the prior: the likelihood alone decides.
    Redraw,
}

/// A hypothesis before any evidence.
pub fn first(random: &mut Random) -> Hypothesis {
    let mut hypothesis = Hypothesis {
        heading_rad: 0.012 * random.normal(),
        offset_m: 0.3 * random.normal(),
        edges_m: std::array::from_fn(|_| random.between(EDGE_M.0, EDGE_M.1)),
        ..Hypothesis::default()
    };
    redraw(&mut hypothesis, 0, random);
    hypothesis
}

/// Draws the curves from this one on from the prior.
pub fn redraw(hypothesis: &mut Hypothesis, first: usize, random: &mut Random) {
    for index in first..BENDS {
        let from_m = match index.checked_sub(1) {
            None => random.between(FIRST_FROM_M.0, FIRST_FROM_M.1),
            Some(before) => hypothesis.bends[before].to_m() + gap_m(random),
        };
        let radius_m =
            RADIUS_M.0 * libm::exp(random.uniform() * libm::log(RADIUS_M.1 / RADIUS_M.0));
        let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
        let mut length_m = |mean_m: f64, (from_m, to_m): (f64, f64)| {
            (from_m + mean_m * random.exponential()).min(to_m)
        };
        let (ramp_m, arc_m) = (length_m(MEAN_RAMP_M, RAMP_M), length_m(MEAN_ARC_M, ARC_M));
        hypothesis.bends[index] = Bend { from_m, curvature_perm: sign / radius_m, ramp_m, arc_m };
    }
}

/// Straight road between two curves, m.
fn gap_m(random: &mut Random) -> f64 {
    match random.uniform() < 0.5 {
        true => (SHORT_M * random.exponential()).min(STRAIGHT_M),
        false => random.between(0.0, STRAIGHT_M),
    }
}

/// A step from a hypothesis. `others` are two of the population.
pub fn step(
    from: &Hypothesis,
    others: [&Hypothesis; 2],
    random: &mut Random,
) -> (Hypothesis, Step) {
    let shown = from.bends.iter().take_while(|bend| bend.from_m < STRAIGHT_M).count().max(1);
    match random.uniform() {
        ..REDRAWN => {
            let mut to = *from;
            let is_new = (FIRST_FROM_M.0..FIRST_FROM_M.1).contains(&from.bends[0].from_m);
            let first = (random.uniform() * shown as f64) as usize;
            redraw(&mut to, first.max(usize::from(!is_new)), random);
            (to, Step::Redraw)
        }
        ..DIFFERENT => (along_difference(from, others, shown, random), Step::Walk),
        _ => (walked(from, shown, random), Step::Walk),
    }
}

/// A step along the difference of two others. It shows which numbers go together, and how far.
///
/// Source: C. ter Braak, A Markov chain Monte Carlo version of the genetic algorithm Differential Evolution, Statistics
/// and Computing 16 (2006) 239. The factor is near 2.38 / √(2 d) for some ten numbers d. With 1 it jumps between modes.
fn along_difference(
    from: &Hypothesis,
    [a, b]: [&Hypothesis; 2],
    shown: usize,
    random: &mut Random,
) -> Hypothesis {
    let mut to = *from;
    let share = random.uniform();
    let far = if share < 0.1 { 1.0 } else { 0.2 + 0.7 * share };
    let mut by = |a: f64, b: f64, step: f64| {
        far * (a - b) + 0.1 * step * (random.uniform() - random.uniform())
    };
    to.heading_rad += by(a.heading_rad, b.heading_rad, STEPS[4]);
    to.offset_m += by(a.offset_m, b.offset_m, STEPS[5]);
    for (index, edge_m) in to.edges_m.iter_mut().enumerate() {
        *edge_m += by(a.edges_m[index], b.edges_m[index], EDGE_STEP_M);
    }
    for index in 0..shown {
        let (bend, a, b) = (&mut to.bends[index], &a.bends[index], &b.bends[index]);
        let to_m = bend.to_m();
        bend.curvature_perm += by(a.curvature_perm, b.curvature_perm, STEPS[1]);
        bend.ramp_m = reflected_m(bend.ramp_m + by(a.ramp_m, b.ramp_m, STEPS[2]));
        bend.from_m += by(a.from_m, b.from_m, STEPS[0]);
        bend.end_at(to_m + by(a.to_m(), b.to_m(), STEPS[3]));
    }
    let moved_m = to.bends[shown - 1].to_m() - from.bends[shown - 1].to_m();
    to.bends[shown..].iter_mut().for_each(|bend| bend.from_m += moved_m);
    to
}

/// A random step of the ego's place, and of the edges or a curve.
fn walked(from: &Hypothesis, shown: usize, random: &mut Random) -> Hypothesis {
    let mut to = *from;
    let scale = SCALES[(random.uniform() * SCALES.len() as f64) as usize];
    let [kind, which, order] = [0; 3].map(|_| random.uniform());
    let index = (random.uniform() * shown as f64) as usize;
    // The difference of two uniform deviates is symmetric; √6 gives it the variance 1.
    let mut by = |step: f64| step * scale * 2.449 * (random.uniform() - random.uniform());
    to.heading_rad += by(STEPS[4]);
    to.offset_m += by(STEPS[5]);
    if kind < 0.4 {
        to.edges_m = to.edges_m.map(|edge_m| edge_m + by(EDGE_STEP_M));
        return to;
    }
    let bend = &mut to.bends[index];
    let to_m = bend.to_m();
    bend.curvature_perm += by(STEPS[1]);
    bend.ramp_m = reflected_m(bend.ramp_m + by(STEPS[2]));
    // Its start moves, or its end, or all of it.
    let (start_m, end_m) = (by(STEPS[0]), by(STEPS[3]));
    let (start_m, end_m) = match which {
        ..0.33 => (start_m, start_m),
        ..0.67 => (start_m, 0.0),
        _ => (0.0, end_m),
    };
    bend.from_m += start_m;
    bend.end_at(to_m + end_m);
    if order < 0.5 {
        // The distance to the next curve stays, not its place.
        let moved_m = to.bends[index].to_m() - from.bends[index].to_m();
        to.bends[index + 1..].iter_mut().for_each(|bend| bend.from_m += moved_m);
    }
    to
}

/// A length of a clothoid, at or above the least one.
fn reflected_m(ramp_m: f64) -> f64 {
    RAMP_M.0 + (ramp_m - RAMP_M.0).abs()
}

#[cfg(test)]
mod tests {
    use super::super::likelihood::log_prior;
    use super::*;

    #[test]
    fn draws_are_roads_and_steps_stay_near() {
        let mut random = Random::of_run(4, 0);
        let (mut walks, mut redraws) = (0, 0);
        for _ in 0..500 {
            let road = first(&mut random);
            assert!(log_prior(&road, 15.0).is_finite(), "{road:?}");
            let (next, step) = step(&road, [&road, &road], &mut random);
            match step {
                Step::Walk => {
                    walks += 1;
                    assert!((next.bends[0].from_m - road.bends[0].from_m).abs() < 40.0);
                }
                Step::Redraw => {
                    redraws += 1;
                    assert_eq!(next.edges_m, road.edges_m);
                    assert!(log_prior(&next, 15.0).is_finite());
                }
            }
        }
        assert!(walks > 400 && redraws > 30, "{walks} {redraws}");
    }
}
