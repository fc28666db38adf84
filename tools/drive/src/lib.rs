//! What was driven: the log of a run's topics, its figures, and the requirements on it.
//!
//! ```text
//! topics ─► DriveLog ─► Drive (steps) ─┬─► requirements: margins and verdicts
//! services' reports ─► GroupOutcome ───┴─► Summary: the figures of `summary.json`
//! ```
//!
//! Nothing here starts a process. The crate `supervise` fills the log while it supervises a run, and `report` shows it.
//!
//! ```
//! use drive::ReferenceDriver;
//!
//! assert_eq!(ReferenceDriver::REGULATION.braking_mps2(0.35), Some(6.0));
//! ```

pub mod exits;
pub mod log;
mod outcome;
pub mod report;
mod requirement;
mod steps;
pub mod summary;

pub use exits::Exit;
pub use log::{Body, DriveLog, EgoPlace, PlaneLog, PlaneScene, Seen, TargetPlace};
pub use outcome::{
    Ended, FaultRecord, GroupOutcome, Heartbeats, Moment, RecordingSummary, Recovery, StandbyCost,
};
pub use requirement::{
    Evidence, ReferenceDriver, Requirement, RequirementError, RequirementVerdict,
    is_avoidable_collision, requirements,
};
pub use steps::{Drive, DriveStep, PowertrainStep, passed_s};
