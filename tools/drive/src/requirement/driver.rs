//! Reference drivers: how long after the need they brake, and how hard.
//!
//! They stand here once for the requirement `no-avoidable-collision`, for the search (`search::reference`) and for the
//! everyday scenes (`populations`). Each of the three moves its driver through its own picture of the traffic.
//! These are a recorded drive, a scenario that was not driven, and an oracle that shares no code with the plant.

/// A driver who has noticed the need to brake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceDriver {
    /// Time from the need to the braking, s.
    pub reaction_s: f64,
    /// Deceleration, m/s².
    pub deceleration_mps2: f64,
    /// Growth of the deceleration, m/s³; infinite: at once.
    pub jerk_mps3: f64,
}

impl ReferenceDriver {
    /// 6 m/s², 0.35 s after the need (UN R157, annex 4, appendix 3).
    pub const REGULATION: Self =
        Self { reaction_s: 0.35, deceleration_mps2: 6.0, jerk_mps3: f64::INFINITY };
    /// The careful driver of UN R157, annex 4, appendix 3: 0.774 g after 0.75 s, reached in 0.6 s.
    pub const CAREFUL: Self = Self { reaction_s: 0.75, deceleration_mps2: 7.59, jerk_mps3: 12.65 };
    /// Braking beyond which there is a need, m/s². Chosen: the plant's own stop in lane by default.
    pub const NEED_MPS2: f64 = 2.5;

    /// The driver of a vehicle whose brakes give at most this much.
    pub fn with_brakes(self, hardest_mps2: f64) -> Self {
        Self { deceleration_mps2: self.deceleration_mps2.min(hardest_mps2), ..self }
    }

    /// Deceleration at a time after the need, m/s². `None` in the reaction time.
    ///
    /// ```
    /// use drive::ReferenceDriver;
    ///
    /// assert_eq!(ReferenceDriver::REGULATION.braking_mps2(0.3), None);
    /// assert_eq!(ReferenceDriver::REGULATION.braking_mps2(0.35), Some(6.0));
    /// assert_eq!(ReferenceDriver::CAREFUL.braking_mps2(1.5), Some(7.59));
    /// ```
    pub fn braking_mps2(&self, since_need_s: f64) -> Option<f64> {
        // The rounding of a sum of steps is not a delay.
        let braked_s = since_need_s - self.reaction_s;
        if braked_s < -1e-9 {
            return None;
        }
        if self.jerk_mps3.is_infinite() {
            return Some(self.deceleration_mps2);
        }
        Some((self.jerk_mps3 * braked_s.max(0.0)).min(self.deceleration_mps2))
    }
}
