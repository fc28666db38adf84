//! The plan of the command that is being followed.

use super::Rejection;

/// Longest plan that is kept, in control steps: as long as a command carries.
const MAX_PLAN: usize = messages::PLAN_LEN;

/// Requests for successive control steps.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    requests_mps2: [f64; MAX_PLAN],
    len: usize,
    start_ns: u64,
    step_ns: u64,
}

impl Plan {
    /// A plan whose request `k` is meant for `start_ns + k * step_ns` on. A longer one is cut.
    pub(super) fn new(start_ns: u64, step_ns: u64, plan_mps2: &[f64]) -> Result<Self, Rejection> {
        if plan_mps2.is_empty() || step_ns == 0 {
            return Err(Rejection::Empty);
        }
        if plan_mps2.iter().any(|request| !request.is_finite()) {
            return Err(Rejection::NotFinite);
        }
        let len = plan_mps2.len().min(MAX_PLAN);
        let mut requests_mps2 = [0.0; MAX_PLAN];
        requests_mps2[..len].copy_from_slice(&plan_mps2[..len]);
        Ok(Self { requests_mps2, len, start_ns, step_ns })
    }

    /// Start of the first step.
    pub(super) fn start_ns(&self) -> u64 {
        self.start_ns
    }

    /// End of the first step: a new command is due.
    pub(super) fn due_ns(&self) -> u64 {
        self.start_ns.saturating_add(self.step_ns)
    }

    /// Request of the first step.
    pub(super) fn first_mps2(&self) -> f64 {
        self.requests_mps2[0]
    }

    /// Request at `now_ns`. After the end of the plan its last request is held for one step, then only if it brakes.
    pub(super) fn at(&self, now_ns: u64) -> f64 {
        let age_ns = now_ns.saturating_sub(self.start_ns);
        let k = usize::try_from(age_ns / self.step_ns).unwrap_or(usize::MAX);
        let requests = &self.requests_mps2[..self.len];
        let last = requests[self.len - 1];
        requests.get(k).copied().unwrap_or(if k == self.len { last } else { last.min(0.0) })
    }

    /// Hardest braking of the plan, 0 if it does not brake.
    pub(super) fn worst_mps2(&self) -> f64 {
        self.requests_mps2[..self.len].iter().copied().fold(0.0, f64::min)
    }
}
