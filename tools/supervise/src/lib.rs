//! A process group: its private corner of the machine, its processes, its end.
//!
//! ```text
//! RunRoot::create ─ janitor ─ spawn services ─ all ready ─ start ─ events … ─ all reported ─ end ─ wipe
//! ```
//!
//! The launcher holds a lock on the run's root and every service inherits it. The lock is free when the last of them is
//! gone, for whatever reason. The janitor is a process of its own. It waits for the lock when the launcher dies, and
//! removes the remains of the run. The next run removes the rest that even the janitor could not.
//!
//! In lockstep the same services can also take turns in the launcher's own thread: [`in_process`].
//!
//! During a realtime run the supervisor keeps the group whole. It replaces a service that dies or hangs, within its
//! budget. `drive::exits` is the table of all ends. [`faults`] applies the faults of the scenario
//! and those that come in at [`control`].

pub mod control;
mod error;
mod events;
mod faults;
pub mod in_process;
mod member;
mod options;
mod recording;
mod refusal;
mod replay;
mod role;
mod root;
mod run;
mod start;
pub mod succession;
mod supervisor;

pub use drive::{
    Body, Drive, DriveStep, EgoPlace, Ended, Evidence, Exit, FaultRecord, GroupOutcome, Heartbeats,
    Moment, PlaneLog, PlaneScene, PowertrainStep, RecordingSummary, Recovery, ReferenceDriver,
    Requirement, RequirementError, RequirementVerdict, Seen, StandbyCost, TargetPlace,
    is_avoidable_collision, passed_s, report, requirements,
};
pub use error::{Error, Failure, MachineError, Status, UsageError};
pub use events::{Event, Who, flag_end, follow_signals, hold_signals, is_signalled};
pub use faults::disturbance::{Disturbance, run as run_hog};
pub use faults::log::FaultLog;
pub use in_process::entry;
pub use options::laws::{LawOptions, LawSource, NamedLaw};
pub use options::{GroupOptions, ScenarioOptions, mode, number_within, service_program};
pub use recording::law_names;
pub use refusal::{absent, check_simulated, check_targets};
pub use replay::{Replayed, replay};
pub use role::Role;
pub use root::dead_runs::{DeadRun, dead_runs};
pub use root::{RunRoot, base, check_room, is_alive, shared_memory_room};
pub use run::{Keep, Opening, drive, is_openscenario, open, open_with};
pub use start::attendant::{Attendant, run as run_janitor};
pub use start::of_service;
pub use start::processes::{Janitor, Launch, Process, this_program};
pub use supervisor::launch;
pub use supervisor::roster::Roster;
