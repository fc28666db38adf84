//! Output of a law at one release.

use truck_model::Demand;

/// Longest plan a command can carry, in control steps.
pub const MAX_PLAN: usize = 128;
/// Most figures that a law shows.
pub const MAX_FIGURES: usize = 8;

/// Quality of the returned command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The law's full function.
    #[default]
    Full,
    /// Usable, but some constraint had to be relaxed (an infeasible light, a violated buffer).
    Relaxed,
    /// The law failed and its backup produced the command.
    Backup,
    /// The state is outside the range that the law is made for; its fall-back produced the command.
    FallBack,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Planned requests, m/s², one per control period; the first acts now. `plan_len` are valid.
    pub plan_mps2: [f64; MAX_PLAN],
    /// Valid entries of `plan_mps2`, at least 1.
    pub plan_len: usize,
    /// Request to a truck's engine now. It comes before `plan_mps2[0]`, which is the same as an acceleration; the later
    /// requests of the plan have no torque.
    pub torque: Option<Demand>,
    /// Mode of the law, an index into the modes of its [`Formulation`](super::Formulation).
    pub mode: u32,
    /// Reason of the last mode change, an index into the formulation's reasons.
    pub mode_reason: u32,
    pub quality: Quality,
    /// Iterations the solver took, 0 for explicit laws.
    pub solver_iterations: u32,
    /// The law's own figures for `control/diagnostics`, named by its formulation.
    pub figures: [f64; MAX_FIGURES],
}

impl Default for Output {
    fn default() -> Self {
        Self {
            plan_mps2: [0.0; MAX_PLAN],
            plan_len: 1,
            torque: None,
            mode: 0,
            mode_reason: 0,
            quality: Quality::Full,
            solver_iterations: 0,
            figures: [0.0; MAX_FIGURES],
        }
    }
}

impl Output {
    /// Sets a plan of one request, the form of every law without a horizon.
    pub fn set_request(&mut self, request_mps2: f64) {
        self.plan_mps2[0] = request_mps2;
        self.plan_len = 1;
        self.torque = None;
    }

    /// Bounds the plan from above, m/s². A truck's torque gives way where its request does.
    pub fn bound_from_above(&mut self, most_mps2: f64) {
        if self.request_mps2() > most_mps2 {
            self.torque = None;
        }
        for request in &mut self.plan_mps2[..self.plan_len] {
            *request = request.min(most_mps2);
        }
    }

    /// Makes every figure finite: what is not a number is 0, what is beyond all numbers the largest one.
    pub fn bound_figures(&mut self) {
        for figure in &mut self.figures {
            *figure = if figure.is_nan() { 0.0 } else { figure.clamp(f64::MIN, f64::MAX) };
        }
    }

    /// Request that acts now, m/s².
    pub fn request_mps2(&self) -> f64 {
        self.plan_mps2[0]
    }
}

/// The mode of the last step, and the reason of its last change.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModeMemory {
    mode: Option<u32>,
    reason: u32,
}

impl ModeMemory {
    /// Notes the mode of this step and shows it. `reason` gives the reason of a change from the mode before.
    pub fn note(&mut self, output: &mut Output, mode: u32, reason: impl FnOnce(u32) -> u32) {
        if let Some(before) = self.mode.replace(mode).filter(|&before| before != mode) {
            self.reason = reason(before);
        }
        self.show(output);
    }

    /// Shows the mode of the last step, 0 before the first.
    pub fn show(&self, output: &mut Output) {
        (output.mode, output.mode_reason) = (self.mode.unwrap_or(0), self.reason);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_from_above_leaves_braking_and_takes_the_torque_of_a_request_above_it() {
        let engine = Demand { engine_torque_nm: 900.0, service_brake_n: 0.0, gear: None };
        let mut plan = Output { plan_len: 2, torque: Some(engine), ..Output::default() };
        plan.plan_mps2[..3].copy_from_slice(&[2.0, -3.0, 5.0]);
        let mut bounded = plan;
        bounded.bound_from_above(2.0);
        assert_eq!(bounded, plan);
        bounded.bound_from_above(0.3);
        assert_eq!((bounded.plan_mps2[..3].to_vec(), bounded.torque), (vec![0.3, -3.0, 5.0], None));
    }
}
