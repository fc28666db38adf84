//! Backward sweep in blocks of stages.
//!
//! For each block the caller first computes the models of its stages, lane by lane. Then follow the matrix recursion and
//! the vector recursion. `P` waits for one division per stage and for nothing else. Models and vectors wait for `P` only
//! from block to block, so the machine works on them in parallel. Merged stage by stage, they would not fit into the
//! registers.

use multiversion::multiversion;

use super::cost::{BlockModel, Cost};
use super::{CHAIN, CostToGo, GENERAL, LinearQuadratic, STRIDE, Shape, Sweep, resume};
use crate::problem::{Problem, Terminal};
use crate::riccati::lanes::{Lanes, Row, WIDTH};
use crate::riccati::matrix::product;

pub(in crate::riccati) trait BlockModels {
    /// True for the trajectory itself. It has disturbances and held inputs, and a sweep can be resumed. A change of the
    /// trajectory has neither.
    const IS_WHOLE: bool;

    /// Returns the model of the stages from `WIDTH · j` on; called once per block, last block
    /// first.
    fn block(&mut self, j: usize) -> BlockModel;

    /// Returns the value at which input `k` is held.
    fn held(&self, _k: usize) -> Option<f64> {
        None
    }
}

/// The cost alone, with free inputs.
pub(in crate::riccati) struct Unconstrained<'a>(pub(in crate::riccati) &'a Cost);

impl BlockModels for Unconstrained<'_> {
    const IS_WHOLE: bool = true;

    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        self.0.block(j)
    }
}

impl LinearQuadratic {
    /// Performs the backward sweep.
    ///
    /// `last` is the last stage whose models differ from those of the previous sweep; `N` reuses
    /// nothing.
    #[inline(always)]
    pub(in crate::riccati) fn factor<M: BlockModels>(
        &self,
        problem: &Problem,
        models: &mut M,
        sweep: &mut Sweep,
        last: usize,
    ) -> CostToGo {
        let is_fixed = matches!(problem.terminal, Terminal::Equality(_));
        match (self.shape, is_fixed) {
            (CHAIN, false) => backward::<CHAIN, f64, M>(self, problem, models, sweep, last),
            (CHAIN, true) => backward::<CHAIN, Lanes, M>(self, problem, models, sweep, last),
            (_, false) => backward::<GENERAL, f64, M>(self, problem, models, sweep, last),
            (_, true) => backward::<GENERAL, Lanes, M>(self, problem, models, sweep, last),
        }
    }
}

/// Data of a stage for the vector recursion.
#[derive(Clone, Copy, Debug, Default)]
struct StageVectors<R> {
    gradient: [R; 3],
    slope: R,
    held: Option<f64>,
    /// `P_{k+1} d_k`.
    carried: [f64; 3],
}

#[multiversion(targets("x86_64+avx2"))]
fn backward<const SHAPE: Shape, R: Row + Default, M: BlockModels>(
    lq: &LinearQuadratic,
    problem: &Problem,
    models: &mut M,
    sweep: &mut Sweep,
    last: usize,
) -> CostToGo {
    let Sweep { gains, hessians, costs } = sweep;
    let is_disturbed = M::IS_WHOLE && lq.has_disturbance;
    let (top, from) = resume(problem.horizon, last);
    let (last, end) = (top / WIDTH, top % WIDTH);
    let mut ring = [BlockModel::default(); 2];
    let (mut p, start) = if top < problem.horizon {
        (hessians[from], costs[from])
    } else {
        let terminal = models.block(last);
        ring[last % 2] = terminal;
        let g = terminal.gradient.map(|lanes| lanes.0[end]);
        let linear = [[1.0, 0.0, 0.0, g[0]], [0.0, 1.0, 0.0, g[1]], [0.0, 0.0, 1.0, g[2]]];
        let start = CostToGo { linear: linear.map(Lanes), ..CostToGo::default() };
        (terminal.hessian.map(|lanes| lanes.0[end]), start)
    };
    let mut linear = start.linear.map(R::of);
    let (mut dual, mut reached) = (start.dual, start.reached);
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
            if is_disturbed {
                stage.carried = product(&p, &problem.d[WIDTH * j + lane]);
            }
            let pb = if SHAPE >= CHAIN {
                [lq.b[2] * p[2], lq.b[2] * p[4], lq.b[2] * p[5]]
            } else {
                product(&p, &lq.b)
            };
            let curvature =
                if SHAPE >= CHAIN { last_squared * p[5] } else { lq.input_of::<SHAPE>(&pb) };
            let inverse = 1.0 / ((lq.r + model.curvature.0[lane]) + curvature);
            let ahead = lq.transposed::<SHAPE>(&pb);
            let f: [f64; 3] = std::array::from_fn(|i| ahead[i] + lq.s[i]);
            let apa = lq.congruence::<SHAPE>(&p);
            let next = |i: usize| model.hessian[i].0[lane] + apa[i];
            let mut gradient = model.gradient.map(|lanes| lanes.0[lane]);
            stage.held = if M::IS_WHOLE { models.held(WIDTH * j + lane) } else { None };
            p = if let Some(u) = stage.held {
                for i in 0..3 {
                    gradient[i] += f[i] * u;
                }
                std::array::from_fn(next)
            } else {
                [
                    next(0) - (f[0] * f[0]) * inverse,
                    next(1) - (f[0] * f[1]) * inverse,
                    next(2) - (f[0] * f[2]) * inverse,
                    next(3) - (f[1] * f[1]) * inverse,
                    next(4) - (f[1] * f[2]) * inverse,
                    next(5) - (f[2] * f[2]) * inverse,
                ]
            };
            gain.feedback = [f[0] * inverse, f[1] * inverse, f[2] * inverse];
            gain.inverse = inverse;
            stage.slope = R::linear(model.slope.0[lane]);
            stage.gradient = gradient.map(R::linear);
        }
        for (lane, (gain, stage)) in gains.iter_mut().zip(&*vectors).enumerate().rev() {
            if is_disturbed {
                let [d0, d1, d2] = problem.d[WIDTH * j + lane].map(R::splat);
                if R::HAS_TERMINAL {
                    let moved = linear[0] * d0 + linear[1] * d1 + linear[2] * d2;
                    reached = reached + moved.lanes();
                }
                for i in 0..3 {
                    linear[i] = linear[i] + R::linear(stage.carried[i]);
                }
            }
            let [l0, l1, l2] = linear;
            let mut beta = l2 * b[2];
            if SHAPE < CHAIN {
                beta = beta + (l0 * b[0] + l1 * b[1]);
            }
            let pull = beta + stage.slope;
            let feedforward = pull * R::splat(gain.inverse);
            gain.feedforward = feedforward.lanes().0;
            let (k0, k1) = if SHAPE != GENERAL { (l0, l1) } else { (a00 * l0, a11 * l1) };
            linear = [k0, a01 * l0 + k1, a02 * l0 + a12 * l1 + a22 * l2];
            for i in 0..3 {
                if stage.held.is_none() {
                    linear[i] = linear[i] - R::splat(gain.feedback[i]) * pull;
                }
                linear[i] = linear[i] + stage.gradient[i];
            }
            if R::HAS_TERMINAL {
                if let Some(u) = stage.held {
                    reached = reached + beta.lanes() * Lanes::all(u);
                } else {
                    dual.add(beta.lanes(), feedforward.lanes());
                    reached = reached - beta.lanes() * Lanes::all(feedforward.lanes().0[3]);
                }
            }
        }
        if M::IS_WHOLE && (WIDTH * j).is_multiple_of(STRIDE) {
            hessians[WIDTH * j / STRIDE] = p;
            costs[WIDTH * j / STRIDE] = CostToGo { linear: linear.map(R::lanes), dual, reached };
        }
    }
    CostToGo { linear: linear.map(R::lanes), dual, reached }
}
