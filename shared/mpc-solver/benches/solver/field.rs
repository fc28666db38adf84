//! Other solvers on the same instances, each as its makers would use it.
//!
//! * clarabel, the general conic solver, on the sparse problem; only its own solve counts, not the assembly of its
//!   matrices.
//! * OSQP ([`osqp`](crate::osqp)), operator splitting for sparse quadratic programs, on those without the light: `cargo
//!   bench -p mpc-solver --features osqp --bench solver`. It is C and needs cmake, so that it is not in the default
//!   build.
//!
//! PIQP and DAQP are in no registry of this language. The bench `peers` compares with their Python wheels. quadprog is
//! under the GPL.

use std::time::Instant;

use mpc_solver::Clarabel;

use crate::common::{HORIZON, Instance, cacc};
use crate::summary::{Sample, TOLERANCE};

/// Samples of every solver that can solve the set.
pub(crate) fn solve(set: &[&Instance], repeats: usize) -> Vec<(&'static str, Vec<Sample>)> {
    let conic = ("clarabel", clarabel(set, repeats));
    #[cfg(feature = "osqp")]
    if set.iter().all(|instance| instance.stages == 0) {
        return vec![conic, ("osqp", crate::osqp::solve(set, repeats))];
    }
    vec![conic]
}

fn clarabel(set: &[&Instance], repeats: usize) -> Vec<Sample> {
    let mut problem = cacc(HORIZON);
    let mut solver = Clarabel::with_tolerance(TOLERANCE);
    let mut samples = Vec::new();
    for instance in set {
        instance.apply(&mut problem);
        let mut times = Vec::with_capacity(repeats);
        for _ in 0..repeats {
            solver.prepare(&problem).expect("the table holds only finite numbers");
            let begin = Instant::now();
            solver.run();
            times.push(begin.elapsed().as_secs_f64() * 1e6);
        }
        let mut sample = Sample::new(&solver.finish(&problem), "");
        sample.take_median(&mut times);
        samples.push(sample);
    }
    samples
}
