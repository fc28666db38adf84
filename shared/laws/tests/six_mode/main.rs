//! The six-mode law in closed loop: the published run, the traps, random traffic, gentle braking.

mod graded;
mod plant;
mod published;
mod traffic;
mod traps;
