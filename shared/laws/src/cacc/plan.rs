//! Memory of the last good plan, so that a failed solve still has a future to follow.

use law::{MAX_PLAN, Output};

/// The last plan and when it was made.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanMemory {
    requests: [f64; MAX_PLAN],
    len: usize,
    made_at_s: f64,
    step_s: f64,
}

impl Default for PlanMemory {
    fn default() -> Self {
        Self { requests: [0.0; MAX_PLAN], len: 0, made_at_s: 0.0, step_s: 0.0 }
    }
}

impl PlanMemory {
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Keeps `requests`, one per prediction step of `step_s`, as made at `time_s`.
    pub(super) fn store(&mut self, requests: &[f64], time_s: f64, step_s: f64) {
        (self.made_at_s, self.step_s) = (time_s, step_s);
        self.len = requests.len().min(MAX_PLAN);
        self.requests[..self.len].copy_from_slice(&requests[..self.len]);
    }

    /// Writes what remains of the plan at `time_s`, one request per `period_s`. Returns whether
    /// anything remains that is not older than `max_age_s`; without it the output is untouched.
    pub(super) fn write(
        &self,
        time_s: f64,
        period_s: f64,
        max_age_s: f64,
        output: &mut Output,
    ) -> bool {
        let age = time_s - self.made_at_s;
        // Written so that NaN fails as well.
        if !(self.len > 0 && age >= -1e-9 && age <= max_age_s && period_s > 0.0) {
            return false;
        }
        let mut n = 0;
        while n < MAX_PLAN {
            let at = (age + n as f64 * period_s) / self.step_s + 1e-6;
            if at >= self.len as f64 {
                break;
            }
            output.plan_mps2[n] = self.requests[at as usize];
            n += 1;
        }
        if n > 0 {
            output.plan_len = n;
            output.torque = None;
        }
        n > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_is_shifted_and_resampled() {
        let mut memory = PlanMemory::default();
        let mut output = Output::default();
        assert!(!memory.write(0.0, 0.1, 1.0, &mut output));
        memory.store(&[1.0, 2.0, 3.0, 4.0], 5.0, 0.1);
        assert!(memory.write(5.2, 0.1, 1.0, &mut output));
        assert_eq!((output.plan_len, output.plan_mps2[0], output.plan_mps2[1]), (2, 3.0, 4.0));
        assert!(memory.write(5.0, 0.05, 1.0, &mut output));
        assert_eq!(output.plan_len, 8);
        assert_eq!(output.plan_mps2[..4], [1.0, 1.0, 2.0, 2.0]);
        assert!(!memory.write(5.4, 0.1, 1.0, &mut output));
        assert!(!memory.write(6.2, 0.1, 1.0, &mut output));
    }
}
