//! The tables of the ego: the vehicle, what it perceives, and what controls it.

pub mod aebs;
pub mod controller;
pub mod lateral;
pub mod own_law;
pub mod perception;
pub mod plant;
