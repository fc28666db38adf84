//! Exact multipliers of a few inequalities: a convex program of at most `M` unknowns.
//!
//! The violations of the members are affine in their multipliers: `z(μ) = z̄ − S μ` with `S` symmetric positive
//! semidefinite. Each pair must lie on its member's graph:
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
//! Because of rounding, the number of changes is bounded: three for each multiplier. At the bound the attempt is given
//! up.
//!
//! The factors are kept. A change of pieces renews them from the first member on that it concerns.

/// Fraction of the response without the terminal equality below which a member counts as unreachable.
pub(super) const UNREACHABLE: f64 = 1e-11;

/// Part of a member's graph on which its multiplier lies.
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

/// The affine map `z(μ) = value − response · μ`, the graphs of the members, and the factors.
#[derive(Clone, Debug)]
pub(super) struct Complementarity<const M: usize> {
    ridge: f64,
    pub(super) len: usize,
    /// `S`.
    pub(super) response: [[f64; M]; M],
    /// Diagonal of `S` without the terminal equality.
    pub(super) scale: [f64; M],
    /// `z̄`.
    pub(super) value: [f64; M],
    /// `λ`, infinite for a hard row.
    pub(super) weight: [f64; M],
    /// `κ`.
    pub(super) curvature: [f64; M],
    /// `μ`.
    pub(super) multipliers: [f64; M],
    pieces: [Piece; M],
    /// Members of the factors with their pieces, and their number.
    factored: [(usize, Piece); M],
    count: usize,
    /// `L'` row by row, and `1/D`.
    upper: [[f64; M]; M],
    inverse: [f64; M],
    /// Multipliers with zero gradient for all that are in the interior of their pieces.
    target: [f64; M],
    /// Right-hand side of the factors, and a row of them.
    rhs: [f64; M],
    row: [f64; M],
}

impl<const M: usize> Complementarity<M> {
    /// Returns a program without members. `ridge` is the fraction of their diagonal that keeps dependent members apart.
    pub(super) fn new(ridge: f64) -> Self {
        Self {
            ridge,
            len: 0,
            response: [[0.0; M]; M],
            scale: [0.0; M],
            value: [0.0; M],
            weight: [0.0; M],
            curvature: [0.0; M],
            multipliers: [0.0; M],
            pieces: [Piece::Zero; M],
            factored: [(0, Piece::Zero); M],
            count: 0,
            upper: [[0.0; M]; M],
            inverse: [0.0; M],
            target: [0.0; M],
            rhs: [0.0; M],
            row: [0.0; M],
        }
    }

    /// Removes all members and the factors.
    pub(super) fn clear(&mut self) {
        (self.len, self.count) = (0, 0);
    }

    /// Solves for the multipliers, starting from their values; `None` if the changes run out.
    #[inline(always)]
    pub(super) fn solve(&mut self) -> Option<()> {
        for c in 0..self.len {
            (self.pieces[c], self.multipliers[c]) = self.piece_of(c);
        }
        for _ in 0..3 * M {
            self.aim();
            let len = self.len;
            let Some((c, part)) = self.first_end() else {
                self.multipliers[..len].copy_from_slice(&self.target[..len]);
                let Some(c) = self.release() else {
                    self.price_unreachable();
                    return Some(());
                };
                self.pieces[c] = Piece::Limit;
                continue;
            };
            for (mu, target) in self.multipliers[..len].iter_mut().zip(&self.target) {
                *mu += part * (target - *mu);
            }
            self.leave(c);
        }
        None
    }

    fn is_reachable(&self, c: usize) -> bool {
        self.response[c][c] > UNREACHABLE * self.scale[c]
    }

    /// Sets the multiplier of an unreachable soft row to the slope of its penalty.
    fn price_unreachable(&mut self) {
        for c in 0..self.len {
            if !self.is_reachable(c) && self.weight[c] < f64::INFINITY {
                let z = self.violation(c);
                self.multipliers[c] =
                    if z > 0.0 { self.weight[c] + self.curvature[c] * z } else { 0.0 };
            }
        }
    }

    /// Returns the piece of a multiplier, and the multiplier on it.
    fn piece_of(&self, c: usize) -> (Piece, f64) {
        let multiplier = self.multipliers[c];
        if multiplier <= 0.0 || !self.is_reachable(c) {
            (Piece::Zero, 0.0)
        } else if multiplier < self.weight[c] {
            (Piece::Limit, multiplier)
        } else if self.curvature[c] > 0.0 {
            (Piece::Penalty, multiplier)
        } else {
            (Piece::Ceiling, self.weight[c])
        }
    }

    #[inline(always)]
    fn aim(&mut self) {
        self.factor();
        let (n, len) = (self.count, self.len);
        let Self { factored, rhs, target, multipliers, response, .. } = self;
        target[..len].copy_from_slice(&multipliers[..len]);
        for (slot, &(c, piece)) in rhs.iter_mut().zip(&factored[..n]) {
            *slot = self.value[c];
            if piece == Piece::Penalty {
                *slot += self.weight[c] / self.curvature[c];
            }
        }
        for e in 0..len {
            if self.pieces[e] == Piece::Ceiling {
                for (slot, &(c, _)) in rhs.iter_mut().zip(&factored[..n]) {
                    *slot -= response[c][e] * multipliers[e];
                }
            }
        }
        let rhs = &mut rhs[..n];
        for i in 0..n {
            let above = rhs[i];
            for (slot, factor) in rhs[i + 1..].iter_mut().zip(&self.upper[i][i + 1..n]) {
                *slot -= factor * above;
            }
        }
        for i in (0..n).rev() {
            let behind = self.upper[i][i + 1..n].iter().zip(&rhs[i + 1..]);
            let sum = behind.fold(rhs[i] * self.inverse[i], |sum, (factor, x)| sum - factor * x);
            rhs[i] = sum;
            target[factored[i].0] = sum;
        }
    }

    /// Factors the response of the members in the interior of their pieces. Those that did not change keep their rows.
    #[inline(always)]
    fn factor(&mut self) {
        let before = self.count;
        self.count = 0;
        let mut is_same = true;
        for c in 0..self.len {
            let piece = self.pieces[c];
            if !matches!(piece, Piece::Limit | Piece::Penalty) {
                continue;
            }
            let i = self.count;
            self.count += 1;
            is_same = is_same && i < before && self.factored[i] == (c, piece);
            if is_same {
                continue;
            }
            self.factored[i] = (c, piece);
            let mut pivot = self.response[c][c] * (1.0 + self.ridge);
            if piece == Piece::Penalty {
                pivot += 1.0 / self.curvature[c];
            }
            let least = UNREACHABLE * pivot;
            let row = &mut self.row[..i];
            for (slot, (e, _)) in row.iter_mut().zip(&self.factored) {
                *slot = self.response[c][*e];
            }
            for j in 0..i {
                let above = row[j];
                let factor = above * self.inverse[j];
                pivot -= factor * above;
                let upper = &mut self.upper[j];
                for (slot, upper) in row[j + 1..].iter_mut().zip(&upper[j + 1..i]) {
                    *slot -= above * upper;
                }
                upper[i] = factor;
            }
            self.inverse[i] = 1.0 / pivot.max(least);
        }
    }

    /// Finds the multiplier that first reaches the end of its piece on the way to `target`. Also returns the fraction
    /// of the way.
    fn first_end(&self) -> Option<(usize, f64)> {
        let target = &self.target;
        let mut first: Option<(usize, f64)> = None;
        for c in 0..self.len {
            let end = match self.pieces[c] {
                Piece::Limit if target[c] < 0.0 => 0.0,
                Piece::Limit | Piece::Penalty
                    if (target[c] > self.weight[c]) == (self.pieces[c] == Piece::Limit) =>
                {
                    self.weight[c]
                }
                _ => continue,
            };
            if target[c] == end {
                continue;
            }
            let from = self.multipliers[c];
            let part = ((end - from) / (target[c] - from)).clamp(0.0, 1.0);
            if first.is_none_or(|(_, least)| part < least) {
                first = Some((c, part));
            }
        }
        first
    }

    /// Moves multiplier `c` across the end of its piece.
    fn leave(&mut self, c: usize) {
        (self.pieces[c], self.multipliers[c]) = match self.pieces[c] {
            Piece::Limit if self.target[c] < 0.0 => (Piece::Zero, 0.0),
            Piece::Limit if self.curvature[c] > 0.0 => (Piece::Penalty, self.weight[c]),
            Piece::Limit => (Piece::Ceiling, self.weight[c]),
            _ => (Piece::Limit, self.weight[c]),
        };
    }

    /// Finds the multiplier at an end of its graph whose release reduces the cost fastest.
    fn release(&self) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for c in 0..self.len {
            let inward = match self.pieces[c] {
                Piece::Zero => 1.0,
                Piece::Ceiling => -1.0,
                Piece::Limit | Piece::Penalty => continue,
            };
            if !self.is_reachable(c) {
                continue;
            }
            let z = self.violation(c);
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
    fn violation(&self, c: usize) -> f64 {
        let members = self.response[c][..self.len].iter().zip(&self.multipliers);
        members.fold(self.value[c], |z, (response, multiplier)| z - response * multiplier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows whose responses overlap; the second one is soft with penalty weight 1.
    fn program(value: [f64; 2], curvature: f64) -> Complementarity<8> {
        let mut program = Complementarity::new(UNREACHABLE);
        program.len = 2;
        program.response[0][..2].copy_from_slice(&[2.0, 1.0]);
        program.response[1][..2].copy_from_slice(&[1.0, 3.0]);
        program.scale[..2].copy_from_slice(&[2.0, 3.0]);
        program.value[..2].copy_from_slice(&value);
        program.weight[..2].copy_from_slice(&[f64::INFINITY, 1.0]);
        program.curvature[1] = curvature;
        program
    }

    /// Distance of the pairs from their graphs.
    fn residual(program: &Complementarity<8>) -> f64 {
        let mu = &program.multipliers;
        let mut worst: f64 = 0.0;
        for c in 0..program.len {
            let z = program.violation(c);
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
                    let mut program = program([0.7 * f64::from(i), 1.1 * f64::from(j)], curvature);
                    for start in [[0.0, 0.0], [5.0, 0.5], [0.1, 9.0]] {
                        program.multipliers[..2].copy_from_slice(&start);
                        program.solve().expect("two rows need few changes");
                        let (mu, found) = (program.multipliers, residual(&program));
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
        program.multipliers = [3.0; 8];
        program.solve().expect("there is nothing to change");
        assert_eq!(program.multipliers[..2], [0.0, 1.5]);
        program.value = [0.0; 8];
        program.solve().expect("there is nothing to change");
        assert_eq!(program.multipliers[..2], [0.0, 0.0]);
    }
}
