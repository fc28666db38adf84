//! The acceleration that the law's own requests explain.
//!
//! Plans begin at the vehicle's acceleration, and smooth what follows. Braking beyond the law's own requests comes from
//! another system, such as an emergency brake. The law does not smooth its end. A plan that began there would add
//! braking of its own. It would keep the ego slow long after the other has let go.

use law::following::kinematics::Lag;

/// Difference between measured and explained acceleration for other reasons, m/s²: grades, age of the odometry.
const UNEXPLAINED_MPS2: f64 = 1.0;

/// The law's requests behind the actuator's lag.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwnLag {
    /// `None` before the first request.
    acceleration_mps2: Option<f64>,
}

impl OwnLag {
    /// The acceleration at which a plan begins when `measured_mps2` is the vehicle's.
    pub(super) fn begin_mps2(&self, measured_mps2: f64) -> f64 {
        (self.acceleration_mps2)
            .map_or(measured_mps2, |own_mps2| measured_mps2.max(own_mps2 - UNEXPLAINED_MPS2))
    }

    /// Takes a request that acts for `period_s` on a vehicle that has `measured_mps2`.
    pub(super) fn ask(&mut self, request_mps2: f64, measured_mps2: f64, lag: Lag, period_s: f64) {
        let before_mps2 = self.acceleration_mps2.unwrap_or(measured_mps2);
        let [kept, gained] = lag.discretise(period_s).acceleration;
        self.acceleration_mps2 = Some(kept * before_mps2 + gained * request_mps2);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Lag = Lag { tau_s: 0.5 };

    #[test]
    fn only_what_no_request_explains_is_left_out() {
        let mut own = OwnLag::default();
        assert_eq!(own.begin_mps2(-8.0), -8.0, "nothing is known yet");
        (0..100).for_each(|_| own.ask(-2.0, 0.0, LAG, 0.1));
        assert_eq!(own.begin_mps2(-1.0), -1.0);
        assert_eq!(own.begin_mps2(-2.9), -2.9, "a grade");
        assert!((own.begin_mps2(-8.0) + 3.0).abs() < 1e-6, "another system brakes");
    }
}
