//! Backward sweep of the active set, stage by stage.
//!
//! The matrices are vectors, row by row ([`super::dynamics`]); their lower triangle holds the bits
//! of the upper one.

#![allow(unsafe_code, reason = "calls the version for the registers that the machine has")]

#[cfg(test)]
mod tests;

use super::dynamics::Dynamics;
use super::{
    CHAIN, CostToGo, Dual, GENERAL, Gain, InputModel, LinearQuadratic, PLAIN, STRIDE, Shape,
    StageModels, Sweep, resume,
};
use crate::problem::Problem;
#[cfg(target_arch = "x86_64")]
use crate::riccati::lanes::wide::{self, Wide};
use crate::riccati::lanes::{Lanes, Row, Vector};
use crate::riccati::matrix::{Rows, product};

/// Input of a sweep.
pub(super) struct Stages<'a, M> {
    pub(super) lq: &'a LinearQuadratic,
    pub(super) problem: &'a Problem,
    pub(super) models: &'a M,
    /// Last stage whose models differ from those of the previous sweep.
    pub(super) last: usize,
}

impl<M: StageModels> Stages<'_, M> {
    /// Performs [`LinearQuadratic::factor`].
    pub(super) fn sweep<const SHAPE: Shape, const DISTURBED: bool, const TERMINAL: bool>(
        &self,
        sweep: &mut Sweep,
    ) -> CostToGo {
        #[cfg(target_arch = "x86_64")]
        if wide::is_available() {
            // SAFETY: the machine has the instructions.
            return unsafe { self.sweep_wide::<SHAPE, DISTURBED, TERMINAL>(sweep) };
        }
        self.sweep_portable::<SHAPE, DISTURBED, TERMINAL>(sweep)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn sweep_wide<const SHAPE: Shape, const DISTURBED: bool, const TERMINAL: bool>(
        &self,
        sweep: &mut Sweep,
    ) -> CostToGo {
        if TERMINAL {
            self.sweep_by::<SHAPE, DISTURBED, Wide, Wide>(sweep)
        } else {
            self.sweep_by::<SHAPE, DISTURBED, Wide, f64>(sweep)
        }
    }

    fn sweep_portable<const SHAPE: Shape, const DISTURBED: bool, const TERMINAL: bool>(
        &self,
        sweep: &mut Sweep,
    ) -> CostToGo {
        if TERMINAL {
            self.sweep_by::<SHAPE, DISTURBED, Lanes, Lanes>(sweep)
        } else {
            self.sweep_by::<SHAPE, DISTURBED, Lanes, f64>(sweep)
        }
    }

    /// Performs the recursion in vectors `V`; the linear part is a vector (`Ψ | p`) or a number
    /// (`p`).
    #[inline(always)]
    fn sweep_by<const SHAPE: Shape, const DISTURBED: bool, V: Vector, R: Row<V>>(
        &self,
        sweep: &mut Sweep,
    ) -> CostToGo {
        let &Self { lq, problem, models, last } = self;
        let n = problem.horizon;
        let d = &problem.d[..n];
        let gains = &mut sweep.gains[..n];
        let (top, from) = resume(n, last);
        let (mut p, start) = if top < n {
            (Rows::<V>::new(&sweep.hessians[from]), sweep.costs[from])
        } else {
            let mut p = Rows::<V>::new(&lq.p);
            let [g0, g1, g2] = models.state(n, &mut p);
            let linear = [[1.0, 0.0, 0.0, g0], [0.0, 1.0, 0.0, g1], [0.0, 0.0, 1.0, g2]];
            (p, CostToGo { linear: linear.map(Lanes), ..CostToGo::default() })
        };
        let [l0, l1, l2] = start.linear;
        let mut linear =
            [R::of(V::from_array(l0.0)), R::of(V::from_array(l1.0)), R::of(V::from_array(l2.0))];
        let mut dual = Dual {
            diagonal: V::from_array(start.dual.diagonal.0),
            beside: V::from_array(start.dual.beside.0),
        };
        let mut reached = V::from_array(start.reached.0);
        let dynamics = Dynamics::<V>::new(lq);
        let [a00, a01, a02, a11, a12, a22] = lq.a;
        let (a00, a01, a02) = (R::splat(a00), R::splat(a01), R::splat(a02));
        let (a11, a12, a22) = (R::splat(a11), R::splat(a12), R::splat(a22));
        let q = Rows::<V>::new(&lq.q);
        let last_squared = lq.b[2] * lq.b[2];
        for k in (0..top).rev() {
            let pb = dynamics.times_b::<SHAPE>(&p);
            if DISTURBED {
                let [l0, l1, l2] = linear;
                let [d0, d1, d2] = d[k];
                if R::HAS_TERMINAL {
                    let moved = l0 * R::splat(d0) + l1 * R::splat(d1) + l2 * R::splat(d2);
                    reached = reached + moved.lanes();
                }
                let carried = product(&p.entries(), &d[k]);
                for i in 0..3 {
                    linear[i] = linear[i] + R::linear(carried[i]);
                }
            }
            let model = models.input(k);
            let (extra, slope) = match model {
                InputModel::Free(extra, slope) => (extra, slope),
                InputModel::Held(_, slope) => (0.0, slope),
            };
            let f = dynamics.crossed::<SHAPE>(pb);
            let mut next = q;
            let mut gradient = models.state(k, &mut next);
            let apa = dynamics.congruence::<SHAPE>(&p);
            let [l0, l1, l2] = linear;
            let mut beta = l2 * R::splat(lq.b[2]);
            if SHAPE < CHAIN {
                beta = beta + (l0 * R::splat(lq.b[0]) + l1 * R::splat(lq.b[1]));
            }
            let pull = beta + R::linear(slope);
            let (k0, k1) = if SHAPE != GENERAL { (l0, l1) } else { (a00 * l0, a11 * l1) };
            let ahead = if SHAPE == PLAIN { a12 * l1 } else { a02 * l0 + a12 * l1 };
            linear = [k0, a01 * l0 + k1, ahead + a22 * l2];
            for i in 0..3 {
                next.0[i] = next.0[i] + apa.0[i];
            }
            // Two paths of equal length lead from `P` to the next one. One is this division with a
            // product on either side, the other `A'P A`. The division stands where its result is
            // needed, so that it is not spilled to memory.
            let curvature = if SHAPE >= CHAIN {
                last_squared * p.0[2].to_array()[2]
            } else {
                let [p0, p1, p2, _] = pb.to_array();
                lq.input_of::<SHAPE>(&[p0, p1, p2])
            };
            let inverse = 1.0 / ((lq.r + extra) + curvature);
            let feedforward = pull * R::splat(inverse);
            let [f0, f1, f2, _] = f.to_array();
            let [e0, e1, e2, _] = (f * V::all(inverse)).to_array();
            let feedback = [e0, e1, e2];
            gains[k] = Gain { feedback, inverse, feedforward: feedforward.lanes().to_array() };
            if let InputModel::Held(u, _) = model {
                for (slope, f) in gradient.iter_mut().zip([f0, f1, f2]) {
                    *slope += f * u;
                }
                if R::HAS_TERMINAL {
                    reached = reached + (beta * R::splat(u)).lanes();
                }
            } else {
                for i in 0..3 {
                    next.0[i] = next.0[i] - (f.lane(i) * f) * V::all(inverse);
                    linear[i] = linear[i] - R::splat(feedback[i]) * pull;
                }
                if R::HAS_TERMINAL {
                    dual.add(beta.lanes(), feedforward.lanes());
                    reached = reached - beta.lanes() * feedforward.lanes().lane(3);
                }
            }
            p = next;
            for i in 0..3 {
                linear[i] = linear[i] + R::linear(gradient[i]);
            }
            if k % STRIDE == 0 {
                sweep.hessians[k / STRIDE] = p.entries();
                sweep.costs[k / STRIDE] = cost_to_go(linear, dual, reached);
            }
        }
        cost_to_go(linear, dual, reached)
    }
}

/// Returns the stored data of a stage.
#[inline(always)]
fn cost_to_go<V: Vector, R: Row<V>>([l0, l1, l2]: [R; 3], dual: Dual<V>, reached: V) -> CostToGo {
    let lanes = Lanes::from_vector::<V>;
    CostToGo {
        linear: [lanes(l0.lanes()), lanes(l1.lanes()), lanes(l2.lanes())],
        dual: Dual { diagonal: lanes(dual.diagonal), beside: lanes(dual.beside) },
        reached: lanes(reached),
    }
}
