//! The stage-wise recursion that both methods stand on.
//!
//! With the inputs that are held at a bound taken out and every inequality replaced by a quadratic
//! model, what remains is a linear-quadratic problem. Its cost-to-go from stage `k`, with the
//! multiplier `y` of `x_N = x_f` kept open, is
//!
//! ```text
//! V_k(x, y) = ½ x'P_k x + p_k'x + y'(Ψ_k'x + t_k − x_f) − ½ y'W_k y + const,
//! P_N = P, p_N = p, Ψ_N = I, t_N = 0, W_N = 0.
//! ```
//!
//! With `h = p_{k+1} + P_{k+1}d_k` and the stage's own Hessian and gradient (`Q̂`, `q̂`, `r̂`, `ρ̂`: cost plus
//! models of the inequalities), one step backwards is
//!
//! ```text
//! F = B'P_{k+1}A + s'      δ = r̂ + B'P_{k+1}B      f = B'h + ρ̂      β = B'Ψ_{k+1}
//! u_k = −(F x_k + f + β y)/δ                                             (input free)
//! P_k = Q̂ + A'P_{k+1}A − F'F/δ          p_k = q̂ + A'h − F'f/δ
//! Ψ_k = A'Ψ_{k+1} − F'β/δ               W_k = W_{k+1} + β'β/δ
//! t_k = t_{k+1} + Ψ_{k+1}'d_k − β'f/δ
//! ```
//!
//! and with `u_k` held at `ū` the fractions go, `h` becomes `h + P_{k+1}B ū`, `ρ̂` drops out, `q̂` gains `s ū` and
//! `t_k` gains `β'ū`. Then `V_0` is stationary in `y` at `W_0 y = Ψ_0'x_0 + t_0 − x_f`, and one sweep forwards gives
//! the trajectory. One division per stage; nothing is stored but the gains.

use crate::problem::{Problem, Terminal};

/// Symmetric 3×3: 00, 01, 02, 11, 12, 22.
pub(super) type Sym = [f64; 6];

/// The constant part of a problem, unpacked for the recursion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plant {
    a: Sym,
    b: [f64; 3],
    q: Sym,
    s: [f64; 3],
    r: f64,
    p: Sym,
    /// Whether the input acts on the last state only.
    pub(super) last_only: bool,
    /// Whether any `d_k` is not zero.
    driven: bool,
}

/// What a stage's input costs, besides its curvature `r` and the cost of state times input.
#[derive(Clone, Copy, Debug)]
pub(super) enum InputModel {
    /// Curvature to add to `r`, and the gradient.
    Free(f64, f64),
    /// Held at this value; the gradient.
    Held(f64, f64),
}

/// The models that turn a stage of the problem into a linear-quadratic one. Its unknowns may be the
/// trajectory itself or a change of one: then there is no disturbance.
pub(super) trait Models {
    /// Whether the disturbances count.
    const DRIVEN: bool;

    /// Model of `u_k`.
    fn input(&self, k: usize) -> InputModel;

    /// Gradient of the cost of `x_k`, apart from that of the functions.
    fn gradient(&self, k: usize) -> [f64; 3];

    /// Calls back with gradient, curvature and force of each function of `x_k`, `k ≥ 1`.
    fn functions(&self, k: usize, add: impl FnMut(&[f64; 3], f64, f64));
}

/// Three states by four lanes: the columns of `Ψ`, and a vector that obeys the same recursion.
pub(super) type Lanes = [[f64; 4]; 3];

/// What the forward sweep needs of a stage: `u = −(feedback·x + constant + pin·y)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gain {
    pub(super) feedback: [f64; 3],
    /// `1/δ`.
    pub(super) inverse: f64,
    /// `pin` and, last, `constant`.
    pub(super) open: [f64; 4],
}

/// The linear and dual parts of the cost-to-go at some stage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Open {
    /// `Ψ | p`.
    linear: Lanes,
    /// `W | −t`, row by row.
    dual: Lanes,
}

/// Stages between two stored costs-to-go.
const STRIDE: usize = 8;

/// Gains of all stages, and costs-to-go from which a sweep can be taken up again.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    pub(super) gains: Vec<Gain>,
    /// `P_{k+1} d_k`.
    carried: Vec<[f64; 3]>,
    /// Entry `i` belongs to stage `STRIDE · i`.
    hessians: Vec<Sym>,
    opens: Vec<Open>,
}

impl Sweep {
    pub(super) fn new(max_horizon: usize) -> Self {
        let stored = max_horizon / STRIDE + 1;
        Self {
            gains: vec![Gain::default(); max_horizon],
            carried: vec![[0.0; 3]; max_horizon],
            hessians: vec![[0.0; 6]; stored],
            opens: vec![Open::default(); stored],
        }
    }
}

impl Plant {
    pub(super) fn new(problem: &Problem) -> Self {
        let upper = |m: &[[f64; 3]; 3]| [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]];
        Self {
            a: upper(&problem.a),
            b: problem.b,
            q: upper(&problem.q),
            s: problem.s,
            r: problem.r,
            p: upper(&problem.p),
            last_only: problem.b[0] == 0.0 && problem.b[1] == 0.0,
            driven: problem.d[..problem.horizon].iter().any(|d| *d != [0.0; 3]),
        }
    }

    /// `A'v`.
    #[inline(always)]
    pub(super) fn transposed(&self, v: &[f64; 3]) -> [f64; 3] {
        let [a00, a01, a02, a11, a12, a22] = self.a;
        [a00 * v[0], a01 * v[0] + a11 * v[1], a02 * v[0] + a12 * v[1] + a22 * v[2]]
    }

    /// `A x + B u`.
    #[inline(always)]
    pub(super) fn step<const LAST: bool>(&self, x: &[f64; 3], u: f64) -> [f64; 3] {
        let [a00, a01, a02, a11, a12, a22] = self.a;
        let b = &self.b;
        let first = a00 * x[0] + a01 * x[1] + a02 * x[2];
        let second = a11 * x[1] + a12 * x[2];
        let third = a22 * x[2] + b[2] * u;
        if LAST { [first, second, third] } else { [first + b[0] * u, second + b[1] * u, third] }
    }

    /// `B'v`.
    #[inline(always)]
    pub(super) fn input_of<const LAST: bool>(&self, v: &[f64; 3]) -> f64 {
        let last = self.b[2] * v[2];
        if LAST { last } else { self.b[0] * v[0] + self.b[1] * v[1] + last }
    }

    /// `A'P A`.
    #[inline(always)]
    fn congruence(&self, p: &Sym) -> Sym {
        let [a00, a01, a02, a11, a12, a22] = self.a;
        let [p00, p01, p02, p11, p12, p22] = *p;
        let m01 = a01 * p00 + a11 * p01;
        let m02 = a02 * p00 + a12 * p01 + a22 * p02;
        let m12 = a02 * p01 + a12 * p11 + a22 * p12;
        let m22 = a02 * p02 + a12 * p12 + a22 * p22;
        [
            a00 * (a00 * p00),
            a00 * m01,
            a00 * m02,
            a01 * m01 + a11 * (a01 * p01 + a11 * p11),
            a01 * m02 + a11 * m12,
            a02 * m02 + a12 * m12 + a22 * m22,
        ]
    }

    /// The backward sweep, `Hessians` first and what depends on them after: two short loops keep their
    /// numbers in registers, one long loop would not.
    ///
    /// `last` is the last stage whose models differ from those of the sweep before; at `N` nothing is
    /// taken over.
    pub(super) fn factor<M: Models>(
        &self,
        problem: &Problem,
        models: &M,
        sweep: &mut Sweep,
        last: usize,
    ) -> Open {
        let driven = M::DRIVEN && self.driven;
        match (self.last_only, driven) {
            (true, false) => self.hessians::<true, false>(problem, models, sweep, last),
            (true, true) => self.hessians::<true, true>(problem, models, sweep, last),
            (false, _) => self.hessians::<false, true>(problem, models, sweep, last),
        }
        match (self.last_only, problem.terminal) {
            (true, Terminal::Cost) => self.opens::<true, false, M>(problem, models, sweep, last),
            (true, Terminal::Equality(_)) => {
                self.opens::<true, true, M>(problem, models, sweep, last)
            }
            (false, _) => self.opens::<false, true, M>(problem, models, sweep, last),
        }
    }

    /// `P_k`, `F/δ` and `1/δ`.
    fn hessians<const LAST: bool, const DRIVEN: bool>(
        &self,
        problem: &Problem,
        models: &impl Models,
        sweep: &mut Sweep,
        last: usize,
    ) {
        let n = problem.horizon;
        let d = &problem.d[..n];
        let (gains, carried) = (&mut sweep.gains[..n], &mut sweep.carried[..n]);
        let (top, from) = resume(n, last);
        let mut p = if top < n {
            sweep.hessians[from]
        } else {
            let mut p = self.p;
            models.functions(n, |g, weight, _| add_rank_one(&mut p, g, weight));
            p
        };
        for k in (0..top).rev() {
            if DRIVEN {
                carried[k] = product(&p, &d[k]);
            }
            let pb = if LAST {
                [self.b[2] * p[2], self.b[2] * p[4], self.b[2] * p[5]]
            } else {
                product(&p, &self.b)
            };
            let (extra, held) = match models.input(k) {
                InputModel::Free(extra, _) => (extra, false),
                InputModel::Held(..) => (0.0, true),
            };
            let inverse = 1.0 / (self.r + extra + self.input_of::<LAST>(&pb));
            // What follows does not wait for the division: it is the longest link of the chain.
            let fa = self.transposed(&pb);
            let f = [fa[0] + self.s[0], fa[1] + self.s[1], fa[2] + self.s[2]];
            let mut next = self.q;
            if k > 0 {
                models.functions(k, |g, weight, _| add_rank_one(&mut next, g, weight));
            }
            let apa = self.congruence(&p);
            for i in 0..6 {
                next[i] += apa[i];
            }
            gains[k].feedback = [f[0] * inverse, f[1] * inverse, f[2] * inverse];
            gains[k].inverse = inverse;
            let taken = if held { 0.0 } else { inverse };
            p = [
                next[0] - (f[0] * f[0]) * taken,
                next[1] - (f[0] * f[1]) * taken,
                next[2] - (f[0] * f[2]) * taken,
                next[3] - (f[1] * f[1]) * taken,
                next[4] - (f[1] * f[2]) * taken,
                next[5] - (f[2] * f[2]) * taken,
            ];
            if k % STRIDE == 0 {
                sweep.hessians[k / STRIDE] = p;
            }
        }
    }

    /// `Ψ_k`, `p_k`, `W_k`, `t_k` and the gains' open part.
    fn opens<const LAST: bool, const PINNED: bool, M: Models>(
        &self,
        problem: &Problem,
        models: &M,
        sweep: &mut Sweep,
        last: usize,
    ) -> Open {
        let n = problem.horizon;
        let d = &problem.d[..n];
        let (gains, carried) = (&mut sweep.gains[..n], &sweep.carried[..n]);
        let (top, from) = resume(n, last);
        let Open { mut linear, mut dual } = if top < n {
            sweep.opens[from]
        } else {
            let v = models.gradient(n);
            let mut linear = [[1.0, 0.0, 0.0, v[0]], [0.0, 1.0, 0.0, v[1]], [0.0, 0.0, 1.0, v[2]]];
            models.functions(n, |g, _, force| push(&mut linear, g, force));
            Open { linear, dual: Lanes::default() }
        };
        let [a00, a01, a02, a11, a12, a22] = self.a;
        for k in (0..top).rev() {
            if M::DRIVEN && self.driven {
                for j in 0..3 {
                    let moved =
                        linear[0][j] * d[k][0] + linear[1][j] * d[k][1] + linear[2][j] * d[k][2];
                    dual[j][3] -= moved;
                }
                for i in 0..3 {
                    linear[i][3] += carried[k][i];
                }
            }
            let mut beta = [0.0; 4];
            for j in 0..4 {
                beta[j] = self.input_of::<LAST>(&[linear[0][j], linear[1][j], linear[2][j]]);
            }
            let gain = &mut gains[k];
            let (pull, open) = match models.input(k) {
                InputModel::Free(_, force) => {
                    let mut pull = beta;
                    pull[3] += force;
                    let open = pull.map(|b| b * gain.inverse);
                    gain.open = open;
                    (pull, open)
                }
                InputModel::Held(u, force) => {
                    let mut free = beta;
                    free[3] += force;
                    gain.open = free.map(|b| b * gain.inverse);
                    ([0.0, 0.0, 0.0, -u / gain.inverse], [0.0, 0.0, 0.0, -u])
                }
            };
            let mut next = Lanes::default();
            for j in 0..4 {
                next[0][j] = a00 * linear[0][j];
                next[1][j] = a01 * linear[0][j] + a11 * linear[1][j];
                next[2][j] = a02 * linear[0][j] + a12 * linear[1][j] + a22 * linear[2][j];
            }
            let gradient = models.gradient(k);
            for i in 0..3 {
                next[i][3] += gradient[i];
            }
            if k > 0 {
                models.functions(k, |g, _, force| push(&mut next, g, force));
            }
            if PINNED {
                for i in 0..3 {
                    for j in 0..4 {
                        next[i][j] -= gain.feedback[i] * pull[j];
                        dual[i][j] += beta[i] * open[j];
                    }
                }
            } else {
                for i in 0..3 {
                    next[i][3] -= gain.feedback[i] * pull[3];
                }
            }
            linear = next;
            if k % STRIDE == 0 {
                sweep.opens[k / STRIDE] = Open { linear, dual };
            }
        }
        Open { linear, dual }
    }
}

/// Where a sweep that keeps everything above stage `last` begins: the stage, and its stored entry.
fn resume(horizon: usize, last: usize) -> (usize, usize) {
    let entry = last / STRIDE + 1;
    if entry * STRIDE < horizon { (entry * STRIDE, entry) } else { (horizon, 0) }
}

impl Open {
    /// `y` from `W_0 y = Ψ_0'x_0 + t_0 − x_f`; zero without a terminal equality.
    pub(super) fn multiplier(&self, problem: &Problem) -> [f64; 3] {
        let Terminal::Equality(x_f) = &problem.terminal else { return [0.0; 3] };
        let (x, psi) = (&problem.x0, &self.linear);
        let miss = std::array::from_fn(|j| {
            let reached = psi[0][j] * x[0] + psi[1][j] * x[1] + psi[2][j] * x[2];
            reached - self.dual[j][3] - x_f[j]
        });
        self.solve(&miss)
    }

    /// The same for changes of a trajectory that ends at `x_N`; the new `y`.
    pub(super) fn multiplier_of_change(&self, problem: &Problem, x_n: &[f64; 3]) -> [f64; 3] {
        let Terminal::Equality(x_f) = &problem.terminal else { return [0.0; 3] };
        self.solve(&std::array::from_fn(|j| x_n[j] - self.dual[j][3] - x_f[j]))
    }

    /// `W y = rhs` by `LDL'`, a proximal term far below the precision of `W` keeping it regular when the
    /// held inputs leave some direction of `x_N` out of reach.
    pub(super) fn solve(&self, rhs: &[f64; 3]) -> [f64; 3] {
        let w = &self.dual;
        let tiny = 1e-300;
        let d0 = w[0][0] * (1.0 + 1e-14) + tiny;
        let (l10, l20) = (w[0][1] / d0, w[0][2] / d0);
        let d1 = (w[1][1] - l10 * w[0][1]).max(1e-14 * w[1][1]) + tiny;
        let m21 = w[1][2] - l10 * w[0][2];
        let l21 = m21 / d1;
        let d2 = (w[2][2] - l20 * w[0][2] - l21 * m21).max(1e-14 * w[2][2]) + tiny;
        let z0 = rhs[0];
        let z1 = rhs[1] - l10 * z0;
        let z2 = rhs[2] - l20 * z0 - l21 * z1;
        let y2 = z2 / d2;
        let y1 = z1 / d1 - l21 * y2;
        [z0 / d0 - l10 * y1 - l20 * y2, y1, y2]
    }
}

impl Gain {
    /// `constant + pin·y`, the part of the input that does not depend on the state.
    #[inline(always)]
    pub(super) fn offset(&self, y: &[f64; 3]) -> f64 {
        self.open[3] + (self.open[0] * y[0] + self.open[1] * y[1] + self.open[2] * y[2])
    }

    /// `−u` for an offset; the last state last: it is the one that the previous input has just changed.
    #[inline(always)]
    pub(super) fn input(&self, offset: f64, x: &[f64; 3]) -> f64 {
        (offset + (self.feedback[0] * x[0] + self.feedback[1] * x[1])) + self.feedback[2] * x[2]
    }
}

/// `P v`.
#[inline(always)]
pub(super) fn product(p: &Sym, v: &[f64; 3]) -> [f64; 3] {
    [
        p[0] * v[0] + p[1] * v[1] + p[2] * v[2],
        p[1] * v[0] + p[3] * v[1] + p[4] * v[2],
        p[2] * v[0] + p[4] * v[1] + p[5] * v[2],
    ]
}

/// Adds `weight · g g'`.
#[inline(always)]
fn add_rank_one(hessian: &mut Sym, g: &[f64; 3], weight: f64) {
    let wg = [weight * g[0], weight * g[1], weight * g[2]];
    hessian[0] += wg[0] * g[0];
    hessian[1] += wg[0] * g[1];
    hessian[2] += wg[0] * g[2];
    hessian[3] += wg[1] * g[1];
    hessian[4] += wg[1] * g[2];
    hessian[5] += wg[2] * g[2];
}

/// Adds `force · g` to the last lane.
#[inline(always)]
fn push(linear: &mut Lanes, g: &[f64; 3], force: f64) {
    for i in 0..3 {
        linear[i][3] += force * g[i];
    }
}
