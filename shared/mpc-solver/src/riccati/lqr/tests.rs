use super::*;

/// Models with inputs held and free in turn, and the cost's own gradients.
struct Alternating<'a>(&'a Problem);

impl StageModels for Alternating<'_> {
    fn input(&self, k: usize) -> InputModel {
        let slope = self.0.r_lin[k];
        if k % 5 == 3 { InputModel::Held(0.5, slope) } else { InputModel::Free(0.0, slope) }
    }

    fn state<V: Vector>(&self, k: usize, _: &mut Rows<V>) -> [f64; 3] {
        if k < self.0.horizon { self.0.q_lin[k] } else { self.0.p_lin }
    }
}

/// Returns the bits of all gains.
fn gains(problem: &Problem, lq: &LinearQuadratic) -> Vec<[u64; 8]> {
    let mut sweep = Sweep::new(problem.horizon);
    lq.factor(problem, &Alternating(problem), &mut sweep, problem.horizon);
    let of = |gain: &Gain| {
        let ([a, b, c], [d, e, f, g]) = (gain.feedback, gain.feedforward);
        [a, b, c, d, e, f, g, gain.inverse].map(f64::to_bits)
    };
    sweep.gains[..problem.horizon].iter().map(of).collect()
}

#[test]
fn plain_dynamics_have_the_same_bits_as_a_chain_with_zeros() {
    for is_fixed in [false, true] {
        let builder = Problem::builder(21)
            .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
            .state_weights([3.0, 20.0, 0.7])
            .input_cost(1.3)
            .input_bounds(-1.0, 1.0);
        let builder = if is_fixed { builder.terminal_equality([0.0; 3]) } else { builder };
        let mut problem = builder.build().expect("a valid problem");
        for is_disturbed in [false, true] {
            if is_disturbed {
                for (k, d) in problem.disturbances_mut().iter_mut().enumerate() {
                    *d = [0.0, 0.01 * k as f64, 0.02];
                }
            }
            let lq = LinearQuadratic::new(&problem);
            assert_eq!(lq.shape, PLAIN);
            let plain = gains(&problem, &lq);
            let chain = gains(&problem, &LinearQuadratic { shape: CHAIN, ..lq });
            assert_eq!(plain, chain);
        }
    }
}
