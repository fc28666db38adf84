//! Drives through signals.

use std::fmt::Write;

use rand_core::Rng;

use super::Draws;
use crate::signals::corridor;

pub fn signals(draws: &mut Draws) -> String {
    let law = draws.one(&["cacc-mpc", "acc-signal-stop"]);
    corridor(draws.random.next_u32().into(), law)
}

pub fn lossy_air(draws: &mut Draws) -> String {
    let mut text = corridor(draws.random.next_u32().into(), "cacc-mpc");
    write!(
        text,
        "[v2x.air]\nloss_probability = {:.2}\ndelay_ms = {:.0}\njitter_ms = {:.0}\nduplicate_probability = {:.2}\n\
         reorder_probability = {:.2}\nreorder_ms = {:.0}\n[v2x.obu]\nclock_offset_ms = {:.0}\n",
        draws.between(0.0, 0.6),
        draws.between(0.0, 300.0),
        draws.between(0.0, 200.0),
        draws.between(0.0, 0.3),
        draws.between(0.0, 0.3),
        draws.between(0.0, 500.0),
        draws.between(-150.0, 150.0),
    )
    .expect("a string takes all");
    text
}
