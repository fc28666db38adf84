//! The tables of the roadside: signals, maps, and the radio that carries them.

pub mod carrier;
pub mod radio;
pub mod v2x;
