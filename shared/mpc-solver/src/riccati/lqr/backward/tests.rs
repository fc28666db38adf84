use super::*;
use crate::riccati::matrix::add_slope;

/// Models with inputs held and free in turn, and a function of the state at every stage.
struct Various<'a>(&'a Problem);

impl StageModels for Various<'_> {
    fn input(&self, k: usize) -> InputModel {
        let slope = self.0.r_lin[k];
        match k % 5 {
            3 => InputModel::Held(0.5, slope),
            _ => InputModel::Free(0.1 * (k % 2) as f64, slope),
        }
    }

    fn state<V: Vector>(&self, k: usize, hessian: &mut Rows<V>) -> [f64; 3] {
        let mut gradient = if k < self.0.horizon { self.0.q_lin[k] } else { self.0.p_lin };
        let g = [1.0, -0.1 * k as f64, 0.005 * (k * k) as f64];
        hessian.add_rank_one(V::from_array([g[0], g[1], g[2], 7.0]), 0.03 / (1 + k) as f64);
        add_slope(&mut gradient, &g, 0.7);
        gradient
    }
}

/// Returns the bits of all gains and of the first stage's cost-to-go.
fn bits(sweep: &Sweep, horizon: usize, cost: &CostToGo) -> Vec<u64> {
    let gains = sweep.gains[..horizon].iter().flat_map(|gain| {
        let ([a, b, c], [d, e, f, g]) = (gain.feedback, gain.feedforward);
        [a, b, c, d, e, f, g, gain.inverse]
    });
    let linear = cost.linear.iter().flat_map(|row| row.0);
    gains.chain(linear).chain(cost.reached.0).map(f64::to_bits).collect()
}

fn same_by_registers<const SHAPE: Shape>(dynamics: [[f64; 3]; 3], input: [f64; 3]) {
    let builder = Problem::builder(37)
        .dynamics(dynamics, input)
        .state_weights([3.0, 20.0, 0.7])
        .terminal_weights([5.0, 1.0, 0.3])
        .input_cost(1.3)
        .input_bounds(-1.0, 1.0);
    let mut problem = builder.build().expect("a valid problem");
    for (k, d) in problem.disturbances_mut().iter_mut().enumerate() {
        *d = [0.001, 0.01 * k as f64, 0.02];
    }
    let lq = LinearQuadratic::new(&problem);
    assert_eq!(lq.shape, SHAPE);
    let stages = Stages { lq: &lq, problem: &problem, models: &Various(&problem), last: 37 };
    let run = |sweep: &dyn Fn(&mut Sweep) -> CostToGo| {
        let mut memory = Sweep::new(37);
        let cost = sweep(&mut memory);
        bits(&memory, 37, &cost)
    };
    // With and without the terminal multiplier; in the second case only the linear part has a
    // meaning.
    assert_eq!(
        run(&|memory| stages.sweep::<SHAPE, true, true>(memory)),
        run(&|memory| stages.sweep_portable::<SHAPE, true, true>(memory)),
        "fixed end"
    );
    assert_eq!(
        run(&|memory| stages.sweep::<SHAPE, true, false>(memory)),
        run(&|memory| stages.sweep_portable::<SHAPE, true, false>(memory)),
        "free end"
    );
}

/// On a machine without wide registers this compares the portable version with itself.
#[test]
fn wide_registers_give_the_same_bits_for_every_shape() {
    let (t, last) = (0.1, [0.0, 0.0, 0.2]);
    same_by_registers::<PLAIN>([[1.0, t, 0.0], [0.0, 1.0, t], [0.0, 0.0, 0.8]], last);
    same_by_registers::<CHAIN>([[1.0, t, 0.3], [0.0, 1.0, t], [0.0, 0.0, 0.8]], last);
    let input = [0.01, 0.02, 0.2];
    let dynamics = [[1.0, t, 0.3], [0.0, 1.0, t], [0.0, 0.0, 0.8]];
    same_by_registers::<{ super::super::INTEGRATING }>(dynamics, input);
    same_by_registers::<GENERAL>([[0.9, t, 0.3], [0.0, 1.1, t], [0.0, 0.0, 0.8]], input);
}
