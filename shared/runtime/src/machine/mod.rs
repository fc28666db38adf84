//! Requests of a service to the machine: scheduling, processes, threads, programs.

pub mod background;
pub mod program;
pub mod scheduling;
pub mod spawn;
pub mod usage;
