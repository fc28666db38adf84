//! Exact multipliers of the working rows: a convex program of at most [`MAX_WORKING_ROWS`]
//! unknowns.
//!
//! The sides of the inputs and the tangents of the light are fixed. The violations of the working
//! rows are then affine in their multipliers: `z(μ) = z̄ − S μ` with `S` symmetric positive
//! semidefinite. Each pair must lie on its row's graph:
//!
//! ```text
//! hard:  0 ≤ μ ⟂ z ≤ 0
//! soft:  the same for μ ≤ λ, and z = (μ − λ)/κ beyond (κ = 0: μ = λ, z ≥ 0)
//! ```
//!
//! These are the optimality conditions of `min ½ μ'S μ − z̄'μ + Σ_c θ_c(μ_c)` over `μ ≥ 0`, with
//! `θ_c(μ) = (μ − λ)²/2κ` beyond `λ` and zero below.
//!
//! Every multiplier lies on one [`Piece`] of its graph. Lawson and Hanson's method for bounded
//! least squares finds the pieces:
//!
//! 1. `LDL'` solves for the multipliers in the interior of their pieces.
//! 2. The step is cut at the first end of a piece.
//! 3. A multiplier at an end is released when the gradient shows that the cost falls.
//!
//! The cost falls with every change of pieces, so no set of pieces repeats in exact arithmetic.
//! Because of rounding, [`MAX_CHANGES`] bounds the number of changes. At the bound the attempt of
//! the active set is given up.

/// Largest number of rows treated at once.
pub(super) const MAX_WORKING_ROWS: usize = 8;
/// Largest number of changes of pieces: three for each multiplier.
const MAX_CHANGES: usize = 3 * MAX_WORKING_ROWS;
/// Fraction of the response without the terminal equality below which a row counts as unreachable.
const UNREACHABLE: f64 = 1e-11;

/// Part of a row's graph on which its multiplier lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Piece {
    /// `μ = 0`.
    #[default]
    Zero,
    /// `z = 0`, `0 ≤ μ ≤ λ`.
    Limit,
    /// `μ = λ + κ z`, `κ > 0`.
    Penalty,
    /// `μ = λ`, `κ = 0`.
    Ceiling,
}

/// The affine map `z(μ) = value − response · μ` and the graphs of the rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Complementarity {
    /// Number of rows.
    pub(super) len: usize,
    /// `S`.
    pub(super) response: [[f64; MAX_WORKING_ROWS]; MAX_WORKING_ROWS],
    /// Diagonal of `S` without the terminal equality.
    pub(super) scale: [f64; MAX_WORKING_ROWS],
    /// `z̄`.
    pub(super) value: [f64; MAX_WORKING_ROWS],
    /// `λ`, infinite for a hard row.
    pub(super) weight: [f64; MAX_WORKING_ROWS],
    /// `κ`.
    pub(super) curvature: [f64; MAX_WORKING_ROWS],
}

impl Complementarity {
    /// Solves for `multipliers`, starting from their values; `None` if [`MAX_CHANGES`] is reached.
    pub(super) fn solve(&self, multipliers: &mut [f64; MAX_WORKING_ROWS]) -> Option<()> {
        let mut pieces = [Piece::default(); MAX_WORKING_ROWS];
        for c in 0..self.len {
            pieces[c] = self.piece_of(c, &mut multipliers[c]);
        }
        for _ in 0..MAX_CHANGES {
            let target = self.stationary(&pieces, multipliers);
            match self.first_end(&pieces, multipliers, &target) {
                Some((c, part)) => {
                    for e in 0..self.len {
                        multipliers[e] += part * (target[e] - multipliers[e]);
                    }
                    self.leave(c, &mut pieces, multipliers, target[c]);
                }
                None => {
                    *multipliers = target;
                    match self.release(&pieces, multipliers) {
                        Some(c) => pieces[c] = Piece::Limit,
                        None => {
                            self.price_unreachable(multipliers);
                            return Some(());
                        }
                    }
                }
            }
        }
        None
    }

    fn is_reachable(&self, c: usize) -> bool {
        self.response[c][c] > UNREACHABLE * self.scale[c]
    }

    /// Sets the multiplier of an unreachable soft row to the slope of its penalty.
    fn price_unreachable(&self, multipliers: &mut [f64; MAX_WORKING_ROWS]) {
        for c in 0..self.len {
            if !self.is_reachable(c) && self.weight[c] < f64::INFINITY {
                let z = self.violation(c, multipliers);
                multipliers[c] = if z > 0.0 { self.weight[c] + self.curvature[c] * z } else { 0.0 };
            }
        }
    }

    fn piece_of(&self, c: usize, multiplier: &mut f64) -> Piece {
        if *multiplier <= 0.0 || !self.is_reachable(c) {
            *multiplier = 0.0;
            Piece::Zero
        } else if *multiplier < self.weight[c] {
            Piece::Limit
        } else if self.curvature[c] > 0.0 {
            Piece::Penalty
        } else {
            *multiplier = self.weight[c];
            Piece::Ceiling
        }
    }

    /// Returns the multipliers with zero gradient for all that are in the interior of their pieces.
    fn stationary(
        &self,
        pieces: &[Piece; MAX_WORKING_ROWS],
        multipliers: &[f64; MAX_WORKING_ROWS],
    ) -> [f64; MAX_WORKING_ROWS] {
        let mut inside = [0; MAX_WORKING_ROWS];
        let mut count = 0;
        for c in 0..self.len {
            if matches!(pieces[c], Piece::Limit | Piece::Penalty) {
                inside[count] = c;
                count += 1;
            }
        }
        let mut target = *multipliers;
        // LDL' row by row, with the right-hand side as a last column.
        let mut lower = [[0.0; MAX_WORKING_ROWS]; MAX_WORKING_ROWS];
        let mut diagonal = [0.0; MAX_WORKING_ROWS];
        let mut rhs = [0.0; MAX_WORKING_ROWS];
        for i in 0..count {
            let c = inside[i];
            let mut pivot = self.response[c][c] * (1.0 + UNREACHABLE);
            let mut value = self.value[c];
            for e in 0..self.len {
                if matches!(pieces[e], Piece::Zero | Piece::Ceiling) {
                    value -= self.response[c][e] * multipliers[e];
                }
            }
            if pieces[c] == Piece::Penalty {
                pivot += 1.0 / self.curvature[c];
                value += self.weight[c] / self.curvature[c];
            }
            let least = UNREACHABLE * pivot;
            for j in 0..i {
                let mut sum = self.response[c][inside[j]];
                for m in 0..j {
                    sum -= lower[i][m] * lower[j][m] * diagonal[m];
                }
                lower[i][j] = sum / diagonal[j];
                pivot -= lower[i][j] * sum;
                value -= lower[i][j] * rhs[j];
            }
            diagonal[i] = pivot.max(least);
            rhs[i] = value;
        }
        for i in (0..count).rev() {
            let mut sum = rhs[i] / diagonal[i];
            for j in i + 1..count {
                sum -= lower[j][i] * target[inside[j]];
            }
            target[inside[i]] = sum;
        }
        target
    }

    /// Finds the multiplier that first reaches the end of its piece on the way to `target`. Also returns the fraction
    /// of the way.
    fn first_end(
        &self,
        pieces: &[Piece; MAX_WORKING_ROWS],
        from: &[f64; MAX_WORKING_ROWS],
        target: &[f64; MAX_WORKING_ROWS],
    ) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for c in 0..self.len {
            let end = match pieces[c] {
                Piece::Limit if target[c] < 0.0 => 0.0,
                Piece::Limit | Piece::Penalty
                    if (target[c] > self.weight[c]) == (pieces[c] == Piece::Limit) =>
                {
                    self.weight[c]
                }
                _ => continue,
            };
            if target[c] == end {
                continue;
            }
            let part = ((end - from[c]) / (target[c] - from[c])).clamp(0.0, 1.0);
            if first.is_none_or(|(_, least)| part < least) {
                first = Some((c, part));
            }
        }
        first
    }

    /// Moves multiplier `c` across the end of its piece.
    fn leave(
        &self,
        c: usize,
        pieces: &mut [Piece; MAX_WORKING_ROWS],
        multipliers: &mut [f64; MAX_WORKING_ROWS],
        target: f64,
    ) {
        (pieces[c], multipliers[c]) = match pieces[c] {
            Piece::Limit if target < 0.0 => (Piece::Zero, 0.0),
            Piece::Limit if self.curvature[c] > 0.0 => (Piece::Penalty, self.weight[c]),
            Piece::Limit => (Piece::Ceiling, self.weight[c]),
            _ => (Piece::Limit, self.weight[c]),
        };
    }

    /// Finds the multiplier at an end of its graph whose release reduces the cost fastest.
    fn release(
        &self,
        pieces: &[Piece; MAX_WORKING_ROWS],
        multipliers: &[f64; MAX_WORKING_ROWS],
    ) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for c in 0..self.len {
            let inward = match pieces[c] {
                Piece::Zero => 1.0,
                Piece::Ceiling => -1.0,
                Piece::Limit | Piece::Penalty => continue,
            };
            if !self.is_reachable(c) {
                continue;
            }
            let z = self.violation(c, multipliers);
            // The cost along this multiplier alone falls by z²/2S.
            let fall = inward * z * z.abs() / self.response[c][c];
            let tiny = 1e-13 * self.value[c].abs();
            if inward * z > tiny && best.is_none_or(|(_, most)| fall > most) {
                best = Some((c, fall));
            }
        }
        best.map(|(c, _)| c)
    }

    /// `z_c`.
    fn violation(&self, c: usize, multipliers: &[f64; MAX_WORKING_ROWS]) -> f64 {
        let mut z = self.value[c];
        for e in 0..self.len {
            z -= self.response[c][e] * multipliers[e];
        }
        z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows whose responses overlap; the second one is soft with penalty weight 1.
    fn program(value: [f64; 2], curvature: f64) -> Complementarity {
        let mut program = Complementarity { len: 2, ..Complementarity::default() };
        program.response[0][..2].copy_from_slice(&[2.0, 1.0]);
        program.response[1][..2].copy_from_slice(&[1.0, 3.0]);
        program.scale[..2].copy_from_slice(&[2.0, 3.0]);
        program.value[..2].copy_from_slice(&value);
        program.weight[..2].copy_from_slice(&[f64::INFINITY, 1.0]);
        program.curvature[1] = curvature;
        program
    }

    /// Distance of the pairs from their graphs.
    fn residual(program: &Complementarity, mu: &[f64; MAX_WORKING_ROWS]) -> f64 {
        let mut worst: f64 = 0.0;
        for c in 0..program.len {
            let z = program.violation(c, mu);
            let (weight, curvature) = (program.weight[c], program.curvature[c]);
            let distance = if z > 1e-9 {
                (mu[c] - weight - curvature * z).abs()
            } else if z < -1e-9 {
                mu[c].abs()
            } else {
                (-mu[c]).max(mu[c] - weight).max(0.0)
            };
            worst = worst.max(distance);
        }
        worst
    }

    #[test]
    fn every_pair_ends_on_its_graph_from_any_start() {
        for curvature in [0.0, 0.5, 40.0] {
            for i in -6_i32..=6 {
                for j in -6_i32..=6 {
                    let program = program([0.7 * f64::from(i), 1.1 * f64::from(j)], curvature);
                    for start in [[0.0, 0.0], [5.0, 0.5], [0.1, 9.0]] {
                        let mut mu = [0.0; MAX_WORKING_ROWS];
                        mu[..2].copy_from_slice(&start);
                        program.solve(&mut mu).expect("two rows need few changes");
                        let found = residual(&program, &mu);
                        assert!(found < 1e-8, "{i} {j} {curvature} {start:?}: {mu:?} {found:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_row_that_cannot_be_influenced_has_no_multiplier_but_the_price_of_its_violation() {
        let mut program = program([1.0, 1.0], 0.5);
        program.response = Default::default();
        let mut mu = [3.0; MAX_WORKING_ROWS];
        program.solve(&mut mu).expect("there is nothing to change");
        assert_eq!(mu[..2], [0.0, 1.5]);
        program.value = [0.0; MAX_WORKING_ROWS];
        program.solve(&mut mu).expect("there is nothing to change");
        assert_eq!(mu[..2], [0.0, 0.0]);
    }
}
