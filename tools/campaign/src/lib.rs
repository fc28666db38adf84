//! Many runs: what they have in common ([`batch`]) and the commands that do them.

mod batch;
pub mod campaign;
pub mod compare;
pub mod everyday;
pub mod iso15622;
pub mod parts;
mod plausibility;
pub mod r157;
mod radio;
pub mod reproduce;
pub mod string;
pub mod sweep;
