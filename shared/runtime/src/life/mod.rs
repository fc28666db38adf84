//! A service's life cycle: the group that it joins, its link to the launcher, its process.

pub mod group;
pub mod link;
pub mod process;
