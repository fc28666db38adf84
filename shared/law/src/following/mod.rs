//! Common parts of the laws that follow a vehicle. They are the lag's exact motion, a comfortable driver, the safe gap,
//! and the soft end of a stop. A follower is made of these.

pub mod driver;
pub mod kinematics;
pub mod parameters;
pub mod safe_gap;
pub mod soft_stop;
