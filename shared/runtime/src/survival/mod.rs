//! What outlives a process of a service, or replaces it.

pub mod account;
pub mod checkpoint;
pub mod end_word;
pub mod fence;
pub mod gate;
pub mod kept;
pub mod kept_buckets;
pub mod standby;
