//! UN Regulation No. 157 (automated lane keeping): when is a collision preventable?
//!
//! Both vehicles are 4.3 m by 1.9 m. The ego has the speed `v`, the other has `v_o`. `d` is the distance from bumper to
//! bumper. `s` is the clearance between the vehicles' sides, negative in lateral overlap. `w` is the other's lateral
//! speed. A *model* says when an attentive driver, or a defined system, would have begun to brake, and how hard:
//!
//! | model | begins when | brakes |
//! | --- | --- | --- |
//! | [`Model::CarefulDriver`] | `s <= 0` and `d/(v-v_o) <= 2 s` | 0.75 s later, up to 0.774 g |
//! | [`Model::Regulation`] | `s <= 0.5 m` and `d/(v-v_o) < (v-v_o)/(2·6) + 0.45 s` | 0.35 s later, 6 m/s² |
//! | [`Model::Rss`] | both safe distances are fallen short of | 0.75 s later, up to 0.774 g |
//! | [`Model::Fuzzy`] | a proactive or a critical measure is above 0 | 0.75 s later, by the measure |
//!
//! [`Driver`] is a model with its memory: a plain function of state, view and one step of 0.1 s. The models drive three
//! matrices of cases ([`cut_in`], [`following`], [`cut_out`]) to an [`Outcome`]. A case is *mastered* by a model if its
//! outcome is [`Outcome::None`]. A system should master the cases that both of the regulation's models master.
//!
//! [`r157`] drives our laws through these matrices and judges them by the models. [`iso15622`] runs the tests of
//! adaptive cruise control.
//!
//! Sources: UN R157, paragraph 5.2.5.2 and annex 4, appendix 3. Mattas and others, "Fuzzy surrogate safety metrics for
//! real-time assessment of rear-end collision risk", Accident Analysis & Prevention 148 (2020) 105794. Shalev-Shwartz
//! and others, "On a formal model of safe and scalable self-driving cars" (2017).

#![forbid(unsafe_code)]

mod contact;
pub mod cut_in;
pub mod cut_out;
pub mod following;
pub mod iso15622;
mod models;
pub mod r157;

pub use contact::{Outcome, Verdict, contact};
pub use models::{Driver, Model, View};

pub const VEHICLE_LENGTH_M: f64 = 4.3;
pub const VEHICLE_WIDTH_M: f64 = 1.9;
pub const STEP_S: f64 = 0.1;
pub const GRAVITY_MPS2: f64 = 9.81;

/// Speeds in the matrices are whole kilometres an hour.
fn mps(kmh: u32) -> f64 {
    f64::from(kmh) / 3.6
}
