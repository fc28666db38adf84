use super::*;

/// The cost with some inputs held.
struct Held<'a> {
    cost: &'a Cost,
    sides: &'a [bool],
}

impl BlockModels for Held<'_> {
    const IS_WHOLE: bool = true;

    fn block(&mut self, j: usize) -> BlockModel {
        self.cost.block(j)
    }

    fn held(&self, k: usize) -> Option<f64> {
        self.sides[k].then_some(0.5)
    }
}

/// Every fifth input is held.
const SIDES: [bool; 21] = {
    let mut sides = [false; 21];
    let mut k = 3;
    while k < sides.len() {
        sides[k] = true;
        k += 5;
    }
    sides
};

fn problem(is_fixed: bool, is_disturbed: bool) -> Problem {
    let builder = Problem::builder(21)
        .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
        .state_weights([3.0, 20.0, 0.7])
        .input_cost(1.3)
        .input_bounds(-1.0, 1.0);
    let builder = if is_fixed { builder.terminal_equality([0.0; 3]) } else { builder };
    let mut problem = builder.build().expect("a valid problem");
    if is_disturbed {
        for (k, d) in problem.disturbances_mut().iter_mut().enumerate() {
            *d = [0.0, 0.01 * k as f64, 0.02];
        }
    }
    problem
}

fn sweep(problem: &Problem, lq: &LinearQuadratic, sides: &[bool], last: usize, into: &mut Sweep) {
    let mut cost = Cost::new(problem.horizon);
    cost.start(problem);
    lq.factor(problem, &mut Held { cost: &cost, sides }, into, last);
}

/// Returns the bits of all gains.
fn bits(sweep: &Sweep) -> Vec<[u64; 8]> {
    let of = |gain: &Gain| {
        let ([a, b, c], [d, e, f, g]) = (gain.feedback, gain.feedforward);
        [a, b, c, d, e, f, g, gain.inverse].map(f64::to_bits)
    };
    sweep.gains[..21].iter().map(of).collect()
}

#[test]
fn a_chain_has_the_gains_of_general_dynamics() {
    for (is_fixed, is_disturbed) in [(false, false), (false, true), (true, false), (true, true)] {
        let problem = problem(is_fixed, is_disturbed);
        let lq = LinearQuadratic::new(&problem);
        assert_eq!(lq.shape, CHAIN);
        let [mut chain, mut general] = [Sweep::new(21), Sweep::new(21)];
        sweep(&problem, &lq, &SIDES, 21, &mut chain);
        sweep(&problem, &LinearQuadratic { shape: GENERAL, ..lq }, &SIDES, 21, &mut general);
        for (a, b) in bits(&chain).into_iter().zip(bits(&general)) {
            for (a, b) in a.map(f64::from_bits).into_iter().zip(b.map(f64::from_bits)) {
                assert!((a - b).abs() <= 1e-12 * a.abs().max(1.0), "{a} {b}");
            }
        }
    }
}

#[test]
fn a_sweep_that_is_resumed_has_the_bits_of_a_whole_one() {
    for (is_fixed, is_disturbed) in [(false, true), (true, true)] {
        let problem = problem(is_fixed, is_disturbed);
        let lq = LinearQuadratic::new(&problem);
        for last in [0, 3, 7, 8, 15, 20] {
            let mut sides = SIDES;
            sides[last] ^= true;
            let [mut resumed, mut whole] = [Sweep::new(21), Sweep::new(21)];
            sweep(&problem, &lq, &SIDES, 21, &mut resumed);
            sweep(&problem, &lq, &sides, last, &mut resumed);
            sweep(&problem, &lq, &sides, 21, &mut whole);
            assert_eq!(bits(&resumed), bits(&whole), "{last}");
        }
    }
}
