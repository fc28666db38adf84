//! The tables of the other vehicles: profiles, events, recorded motions, and OpenSCENARIO's storyboards.

pub mod actor;
pub mod event;
pub mod recorded;
pub mod speeds;
pub mod storyboard;
pub mod sumo;
pub mod translation;

mod start_notices;

mod event_script;
