//! Counts of a sender's numbered frames: received, lost, repeated, out of order.

use crate::numbers::Numbers;

/// Numbers that are distinguished; a frame overtaken by more is late. They are the bits of a word.
const WINDOW: u64 = 64;

/// The received numbers of one sender.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sequence {
    pub(crate) numbers: Numbers,
    first: u64,
    highest: u64,
    /// Bit k: `highest - k` was received.
    window: u64,
    /// Received since `first`.
    counted: u64,
    pub(crate) received: u64,
    /// Lost before `first`.
    lost: u64,
    pub(crate) duplicates: u64,
    pub(crate) reordered: u64,
    /// The last number if it was far from all others.
    far: Option<u64>,
    /// Frames refused for a number far from all others.
    pub(crate) implausible: u64,
    /// The last number if it was late, and the number of late ones in a row.
    late: Option<(u64, u32)>,
}

/// True if a number comes soon after another one.
fn follows(last: u64, number: u64) -> bool {
    (1..WINDOW).contains(&number.wrapping_sub(last))
}

impl Sequence {
    /// Adds a number; true for a frame that was not received before.
    pub(crate) fn take(&mut self, number: u64) -> bool {
        if self.received == 0 {
            self.begin(number);
            return true;
        }
        if number.abs_diff(self.highest) > u64::from(self.numbers.far) {
            return self.take_far(number);
        }
        self.far = None;
        let is_late =
            number < self.first || (number < self.highest && self.highest - number >= WINDOW);
        if is_late && self.agrees(number) {
            self.lost = self.lost();
            self.begin(number);
            return true;
        }
        if !is_late {
            self.late = None;
        }
        if number > self.highest {
            let ahead = number - self.highest;
            self.window = if ahead < WINDOW { self.window << ahead } else { 0 } | 1;
            self.highest = number;
            self.count();
            return true;
        }
        let behind = self.highest - number;
        let seen = behind >= WINDOW || self.window & (1 << behind) != 0;
        if seen || number < self.first {
            self.duplicates += 1;
            return false;
        }
        self.window |= 1 << behind;
        self.count();
        self.reordered += 1;
        true
    }

    /// Adds a number far from all others. The following number confirms it, and counting restarts.
    fn take_far(&mut self, number: u64) -> bool {
        if self.far.is_some_and(|far| follows(far, number)) {
            self.lost = self.lost();
            self.begin(number);
            return true;
        }
        self.far = Some(number);
        self.implausible += 1;
        false
    }

    /// Adds a late number; true if it and its predecessors are in order without later numbers between.
    fn agrees(&mut self, number: u64) -> bool {
        let in_a_row = match self.late {
            Some((last, in_a_row)) if follows(last, number) => in_a_row + 1,
            _ => 1,
        };
        self.late = Some((number, in_a_row));
        in_a_row >= self.numbers.agreeing
    }

    fn begin(&mut self, number: u64) {
        (self.first, self.highest, self.window) = (number, number, 1);
        (self.counted, self.far, self.late) = (0, None, None);
        self.count();
    }

    fn count(&mut self) {
        self.counted += 1;
        self.received += 1;
    }

    /// Frames between the first and the last received one that did not arrive.
    pub(crate) fn lost(&self) -> u64 {
        match self.received {
            0 => 0,
            _ => self.lost + self.highest - self.first - (self.counted - 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(numbers: &[u64]) -> (Vec<bool>, [u64; 4]) {
        let mut heard = Sequence::default();
        let new = numbers.iter().map(|&number| heard.take(number)).collect();
        (new, [heard.received, heard.lost(), heard.duplicates, heard.reordered])
    }

    #[test]
    fn gaps_are_lost_and_repeats_are_duplicates() {
        assert_eq!(after(&[7, 8, 9]).1, [3, 0, 0, 0]);
        assert_eq!(after(&[7, 9, 12]).1, [3, 3, 0, 0]);
        assert_eq!(after(&[7, 7, 8, 7]), (vec![true, false, true, false], [2, 0, 2, 0]));
        assert_eq!(after(&[]).1, [0; 4]);
    }

    #[test]
    fn a_frame_that_was_overtaken_is_not_lost() {
        assert_eq!(after(&[1, 3, 2, 4]), (vec![true; 4], [4, 0, 0, 1]));
        assert_eq!(after(&[1, 64, 2]).1, [3, 61, 0, 1]);
    }

    #[test]
    fn after_a_long_gap_old_numbers_are_not_taken_again() {
        assert_eq!(after(&[1, 1000, 1]).1, [2, 998, 1, 0]);
        assert_eq!(after(&[u64::MAX - 1, u64::MAX]).1, [2, 0, 0, 0]);
    }

    #[test]
    fn one_wrong_number_silences_no_sender() {
        let (new, counts) = after(&[1, 2, u64::MAX, 3, 4, 1 << 40, 5]);
        assert_eq!(new, [true, true, false, true, true, false, true]);
        assert_eq!(counts, [5, 0, 0, 0]);
        // Two matching numbers are a new beginning, and so are two of the old ones afterwards.
        let (new, counts) = after(&[1, 3, 1 << 40, (1 << 40) + 1, (1 << 40) + 3, 5, 6, 7]);
        assert_eq!(new, [true, true, false, true, true, false, true, true]);
        assert_eq!(counts, [6, 2, 0, 0]);
    }

    #[test]
    fn a_wrong_number_not_far_ahead_silences_its_sender_for_two_frames() {
        let (new, _) = after(&[1, 2, 2900, 3, 4, 5, 6, 7]);
        assert_eq!(new, [true, true, true, false, false, true, true, true]);
        // Copies of old frames among the sender's own are not a new beginning.
        let (new, _) = after(&[1, 2, 3, 4, 1000, 2, 1001, 3, 1002, 4, 1003]);
        assert_eq!(new[5..], [false, true, false, true, false, true]);
    }
}
