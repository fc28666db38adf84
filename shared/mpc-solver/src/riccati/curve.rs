//! Costs of the light and of the rows as curves, and their tangents.
//!
//! `α ∈ −∂φ(D)` is a decreasing curve in the plane of the margin `D` and the multiplier `α`. It is flat at the penalty
//! `λ` up to the knee `√(w/λ)` (soft lights only). The hyperbola `w/D²` follows up to `d_th`. There it is vertical, and
//! flat at zero beyond.
//!
//! A row has the same curve without the hyperbola: `D = h − g'x` is its margin, and `d_th` and the knee are zero. Below
//! zero its multiplier grows by `κ`.
//!
//! A Newton step replaces the curve by its tangent at one point. The end of the step on the tangent is projected back
//! to the curve *by the coordinate that moves less*. That is `D` when the margin has grown, and `α` when it has shrunk.
//! On the hyperbola, the first could leave the domain and the second cross zero. This choice avoids both, so no line
//! search is needed. (Circuit simulators limit the steps of diodes in the same way.)
//!
//! A steep line replaces the vertical part, through the multiplier of the previous round. So the multiplier settles, and
//! the limit is met exactly. A steeper line needs fewer rounds. But it turns the rounding of a row's margin, some 1e-14
//! m, into an error of the multiplier. The optimality conditions require 1e-8 of the largest one. The slope of rows is
//! therefore [`STIFFNESS`] times that multiplier.

use crate::problem::{LightCost, Softness};

/// Cap on a first tangent's margin, as a fraction of the threshold, if the trajectory without the
/// light comes nearer. On the paper's drives 0.4 takes the fewest rounds of 0.3 to 0.6; random
/// problems show no difference.
const FIRST_MARGIN: f64 = 0.4;

/// Slope that replaces the vertical part of a row, in largest multipliers per unit of the limit.
pub(super) const STIFFNESS: f64 = 3e4;
/// Violation of a row without a force that counts as zero, relative to its limit or 1.
const TOLERANCE: f64 = 1e-10;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Curve {
    weight: f64,
    /// `1/w`.
    per_weight: f64,
    threshold: f64,
    /// `λ`; infinite for a hard light.
    penalty: f64,
    /// Largest `D` with `α = λ`; zero for a hard light.
    knee: f64,
    /// `α` at the upper end of the vertical part.
    top: f64,
    /// `κ`, which a row alone has.
    curvature: f64,
    /// Slope that replaces the vertical part.
    stiffness: f64,
    /// Distance that counts as 1 beside the vertical part.
    unit: f64,
    /// Margin below the threshold that still counts as clear.
    slack: f64,
}

/// Part of the curve, stored in a whole word. A tangent with one byte and seven unused ones is copied in pieces. Each
/// load then waits for the stores before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u64)]
enum Region {
    /// `D ≥ d_th`, `α = 0`.
    #[default]
    Clear,
    /// `D = d_th`.
    Edge,
    /// `α = w/D²`.
    Hyperbola,
    /// `α = λ`.
    Straight,
}

/// A tangent `α = alpha − slope (D − margin)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tangent {
    region: Region,
    margin: f64,
    alpha: f64,
    /// Slope, ≥ 0.
    pub(super) slope: f64,
}

impl Curve {
    pub(super) fn of_light(light: &LightCost) -> Self {
        let (w, d_th) = (light.weight, light.threshold);
        let (penalty, _) = light.softness.penalty();
        let top = (w / (d_th * d_th)).min(penalty);
        let stiffness = if d_th < f64::INFINITY { 1e5 * w / (d_th * d_th * d_th) } else { 0.0 };
        Self {
            weight: w,
            per_weight: 1.0 / w,
            threshold: d_th,
            penalty,
            knee: (w / penalty).sqrt().min(d_th),
            top,
            curvature: 0.0,
            stiffness,
            unit: d_th,
            slack: 0.0,
        }
    }

    /// Returns the curve of a row; `limit` is that of one stage.
    pub(super) fn of_row(softness: Softness, limit: f64, stiffness: f64) -> Self {
        let (penalty, curvature) = softness.penalty();
        let unit = limit.abs().max(1.0);
        let slack = TOLERANCE * unit;
        Self { penalty, curvature, top: penalty, stiffness, unit, slack, ..Self::default() }
    }

    /// Returns a first tangent. `margin` is the margin without the light, `best` the largest one on
    /// the horizon.
    pub(super) fn start(&self, margin: f64, best: f64) -> Tangent {
        if margin >= self.threshold {
            return self.clear();
        }
        let guess = best.clamp(0.1, FIRST_MARGIN * self.threshold);
        self.hyperbola_at(margin.max(guess))
    }

    /// Returns the tangent beyond the threshold.
    pub(super) fn clear(&self) -> Tangent {
        Tangent { region: Region::Clear, margin: self.threshold, alpha: 0.0, slope: 0.0 }
    }

    /// Returns the tangent at the threshold.
    pub(super) fn edge(&self, alpha: f64) -> Tangent {
        let slope = self.stiffness;
        Tangent {
            region: Region::Edge,
            margin: self.threshold,
            alpha: alpha.clamp(0.0, self.top),
            slope,
        }
    }

    /// Returns the tangent below the knee.
    pub(super) fn straight(&self) -> Tangent {
        Tangent {
            region: Region::Straight,
            margin: self.knee,
            alpha: self.penalty,
            slope: self.curvature,
        }
    }

    /// Returns the tangent at a margin on the hyperbola or below its knee.
    #[inline(always)]
    pub(super) fn hyperbola_at(&self, margin: f64) -> Tangent {
        if margin <= self.knee {
            return self.straight();
        }
        let per_margin = 1.0 / margin;
        let alpha = self.weight * (per_margin * per_margin);
        let slope = 2.0 * alpha * per_margin;
        Tangent { region: Region::Hyperbola, margin, alpha, slope }
    }

    #[inline(always)]
    fn hyperbola_with(&self, alpha: f64) -> Tangent {
        if alpha >= self.penalty {
            return self.straight();
        }
        let margin = (self.weight / alpha).sqrt();
        let slope = 2.0 * alpha * (margin * alpha) * self.per_weight;
        Tangent { region: Region::Hyperbola, margin, alpha, slope }
    }

    /// Projects the point of `tangent` at `margin` back to the curve. Returns the new tangent, the multiplier of the
    /// point, and its relative distance from the curve. The distance is 1 or more when the point changes to another
    /// part.
    #[inline(always)]
    pub(super) fn project(&self, tangent: &Tangent, margin: f64) -> (Tangent, f64, f64) {
        let alpha = tangent.alpha - tangent.slope * (margin - tangent.margin);
        let d_th = self.threshold;
        let next = match tangent.region {
            Region::Clear if margin >= d_th - self.slack => *tangent,
            Region::Clear => self.edge(0.0),
            Region::Straight if margin <= self.knee => *tangent,
            Region::Straight if margin < d_th => self.hyperbola_at(margin),
            Region::Straight => self.edge(self.top),
            Region::Hyperbola if margin >= d_th && alpha <= 0.0 => self.clear(),
            Region::Hyperbola if margin >= d_th => self.edge(alpha),
            Region::Hyperbola if margin >= tangent.margin => self.hyperbola_at(margin),
            Region::Hyperbola => self.hyperbola_with(alpha),
            Region::Edge if alpha <= 0.0 => self.clear(),
            Region::Edge if alpha <= self.top => self.edge(alpha),
            Region::Edge => self.hyperbola_with(alpha),
        };
        let distance = if next.region != tangent.region {
            1.0
        } else if next.region == Region::Hyperbola {
            let per_alpha = next.margin * next.margin * self.per_weight;
            (next.alpha - alpha).abs().max(next.slope * (margin - next.margin).abs()) * per_alpha
        } else if next.region == Region::Edge {
            (margin - d_th).abs() / self.unit
        } else {
            0.0
        };
        (next, alpha, distance)
    }
}

impl Tangent {
    /// Returns whether the tangent adds anything to the problem.
    #[inline(always)]
    pub(super) fn acts(&self) -> bool {
        self.region != Region::Clear
    }

    /// Returns `α` at the zero state, whose margin is `offset`.
    #[inline(always)]
    pub(super) fn at_origin(&self, offset: f64) -> f64 {
        self.alpha + self.slope * (self.margin - offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Softness;

    fn curve(softness: Softness) -> Curve {
        Curve::of_light(&LightCost { weight: 900.0, threshold: 30.0, softness })
    }

    /// Computes `min_D φ(D) + c D` one tangent at a time.
    fn minimise(curve: &Curve, c: f64, start: f64) -> (f64, usize) {
        let mut tangent = curve.hyperbola_at(start);
        for steps in 1..100 {
            // The tangent's α must equal c.
            let margin = tangent.margin + (tangent.alpha - c) / tangent.slope;
            let (next, _, distance) = curve.project(&tangent, margin);
            if distance < 1e-12 {
                return (margin, steps);
            }
            tangent = next;
        }
        panic!("not settled from {start}");
    }

    #[test]
    fn finds_the_minimum_from_any_start() {
        let hard = curve(Softness::Hard);
        for start in [0.01, 0.5, 3.0, 10.0, 29.0] {
            let (margin, steps) = minimise(&hard, 4.0, start);
            assert!((margin - 15.0).abs() < 1e-9, "{start}: {margin}");
            assert!(steps < 24, "{start}: {steps}");
        }
        // From above, where a plain Newton step would leave the domain.
        assert!(minimise(&hard, 4.0, 29.0).1 <= 6);
    }

    #[test]
    fn parts_meet_where_they_should() {
        let soft = curve(Softness::Soft { linear: 9.0, quadratic: 0.0 });
        assert_eq!(soft.knee, 10.0);
        assert_eq!(soft.top, 1.0);
        assert_eq!(soft.hyperbola_at(9.0).region, Region::Straight);
        assert_eq!(soft.hyperbola_with(9.5).region, Region::Straight);
        let (next, _, _) = soft.project(&soft.clear(), 29.0);
        assert_eq!(next.region, Region::Edge);
        let (next, alpha, _) = soft.project(&next, 30.0 - 2.0 / soft.stiffness);
        assert!((alpha - 2.0).abs() < 1e-9);
        assert_eq!(next.region, Region::Hyperbola);
    }

    /// Computes `min ½(z − a)² + ψ(z)` one tangent at a time: `z − a + μ = 0`.
    fn minimise_with_row(softness: Softness, a: f64) -> (f64, f64) {
        let curve = Curve::of_row(softness, 0.0, 1e8);
        let mut tangent = Tangent::default();
        for _ in 0..20 {
            let z = (a - tangent.at_origin(0.0)) / (1.0 + tangent.slope);
            let (next, mu, distance) = curve.project(&tangent, -z);
            if distance < 1e-12 {
                return (z, mu);
            }
            tangent = next;
        }
        panic!("not settled for {a}");
    }

    #[test]
    fn every_part_of_a_row_is_found() {
        let soft = Softness::Soft { linear: 2.0, quadratic: 3.0 };
        assert_eq!(minimise_with_row(soft, -1.0), (-1.0, 0.0));
        let (z, mu) = minimise_with_row(soft, 1.5);
        assert!(z.abs() < 1e-12 && (mu - 1.5).abs() < 1e-6, "{z} {mu}");
        let (z, mu) = minimise_with_row(soft, 10.0);
        assert!((z - 2.0).abs() < 1e-12 && (mu - 8.0).abs() < 1e-12, "{z} {mu}");
        let (z, mu) = minimise_with_row(Softness::Hard, 10.0);
        assert!(z.abs() < 1e-12 && (mu - 10.0).abs() < 1e-6, "{z} {mu}");
    }
}
