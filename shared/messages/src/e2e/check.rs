//! The standard's check of the counter: one message against the message before it.

/// Largest step of the counter after which a message is used. A consumer that missed more joins again through its
/// state machine.
const MAX_DELTA_COUNTER: u32 = 64;

/// Result of the check of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Intact, next in sequence.
    Ok,
    /// Intact; messages before it were lost.
    OkSomeLost,
    /// The same counter again.
    Repeated,
    /// The counter went back, or too far ahead.
    WrongSequence,
    /// Wrong CRC, length or data ID.
    Error,
    /// No message.
    NoNewData,
}

impl Status {
    /// True if the message alone can be used.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Ok | Self::OkSomeLost)
    }
}

/// The counter of a channel.
///
/// ```
/// use messages::e2e::{Check, Status};
///
/// let mut check = Check::default();
/// assert_eq!(check.judge(Some(7)), Status::Ok);
/// assert_eq!(check.judge(Some(9)), Status::OkSomeLost);
/// assert_eq!(check.judge(Some(9)), Status::Repeated);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Check {
    last: Option<u32>,
}

impl Check {
    /// Judges a message by its counter; `None` stands for corrupted bytes.
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
    fn a_step_of_the_counter_has_its_status() {
        use Status::{Ok, OkSomeLost, Repeated, WrongSequence};
        let after = |step: u32| {
            let mut check = Check { last: Some(1000) };
            let status = check.judge(Some(1000_u32.wrapping_add(step)));
            // Each counter becomes the next one's reference, whatever its status was.
            assert_eq!(check.judge(Some(1001_u32.wrapping_add(step))), Ok);
            status
        };
        let statuses = [0, 1, 2, 64, 65, u32::MAX].map(after);
        assert_eq!(statuses, [Repeated, Ok, OkSomeLost, OkSomeLost, WrongSequence, WrongSequence]);
    }

    #[test]
    fn two_statuses_are_usable() {
        use Status::{Error, NoNewData, Ok, OkSomeLost, Repeated, WrongSequence};
        assert!(Ok.is_usable() && OkSomeLost.is_usable());
        let others = [Repeated, WrongSequence, Error, NoNewData];
        assert!(!others.into_iter().any(Status::is_usable));
    }

    #[test]
    fn the_counter_wraps() {
        let mut check = Check { last: Some(u32::MAX) };
        assert_eq!(check.judge(Some(0)), Status::Ok);
    }
}
