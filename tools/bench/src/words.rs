//! Words that the processes of a measurement share.

/// Wake-ups so far; the futex.
pub const COUNT: usize = 0;
/// Number of the block that the sink waits for, from 1; 1 for a metronome that ticks.
pub const READY: usize = 16;
/// Number of the block that the source has ended, from 1.
pub const DONE: usize = 32;
/// State of the metronome, [`super::peer::metronome`].
pub const METRONOME: usize = 48;
/// First word of the ring of stamps, two words each.
pub const STAMPS: usize = 64;
pub const RING: usize = 256;
