//! A channel over its last messages: the standard's E2E state machine.

use super::Status;

/// Messages that are looked back on.
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

/// State of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Nothing came yet.
    #[default]
    NoData,
    /// Something came.
    Init,
    /// It can be relied on.
    Valid,
    /// It cannot.
    Invalid,
}

/// Looks back on the last messages of a channel.
#[derive(Clone, Debug, Default)]
pub struct StateMachine {
    state: State,
    window: [Option<Status>; WINDOW],
    next: usize,
}

impl StateMachine {
    /// Takes the status of the next message; returns the state after it.
    pub fn observe(&mut self, status: Status) -> State {
        if self.state == State::NoData {
            if !matches!(status, Status::Error | Status::NoNewData) {
                self.state = State::Init;
                self.remember(status);
            }
            return self.state;
        }
        self.remember(status);
        if self.state == State::Valid && status.is_usable() {
            // It was valid with what the window held, and this made nothing worse.
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

    /// The state.
    #[must_use]
    pub fn state(&self) -> State {
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

    fn run(statuses: &[Status]) -> State {
        let mut machine = StateMachine::default();
        statuses.iter().fold(State::NoData, |_, &status| machine.observe(status))
    }

    #[test]
    fn the_way_up_down_and_up_again() {
        use Status::{Error, NoNewData, Ok};
        assert_eq!(run(&[Error, NoNewData, Error]), State::NoData);
        assert_eq!(run(&[Ok]), State::Init);
        assert_eq!(run(&[Ok, Ok]), State::Valid);
        assert_eq!(run(&[Ok, Ok, Error, Error]), State::Valid);
        assert_eq!(run(&[Ok, Ok, Error, Error, Error]), State::Invalid);
        assert_eq!(run(&[Ok, Ok, Error, Error, Error, Ok, Ok]), State::Invalid);
        assert_eq!(run(&[Ok, Ok, NoNewData, NoNewData, NoNewData, NoNewData]), State::Valid);
        assert_eq!(
            run(&[Ok, Ok].into_iter().chain([NoNewData; 6]).collect::<Vec<_>>()),
            State::Invalid
        );
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
            prop_assert_eq!(machine.state(), State::Valid);
        }
    }
}
