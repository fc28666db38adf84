//! Prototype: a guess from the problem with blocks of equal inputs.

use super::active_set::{ActiveSet, From, Outcome, Point};
use super::light_curve::LightCurve;
use super::lqr::LinearQuadratic;
use super::working_set::{Side, WorkingSet};
use crate::kkt::Multipliers;
use crate::limits::MAX_ROWS;
use crate::problem::{LightStage, Problem, dot};

#[derive(Clone, Debug)]
pub(super) struct Coarse {
    problem: Option<Problem>,
    active: ActiveSet,
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
    multipliers: Multipliers,
}

type M3 = [[f64; 3]; 3];
fn mul(a: &M3, b: &M3) -> M3 {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|l| a[i][l] * b[l][j]).sum()))
}
fn mv(a: &M3, v: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| dot(&a[i], v))
}
fn tr(a: &M3) -> M3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}
fn add(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

impl Coarse {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            problem: None,
            active: ActiveSet::new(max_horizon),
            inputs: vec![0.0; max_horizon],
            states: vec![[0.0; 3]; max_horizon + 1],
            multipliers: Multipliers::new(max_horizon),
        }
    }

    fn build(&mut self, p: &Problem, m: usize) {
        let n = p.horizon / m;
        let mut c = p.clone();
        c.horizon = n;
        let mut ai = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut bi = [0.0; 3];
        c.q = [[0.0; 3]; 3];
        c.s = [0.0; 3];
        c.r = 0.0;
        let mut pre = Vec::new();
        for _ in 0..m {
            let at = tr(&ai);
            let qa = mul(&at, &mul(&p.q, &ai));
            let qb = mv(&p.q, &bi);
            let sb = add(&qb, &p.s);
            let s = mv(&at, &sb);
            for i in 0..3 {
                for j in 0..3 {
                    c.q[i][j] += qa[i][j];
                }
                c.s[i] += s[i];
            }
            c.r += dot(&bi, &qb) + 2.0 * dot(&p.s, &bi) + p.r;
            pre.push((ai, bi));
            ai = mul(&p.a, &ai);
            bi = add(&mv(&p.a, &bi), &p.b);
        }
        c.a = ai;
        c.b = bi;
        for j in 0..n {
            let mut d = [0.0; 3];
            let mut ql = [0.0; 3];
            let mut rl = 0.0;
            for (i, (ai, bi)) in pre.iter().enumerate() {
                let k = j * m + i;
                let g = add(&p.q_lin[k], &mv(&p.q, &d));
                ql = add(&ql, &mv(&tr(ai), &g));
                rl += p.r_lin[k] + dot(bi, &g) + dot(&p.s, &d);
                d = add(&mv(&p.a, &d), &p.d[k]);
            }
            c.d[j] = d;
            c.q_lin[j] = ql;
            c.r_lin[j] = rl;
        }
        if let Some(l) = &mut c.light {
            l.weight *= m as f64;
            if let crate::problem::Softness::Soft { linear, .. } = &mut l.softness {
                *linear *= m as f64;
            }
        }
        c.light_len = p.light_len / m;
        for j in 1..=c.light_len {
            c.light_stages[j - 1] = p.light_stages[j * m - 1];
        }
        for (r, row) in c.rows.iter_mut().enumerate() {
            row.from = row.from.div_ceil(m).max(1);
            row.to = (row.to / m).min(n);
            if let crate::problem::Softness::Soft { linear, quadratic } = &mut row.softness {
                *linear *= m as f64;
                *quadratic *= m as f64;
            }
            for j in 1..=n {
                c.limits[r][j] = p.limits[r][j * m];
            }
        }
        self.problem = Some(c);
    }

    /// rounds, or none
    pub(super) fn suggest(
        &mut self,
        p: &Problem,
        m: usize,
        fine_states: &mut [[f64; 3]],
        fine_inputs: &mut [f64],
        active: &mut ActiveSet,
    ) -> (bool, u32) {
        self.build(p, m);
        let c = self.problem.as_ref().unwrap();
        self.active.is_rough = true;
        let lq = LinearQuadratic::new(c);
        let (outcome, rounds) = self.active.solve(
            c,
            &lq,
            From::Nothing,
            &mut Point {
                inputs: &mut self.inputs,
                states: &mut self.states,
                multipliers: &mut self.multipliers,
            },
        );
        if outcome == Outcome::GivenUp {
            return (false, rounds);
        }
        let n = p.horizon;
        let guess: &mut WorkingSet = &mut active.guess;
        guess.clear();
        for k in 0..n {
            let j = k / m;
            fine_inputs[k] = self.inputs[j];
            guess.sides[k] = self.active.guess.sides[j];
        }
        let g = &self.active.guess.sides;
        {
            for j in 1..n / m - 1 {
                let (l, r) = (g[j - 1], g[j + 1]);
                if g[j] == Side::Free && l as i8 * r as i8 == -1 {
                    let (ul, ur) = (self.inputs[j - 1], self.inputs[j + 1]);
                    let part = (self.inputs[j] - ur) / (ul - ur);
                    let f = ((part * m as f64) as usize).min(m - 1);
                    for i in 0..m {
                        let k = j * m + i;
                        if i < f {
                            guess.sides[k] = l;
                            fine_inputs[k] = ul;
                        } else if i > f {
                            guess.sides[k] = r;
                            fine_inputs[k] = ur;
                        } else {
                            fine_inputs[k] = ur + (part * m as f64 - f as f64) * (ul - ur);
                        }
                    }
                }
            }
        }
        p.roll_out(fine_inputs, fine_states);
        if let Some(light) = &p.light {
            let curve = LightCurve::new(light);
            for k in 1..=p.light_len {
                let st: &LightStage = &p.light_stages[k - 1];
                let margin = dot(&st.gradient, &fine_states[k]) + st.offset;
                guess.light[k - 1] = if margin >= light.threshold {
                    curve.clear()
                } else {
                    curve.hyperbola_at(margin.max(0.1))
                };
            }
        }
        active.take_rows(&self.active, m);
        (true, rounds)
    }
}
#[allow(dead_code)]
fn unused(_: Side) {
    let _ = MAX_ROWS;
}
