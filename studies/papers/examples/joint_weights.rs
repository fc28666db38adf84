//! A search for weights of the paper's cost that fit better: for all of the paper's scenarios, or for one of them.
//!
//! ```text
//! cargo run --release -p papers --example joint_weights -- [SCENE|all] [EVALUATIONS] [SEED]
//! ```
//!
//! The score is the mean over the calibrated figures of `((ours - paper) / joint tolerance)²`. The search is over `Q1`,
//! `Q2`, `Q3`, `w`, `d_th` and the lead's acceleration in Table 3. The paper does not give that acceleration. `R` only
//! scales the cost and stays 1. Nelder-Mead works in the logarithms. It starts in turn from the best point with a fresh
//! simplex, and from the best of a random sample of plausible weights. The same arguments give the same result.
//! Scene A has B's figure too.
//!
//! The joint set is the scenario's default. It was calibrated with three figures that the paper does not print: two
//! durations of saturation and the first sample of a request. It has a score of 0.348. 13,000 evaluations found 0.308 at
//! Q = (236, 1662, 1.80), w = 3.47e6, d_th = 127 and a Table 3 lead of 2.369 m/s². Other starts end at 0.310 with Q1 =
//! 561 and at 0.332 with Q1 = 19.7. All lie in one valley, Q2/Q1 about 7 and w/Q1 about 1.5e4, and the joint set lies in
//! it, too. So the printed numbers fix these two ratios and not the five weights. The reference closed loops were made
//! with the joint set, and it stays.

use papers::cacc::{self, Calibration, PRINTED, Recording, Runs, SCENES, Weights};
use papers::row::Row;
use papers::runner::Driven;
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// Lead acceleration in Table 3 that goes with the joint weights, m/s²: that of the scenario.
const TABLE_3_LEAD_MPS2: f64 = 2.388;
const DIMENSIONS: usize = 6;
/// Points drawn before each descent from a new place.
const SAMPLE: usize = 60;
/// Smallest and largest plausible value: the single-scenario sets span most of it.
const BOX: [(f64, f64); DIMENSIONS] =
    [(0.5, 1500.0), (0.3, 1e4), (1e-3, 3.0), (1e3, 3e7), (20.0, 400.0), (2.2, 2.8)];

type Point = [f64; DIMENSIONS];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let of = arguments.next().unwrap_or_else(|| "all".into());
    let budget = arguments.next().map_or(3000, |a| a.parse().expect("EVALUATIONS is a number"));
    let seed = arguments.next().map_or(1, |a| a.parse().expect("SEED is a number"));

    let scene = SCENES.iter().find(|scene| scene.name == of);
    let given = scene.map_or(point(&joint(), TABLE_3_LEAD_MPS2), |scene| {
        point(&scene.fitted, cacc::TABLE_3_LEAD_MPS2)
    });
    let mut search = Search::new(of, budget, seed, given);
    println!("given: score {:.4}", search.best.1);
    let mut round = 0;
    while search.left > 0 {
        let centre = if round % 3 == 0 { search.best.0 } else { search.sample() };
        search.descend(centre, 0.3);
        round += 1;
        println!(
            "{:6} left: score {:.4} {:?}",
            search.left,
            search.best.1,
            search.best.0.map(libm::exp)
        );
    }
    search.report("given", &given);
    search.report("best", &search.best.0);
}

fn report(name: &str, at: &Point, rows: Vec<Row>) {
    let (weights, lead) = weights(at);
    println!("{name}: {weights:?}, lead in Table 3 {lead:.4} m/s²");
    for row in rows {
        let ours = row.ours.unwrap_or(f64::NAN);
        println!(
            "  {:26} {:7.2} {:7.2} {}",
            row.id,
            row.paper.unwrap_or(f64::NAN),
            ours,
            if row.ok { "" } else { "out" }
        );
    }
}

struct Search {
    /// Scene that is fitted, or `all`.
    of: String,
    left: usize,
    random: Pcg64Mcg,
    best: (Point, f64),
}

impl Search {
    fn new(of: String, left: usize, seed: u64, start: Point) -> Self {
        let best = (start, score(&evaluate(&of, &start)));
        Self { of, left, random: Pcg64Mcg::seed_from_u64(seed), best }
    }

    fn report(&self, name: &str, at: &Point) {
        report(name, at, evaluate(&self.of, at));
    }

    fn value(&mut self, at: &Point) -> f64 {
        self.left = self.left.saturating_sub(1);
        let value = score(&evaluate(&self.of, at));
        if value < self.best.1 {
            self.best = (*at, value);
        }
        value
    }

    fn unit(&mut self) -> f64 {
        random::uniform(&mut self.random)
    }

    /// The best of a sample of the box.
    fn sample(&mut self) -> Point {
        let mut best = (self.best.0, f64::INFINITY);
        for _ in 0..SAMPLE {
            let at = BOX.map(|(low, high)| {
                let (low, high) = (libm::log(low), libm::log(high));
                low + (high - low) * self.unit()
            });
            let value = self.value(&at);
            if value < best.1 {
                best = (at, value);
            }
        }
        best.0
    }

    /// One descent by the method of Nelder and Mead from a simplex around `centre`.
    fn descend(&mut self, centre: Point, spread: f64) {
        let mut simplex: Vec<(Point, f64)> = Vec::with_capacity(DIMENSIONS + 1);
        for i in 0..=DIMENSIONS {
            let mut at = centre;
            for x in &mut at {
                *x += spread * (2.0 * self.unit() - 1.0);
            }
            // The lead's acceleration is known to within a few percent.
            at[5] = centre[5] + 0.1 * (at[5] - centre[5]);
            if i == 0 {
                at = centre;
            }
            simplex.push((at, self.value(&at)));
        }
        for _ in 0..120 {
            if self.left == 0 {
                return;
            }
            simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
            let worst = simplex[DIMENSIONS];
            if worst.1 - simplex[0].1 < 1e-5 {
                return;
            }
            let mut middle = [0.0; DIMENSIONS];
            for (at, _) in &simplex[..DIMENSIONS] {
                for (m, x) in middle.iter_mut().zip(at) {
                    *m += x / DIMENSIONS as f64;
                }
            }
            let along = |t: f64| -> Point {
                std::array::from_fn(|i| middle[i] + t * (worst.0[i] - middle[i]))
            };
            let reflected = (along(-1.0), self.value(&along(-1.0)));
            if reflected.1 < simplex[0].1 {
                let expanded = (along(-2.0), self.value(&along(-2.0)));
                simplex[DIMENSIONS] = if expanded.1 < reflected.1 { expanded } else { reflected };
            } else if reflected.1 < simplex[DIMENSIONS - 1].1 {
                simplex[DIMENSIONS] = reflected;
            } else {
                let contracted = (along(0.5), self.value(&along(0.5)));
                if contracted.1 < worst.1 {
                    simplex[DIMENSIONS] = contracted;
                } else {
                    let best = simplex[0].0;
                    for corner in &mut simplex[1..] {
                        let at = std::array::from_fn(|j| 0.5 * (best[j] + corner.0[j]));
                        *corner = (at, self.value(&at));
                    }
                }
            }
        }
    }
}

/// The scenario's default.
fn joint() -> Weights {
    let default = scenario::controller::Weights::default();
    let [q1, q2, q3, w] =
        [default.q1, default.q2, default.q3, default.light_weight].map(|weight| weight.value());
    [q1, q2, q3, w, default.light_threshold_m.value()]
}

fn point([q1, q2, q3, w, d_th]: &Weights, lead_mps2: f64) -> Point {
    [*q1, *q2, *q3, *w, *d_th, lead_mps2].map(libm::log)
}

fn weights(at: &Point) -> (Weights, f64) {
    let [q1, q2, q3, w, d_th, lead] = at.map(libm::exp);
    ([q1, q2, q3, w, d_th], lead)
}

fn score(rows: &[Row]) -> f64 {
    let sum: f64 = rows
        .iter()
        .map(|row| {
            let tolerance = row.tolerance.filter(|tolerance| *tolerance > 0.0).unwrap_or(0.5);
            let off = row.ours.zip(row.paper).map(|(ours, paper)| ours - paper);
            let z = off.map_or(10.0, |off| off / tolerance);
            (z * z).min(100.0)
        })
        .sum();
    sum / rows.len() as f64
}

fn evaluate(of: &str, at: &Point) -> Vec<Row> {
    let (set, lead_mps2) = weights(at);
    let is_fitted = |scene: &str| of == "all" || of == scene || (of, scene) == ("A", "B");
    let scenes = SCENES.iter().filter(|scene| is_fitted(scene.name));
    let runs = scenes.map(|scene| {
        let set = cacc::settings(scene, &set, lead_mps2);
        let driven = cacc::both_laws(scene, &set, &|name, set| Driven::alone(name, set));
        (scene, driven.expect("the scenario drives to its end").each_ref().map(Recording::of))
    });
    let runs = Runs(runs.collect());
    let figures = PRINTED.iter().filter(|figure| runs.seen(figure.id).is_some());
    figures.map(|figure| figure.row(&runs, Calibration::Joint)).collect()
}
