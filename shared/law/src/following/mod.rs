//! Common parts of the laws that follow a vehicle. They are the lag's exact motion, a comfortable driver, the safe gap,
//! and the soft end of a stop. A follower is made of these.

pub mod driver;
pub mod kinematics;
pub mod parameters;
pub mod safe_gap;
pub mod soft_stop;

/// Speeds between which ISO 15622's limit of the jerk falls, m/s, and its values there, m/s³.
const JERK_SPEEDS_MPS: (f64, f64) = (5.0, 20.0);
const JERKS_MPS3: (f64, f64) = (5.0, 2.5);
/// Share of that limit which is used: the limit holds for the vehicle, behind the request.
const JERK_SHARE: f64 = 0.9;

/// Fall of the request that passengers do not mind, m/s³.
pub fn comfortable_jerk_mps3(speed_mps: f64) -> f64 {
    let (slow, fast) = JERK_SPEEDS_MPS;
    let share = ((speed_mps - slow) / (fast - slow)).clamp(0.0, 1.0);
    JERK_SHARE * (JERKS_MPS3.0 + share * (JERKS_MPS3.1 - JERKS_MPS3.0))
}
