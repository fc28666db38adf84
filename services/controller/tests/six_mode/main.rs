//! The six-mode law in closed loop: the published run, the traps, random traffic.

mod plant;
mod published;
mod traffic;
mod traps;
