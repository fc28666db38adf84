//! What came of a sender's numbered frames: received, lost, received twice, out of order.

/// The numbers heard of one sender. The last 64 are told apart; what comes later than that is late.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Numbers {
    first: u64,
    highest: u64,
    /// Bit k: `highest - k` was received.
    window: u64,
    received: u64,
    duplicates: u64,
    reordered: u64,
}

impl Numbers {
    /// Takes a number; true if the frame is heard for the first time.
    pub(crate) fn take(&mut self, number: u64) -> bool {
        if self.received == 0 {
            *self = Self { first: number, highest: number, window: 1, received: 1, ..*self };
            return true;
        }
        if number > self.highest {
            let ahead = number - self.highest;
            self.window = if ahead < 64 { self.window << ahead } else { 0 } | 1;
            self.highest = number;
            self.received += 1;
            return true;
        }
        let behind = self.highest - number;
        let seen = behind >= 64 || self.window & (1 << behind) != 0;
        if seen || number < self.first {
            self.duplicates += 1;
            return false;
        }
        self.window |= 1 << behind;
        self.received += 1;
        self.reordered += 1;
        true
    }

    pub(crate) fn received(&self) -> u64 {
        self.received
    }

    /// Frames between the first and the last heard that never came.
    pub(crate) fn lost(&self) -> u64 {
        if self.received == 0 { 0 } else { self.highest - self.first - (self.received - 1) }
    }

    pub(crate) fn duplicates(&self) -> u64 {
        self.duplicates
    }

    pub(crate) fn reordered(&self) -> u64 {
        self.reordered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(numbers: &[u64]) -> (Vec<bool>, [u64; 4]) {
        let mut heard = Numbers::default();
        let new = numbers.iter().map(|&number| heard.take(number)).collect();
        (new, [heard.received(), heard.lost(), heard.duplicates(), heard.reordered()])
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
}
