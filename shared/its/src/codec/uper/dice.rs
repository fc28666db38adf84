//! Random messages: each field that the decoder requests is drawn and written.
//!
//! So every message that the decoder's tables allow can occur. Another decoder checks the tables against the
//! standard.

use super::{Fields, Number, Writer};
use crate::PayloadError;

/// A generator of messages.
pub(in crate::codec) struct Dice {
    state: u64,
    written: Writer,
}

impl Dice {
    pub(in crate::codec) fn new(seed: u64) -> Self {
        Self { state: seed, written: Writer::default() }
    }

    /// The drawn message.
    pub(in crate::codec) fn finish(self) -> Vec<u8> {
        self.written.finish()
    }

    /// A number below `count` (SplitMix64).
    pub(in crate::codec) fn below(&mut self, count: u64) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ self.state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % count
    }

    fn write(&mut self, number: Number, value: i64) -> i64 {
        self.written.whole(number, value).expect("it was drawn within its bounds");
        value
    }
}

impl Fields for Dice {
    fn whole(&mut self, number: Number, _: i64) -> Result<i64, PayloadError> {
        let Number { least, most, .. } = number;
        let value = match self.below(8) {
            0 => least,
            1 => most,
            _ => least + self.below((most - least) as u64 + 1) as i64,
        };
        Ok(self.write(number, value))
    }

    fn pass(&mut self, bits: u64) -> Result<(), PayloadError> {
        (0..bits).try_for_each(|_| self.bit(false).map(drop))
    }

    /// Mostly few, since lists are nested; sometimes the most, if that is a small number.
    fn count(&mut self, number: Number, _: i64) -> Result<i64, PayloadError> {
        let Number { least, most, .. } = number;
        let few = (least + self.below(3) as i64).min(most);
        let count = if self.below(40) == 0 && most <= 20 { most } else { few };
        Ok(self.write(number, count))
    }

    /// Never: the oracle does not skip additions.
    fn extended(&mut self) -> Result<bool, PayloadError> {
        self.written.bit(false)
    }

    fn length(&mut self) -> Result<u64, PayloadError> {
        let long = self.below(20) == 0;
        self.written.bit(long)?;
        let (number, below) = if long {
            self.written.bit(false)?;
            (Number::new("length", 0, 16_383), 200)
        } else {
            (Number::new("length", 0, 127), 9)
        };
        let length = 1 + self.below(below);
        self.write(number, length as i64);
        Ok(length)
    }
}
