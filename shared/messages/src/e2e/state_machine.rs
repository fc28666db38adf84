//! The standard's E2E state machine: a channel over its last six messages.
//!
//! ```text
//!            not an error                  1 usable, at most 1 error
//!   NoData ──────────────► Init ─────────────────────────────────────► Valid
//!                            │                                         │   ▲
//!                            │ 2 errors            3 errors, or none   │   │ 3 usable, at
//!                            │                     of 6 usable         ▼   │ most 1 error
//!                            └───────────────────────────────────────► Invalid
//! ```

const WINDOW: usize = 6;
/// Usable messages in the window that make a new channel valid.
const MIN_OK_INIT: usize = 1;
/// Errors in the window that a new channel may have.
const MAX_ERROR_INIT: usize = 1;
/// Usable messages in the window that keep a channel valid.
const MIN_OK_VALID: usize = 1;
/// Errors in the window that a valid channel may have.
const MAX_ERROR_VALID: usize = 2;
/// Usable messages in the window that make an invalid channel valid again.
const MIN_OK_INVALID: usize = 3;
/// Errors in the window that an invalid channel may have to become valid again.
const MAX_ERROR_INVALID: usize = 1;

/// Result of the check of one message, in the order of [`Outcomes`](super::Outcomes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
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
    NoNewData,
}

impl Status {
    /// True if the message alone can be used.
    pub(super) fn is_usable(self) -> bool {
        matches!(self, Self::Ok | Self::OkSomeLost)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum State {
    /// No message was received.
    #[default]
    NoData,
    /// The first messages were received.
    Init,
    /// Its messages are used.
    Valid,
    /// Its messages are not used.
    Invalid,
}

/// Keeps the last messages of a channel, and its state.
#[derive(Clone, Debug, Default)]
pub(super) struct StateMachine {
    pub(super) state: State,
    window: [Option<Status>; WINDOW],
    next: usize,
}

impl StateMachine {
    /// Takes the status of the next message; returns the state after it.
    pub(super) fn observe(&mut self, status: Status) -> State {
        if self.state == State::NoData {
            if !matches!(status, Status::Error | Status::NoNewData) {
                self.state = State::Init;
                self.remember(status);
            }
            return self.state;
        }
        self.remember(status);
        if self.state == State::Valid && status.is_usable() {
            // A usable message never makes a valid channel invalid.
            return self.state;
        }
        let ok = self.count(Status::is_usable);
        let errors = self.count(|status| status == Status::Error);
        self.state = match self.state {
            State::Init if errors > MAX_ERROR_INIT => State::Invalid,
            State::Init if ok >= MIN_OK_INIT => State::Valid,
            State::Valid if errors > MAX_ERROR_VALID || ok < MIN_OK_VALID => State::Invalid,
            State::Invalid if errors <= MAX_ERROR_INVALID && ok >= MIN_OK_INVALID => State::Valid,
            state => state,
        };
        self.state
    }

    fn remember(&mut self, status: Status) {
        self.window[self.next] = Some(status);
        self.next = (self.next + 1) % WINDOW;
    }

    fn count(&self, which: impl Fn(Status) -> bool) -> usize {
        self.window.iter().flatten().filter(|&&status| which(status)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    use Status::{Error, NoNewData, Ok, OkSomeLost, Repeated, WrongSequence};

    /// States after each of `statuses`.
    fn states<const N: usize>(statuses: [Status; N]) -> [State; N] {
        let mut machine = StateMachine::default();
        statuses.map(|status| {
            let state = machine.observe(status);
            assert_eq!(machine.state, state);
            state
        })
    }

    #[test]
    fn any_message_but_an_error_begins_and_a_usable_one_makes_valid() {
        use State::{Init, Invalid, NoData, Valid};
        assert_eq!(states([Error, NoNewData, Error]), [NoData; 3]);
        assert_eq!(states([Repeated, Repeated, WrongSequence]), [Init; 3]);
        for usable in [Ok, OkSomeLost] {
            assert_eq!(states([usable, usable]), [Init, Valid]);
        }
        // Errors before the first message do not count; one after it does no harm, two do.
        assert_eq!(states([Error, Ok, Error]), [NoData, Init, Valid]);
        assert_eq!(states([Repeated, Error, Ok]), [Init, Init, Valid]);
        assert_eq!(states([Repeated, Error, Error]), [Init, Init, Invalid]);
    }

    #[test]
    fn three_errors_of_six_messages_or_six_without_a_usable_one_make_invalid() {
        use State::{Init, Invalid, Valid};
        assert_eq!(states([Ok, Ok, Error, Error, Error]), [Init, Valid, Valid, Valid, Invalid]);
        // The first of four errors has left the window when the third of the others comes.
        let spread = [Ok, Error, Ok, Ok, Ok, Ok, Error, Error, Error];
        assert_eq!(states(spread)[5..], [Valid, Valid, Valid, Invalid]);
        for useless in [NoNewData, Repeated, WrongSequence] {
            let [.., fifth, sixth] =
                states([Ok, Ok, useless, useless, useless, useless, useless, useless]);
            assert_eq!((fifth, sixth), (Valid, Invalid));
        }
    }

    #[test]
    fn three_usable_messages_and_at_most_one_error_make_valid_again() {
        use State::{Invalid, Valid};
        let [.., first, second, third] = states([
            Ok, Ok, NoNewData, NoNewData, NoNewData, NoNewData, NoNewData, NoNewData, Ok, Ok, Ok,
        ]);
        assert_eq!([first, second, third], [Invalid, Invalid, Valid]);
        let after_errors = states([Ok, Ok, Error, Error, Error, Ok, Ok, Ok, Ok, Ok]);
        assert_eq!(after_errors[5..], [Invalid, Invalid, Invalid, Invalid, Valid]);
    }

    /// The table of the standard over the whole history, without a ring.
    fn by_the_book(history: &[Status]) -> State {
        let begin = history.iter().position(|status| !matches!(status, Error | NoNewData));
        let Some(begin) = begin else { return State::NoData };
        let mut state = State::Init;
        for end in begin + 2..=history.len() {
            let window = &history[begin.max(end.saturating_sub(6))..end];
            let errors = window.iter().filter(|status| **status == Error).count();
            let ok = window.iter().filter(|status| matches!(status, Ok | OkSomeLost)).count();
            state = match state {
                State::Init if errors >= 2 => State::Invalid,
                State::Init if ok >= 1 => State::Valid,
                State::Valid if errors >= 3 || ok == 0 => State::Invalid,
                State::Invalid if errors <= 1 && ok >= 3 => State::Valid,
                state => state,
            };
        }
        state
    }

    #[test]
    fn all_histories_of_ten_messages_are_as_in_the_table() {
        for number in 0..3_usize.pow(10) {
            let digit = |place: u32| [Ok, Error, Repeated][number / 3_usize.pow(place) % 3];
            let history: Vec<Status> = (0..10).map(digit).collect();
            let mut machine = StateMachine::default();
            let state = history.iter().fold(State::NoData, |_, &status| machine.observe(status));
            assert_eq!(state, by_the_book(&history), "{history:?}");
        }
    }

    proptest! {
        #[test]
        fn every_history_ends_valid_after_enough_good_messages(
            history in prop::collection::vec(prop::sample::select(vec![
                Status::Ok, Status::OkSomeLost, Status::Repeated, Status::WrongSequence,
                Status::Error, Status::NoNewData]), 0..60),
        ) {
            let mut machine = StateMachine::default();
            for status in history {
                machine.observe(status);
            }
            for _ in 0..WINDOW {
                machine.observe(Status::Ok);
            }
            prop_assert_eq!(machine.state, State::Valid);
        }
    }
}
