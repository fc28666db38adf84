//! One message against the one before it: the standard's check of the counter.

/// Most messages that may be missing between two for the second one to be used: a consumer that was
/// away longer re-joins by its state machine.
const MAX_DELTA_COUNTER: u32 = 64;

/// What the check says of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Intact, next in sequence.
    Ok,
    /// Intact, some before it were lost.
    OkSomeLost,
    /// The same counter again.
    Repeated,
    /// The counter went back, or too far ahead.
    WrongSequence,
    /// CRC, length or data ID do not fit.
    Error,
    /// No message.
    NoNewData,
}

impl Status {
    /// True if the message by itself is fit for use.
    #[must_use]
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Ok | Self::OkSomeLost)
    }
}

/// The counter of a channel.
#[derive(Clone, Debug, Default)]
pub struct Check {
    last: Option<u32>,
}

impl Check {
    /// Judges a message by its counter; `None` is one whose bytes are corrupted.
    pub fn judge(&mut self, counter: Option<u32>) -> Status {
        let Some(counter) = counter else { return Status::Error };
        let delta = self.last.map_or(1, |last| counter.wrapping_sub(last));
        self.last = Some(counter);
        match delta {
            0 => Status::Repeated,
            1 => Status::Ok,
            2..=MAX_DELTA_COUNTER => Status::OkSomeLost,
            _ => Status::WrongSequence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_by_the_book() {
        let mut check = Check::default();
        let statuses: Vec<Status> =
            [Some(7), Some(8), Some(8), Some(10), None, Some(11), Some(9), Some(200), Some(201)]
                .map(|counter| check.judge(counter))
                .to_vec();
        use Status::{Error, Ok, OkSomeLost, Repeated, WrongSequence};
        let expected =
            [Ok, Ok, Repeated, OkSomeLost, Error, Ok, WrongSequence, WrongSequence, Ok].to_vec();
        assert_eq!(statuses, expected);
    }

    #[test]
    fn the_counter_wraps() {
        let mut check = Check { last: Some(u32::MAX) };
        assert_eq!(check.judge(Some(0)), Status::Ok);
    }
}
