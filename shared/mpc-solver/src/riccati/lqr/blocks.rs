//! Backward sweep of the interior point, in blocks of stages.
//!
//! It is the recursion at the head of [`super`] for a trajectory's change (no disturbance) with all inputs
//! free. For each block the caller first computes the models of its stages, lane by lane. Then follow the
//! matrix recursion and the vector recursion. `P` waits for one division per stage and for nothing else.
//! Models and vectors wait for `P` only from block to block, so the machine works on them in parallel. Merged
//! stage by stage, they would not fit into the registers.

use multiversion::multiversion;

use super::{CHAIN, CostToGo, GENERAL, Gain, INTEGRATING, LinearQuadratic, PLAIN, Shape, Sweep};
use crate::problem::{Problem, Terminal};
use crate::riccati::lanes::{Lanes, Row, WIDTH};
use crate::riccati::matrix::product;

/// Hessians and gradients of [`WIDTH`] stages: cost and models of the inequalities together.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::riccati) struct BlockModel {
    /// Hessian of the state: entries 00, 01, 02, 11, 12, 22.
    pub(in crate::riccati) hessian: [Lanes; 6],
    pub(in crate::riccati) gradient: [Lanes; 3],
    /// Curvature of the input, without the cost's `r`.
    pub(in crate::riccati) curvature: Lanes,
    pub(in crate::riccati) slope: Lanes,
}

/// Source of the models.
pub(in crate::riccati) trait BlockModels {
    /// Returns the model of the stages from `WIDTH · j` on; called once per block, last block
    /// first.
    fn block(&mut self, j: usize) -> BlockModel;
}

impl LinearQuadratic {
    /// Performs the sweep over the whole horizon.
    pub(in crate::riccati) fn factor_blocks<M: BlockModels>(
        &self,
        problem: &Problem,
        models: &mut M,
        sweep: &mut Sweep,
    ) -> CostToGo {
        let gains = &mut sweep.gains[..problem.horizon];
        match (self.shape, problem.terminal) {
            (PLAIN, Terminal::Cost) => backward::<PLAIN, f64, M>(self, models, gains),
            (PLAIN, Terminal::Equality(_)) => backward::<PLAIN, Lanes, M>(self, models, gains),
            (CHAIN, Terminal::Cost) => backward::<CHAIN, f64, M>(self, models, gains),
            (CHAIN, Terminal::Equality(_)) => backward::<CHAIN, Lanes, M>(self, models, gains),
            (INTEGRATING, Terminal::Cost) => backward::<INTEGRATING, f64, M>(self, models, gains),
            (INTEGRATING, Terminal::Equality(_)) => {
                backward::<INTEGRATING, Lanes, M>(self, models, gains)
            }
            _ => backward::<GENERAL, Lanes, M>(self, models, gains),
        }
    }
}

/// Data of a stage's model for the vector recursion.
#[derive(Clone, Copy, Debug, Default)]
struct StageVectors<R> {
    gradient: [R; 3],
    slope: R,
}

/// Performs [`LinearQuadratic::factor_blocks`].
#[multiversion(targets("x86_64+avx2"))]
fn backward<const SHAPE: Shape, R: Row<Lanes> + Default, M: BlockModels>(
    lq: &LinearQuadratic,
    models: &mut M,
    gains: &mut [Gain],
) -> CostToGo {
    let (last, end) = (gains.len() / WIDTH, gains.len() % WIDTH);
    let mut ring = [BlockModel::default(); 2];
    ring[last % 2] = models.block(last);
    let terminal = &ring[last % 2];
    let mut p = std::array::from_fn(|i| terminal.hessian[i].0[end]);
    let mut linear: [R; 3] = std::array::from_fn(|i| {
        let mut row = Lanes::default();
        row.0[i] = 1.0;
        row.0[3] = terminal.gradient[i].0[end];
        R::of(row)
    });
    let (mut dual, mut reached) = (super::Dual::default(), Lanes::default());
    let [a00, a01, a02, a11, a12, a22] = lq.a.map(R::splat);
    let b = lq.b.map(R::splat);
    let last_squared = lq.b[2] * lq.b[2];
    let mut vectors = [StageVectors::<R>::default(); WIDTH];
    for j in (0..=last).rev() {
        if j > 0 {
            ring[(j - 1) % 2] = models.block(j - 1);
        }
        let model = &ring[j % 2];
        let count = if j == last { end } else { WIDTH };
        let gains = &mut gains[WIDTH * j..WIDTH * j + count];
        let vectors = &mut vectors[..count];
        for (lane, (gain, stage)) in gains.iter_mut().zip(&mut *vectors).enumerate().rev() {
            let pb = if SHAPE >= CHAIN {
                [lq.b[2] * p[2], lq.b[2] * p[4], lq.b[2] * p[5]]
            } else {
                product(&p, &lq.b)
            };
            let curvature =
                if SHAPE >= CHAIN { last_squared * p[5] } else { lq.input_of::<SHAPE>(&pb) };
            let inverse = 1.0 / ((lq.r + model.curvature.0[lane]) + curvature);
            let f = lq.crossed::<SHAPE>(lq.transposed::<SHAPE>(&pb));
            let apa = lq.congruence::<SHAPE>(&p);
            let next = |i: usize| model.hessian[i].0[lane] + apa[i];
            p = [
                next(0) - (f[0] * f[0]) * inverse,
                next(1) - (f[0] * f[1]) * inverse,
                next(2) - (f[0] * f[2]) * inverse,
                next(3) - (f[1] * f[1]) * inverse,
                next(4) - (f[1] * f[2]) * inverse,
                next(5) - (f[2] * f[2]) * inverse,
            ];
            gain.feedback = [f[0] * inverse, f[1] * inverse, f[2] * inverse];
            gain.inverse = inverse;
            stage.slope = R::linear(model.slope.0[lane]);
            stage.gradient = std::array::from_fn(|i| R::linear(model.gradient[i].0[lane]));
        }
        for (gain, stage) in gains.iter_mut().zip(&*vectors).rev() {
            let [l0, l1, l2] = linear;
            let mut beta = l2 * b[2];
            if SHAPE < CHAIN {
                beta = beta + (l0 * b[0] + l1 * b[1]);
            }
            let pull = beta + stage.slope;
            let feedforward = pull * R::splat(gain.inverse);
            gain.feedforward = feedforward.lanes().0;
            let (k0, k1) = if SHAPE != GENERAL { (l0, l1) } else { (a00 * l0, a11 * l1) };
            let ahead = if SHAPE == PLAIN { a12 * l1 } else { a02 * l0 + a12 * l1 };
            linear = [k0, a01 * l0 + k1, ahead + a22 * l2];
            for i in 0..3 {
                linear[i] = (linear[i] - R::splat(gain.feedback[i]) * pull) + stage.gradient[i];
            }
            if R::HAS_TERMINAL {
                dual.add(beta.lanes(), feedforward.lanes());
                reached = reached - beta.lanes() * Lanes::all(feedforward.lanes().0[3]);
            }
        }
    }
    CostToGo { linear: linear.map(R::lanes), dual, reached }
}
