//! Words that the processes of a measurement share.

/// Wake-ups so far; the futex.
pub const COUNT: usize = 0;
/// 1 once the sink waits.
pub const READY: usize = 16;
/// Number of the block that the sink waits for, from 1.
pub const BLOCK_READY: usize = 24;
/// Number of all wake-ups plus 1, once the source has finished.
pub const DONE: usize = 32;
/// Number of the block that the source has ended, from 1.
pub const BLOCK_DONE: usize = 40;
/// State of the metronome, [`super::peer::metronome`].
pub const METRONOME: usize = 48;
/// First word of the ring of stamps, two words each.
pub const STAMPS: usize = 64;
pub const RING: usize = 256;
