//! The processes of a group, from their start to their end.

pub mod attendant;
pub mod live_file;
pub mod processes;
pub mod programs;
