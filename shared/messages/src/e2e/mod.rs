//! End-to-end protection of every message, in the terms of the AUTOSAR E2E protocol (R22-11).
//!
//! [`profile7`] protects the bytes of one message and checks them: CRC-64, length, counter, data ID.
//! [`Check`] judges one message against the one before it on its channel, [`StateMachine`] judges the
//! channel over its last messages. A [`Channel`] is both, for one sender on one topic; a consumer
//! uses a message only if its channel accepts it.
//!
//! What the CRC-64 promises: every corruption of up to 3 bits and every burst of up to 64 bits in a
//! message of this size is detected; of all others one in 2⁶⁴ is not.

mod check;
pub mod profile7;
mod state_machine;

pub use check::{Check, Status};
pub use state_machine::{State, StateMachine};

use serde::{Deserialize, Serialize};

/// How often each outcome was seen on a topic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcomes {
    /// Intact, next in sequence.
    pub ok: u64,
    /// Intact, some before it were lost, but no more than allowed.
    pub ok_some_lost: u64,
    /// The same counter again.
    pub repeated: u64,
    /// The counter went back, or ahead by more than allowed.
    pub wrong_sequence: u64,
    /// CRC, length or data ID do not fit.
    pub error: u64,
    /// Nothing came although it was due.
    pub no_new_data: u64,
    /// Sent by a process that is no member of the group. In results it keeps its first name.
    #[serde(rename = "stranger")]
    pub unknown_sender: u64,
    /// Stamped later than it could have been.
    pub from_the_future: u64,
    /// Intact, but not used since its channel is not trusted for now.
    pub distrusted: u64,
}

impl Outcomes {
    /// Messages that came and were refused for what they are.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.repeated
            + self.wrong_sequence
            + self.error
            + self.unknown_sender
            + self.from_the_future
            + self.distrusted
    }

    fn count(&mut self, status: Status) {
        let place = match status {
            Status::Ok => &mut self.ok,
            Status::OkSomeLost => &mut self.ok_some_lost,
            Status::Repeated => &mut self.repeated,
            Status::WrongSequence => &mut self.wrong_sequence,
            Status::Error => &mut self.error,
            Status::NoNewData => &mut self.no_new_data,
        };
        *place += 1;
    }

    /// Adds the counts of another consumer.
    pub fn add(&mut self, other: &Self) {
        self.ok += other.ok;
        self.ok_some_lost += other.ok_some_lost;
        self.repeated += other.repeated;
        self.wrong_sequence += other.wrong_sequence;
        self.error += other.error;
        self.no_new_data += other.no_new_data;
        self.unknown_sender += other.unknown_sender;
        self.from_the_future += other.from_the_future;
        self.distrusted += other.distrusted;
    }
}

/// One sender on one topic, as a consumer judges it.
#[derive(Clone, Debug, Default)]
pub struct Channel {
    check: Check,
    machine: StateMachine,
    incarnation: u32,
}

impl Channel {
    /// Judges a message, which says it is of `incarnation`, and counts the outcome; true if it may be
    /// used.
    pub fn accept(
        &mut self,
        bytes: &[u8],
        data_id: u32,
        incarnation: u32,
        outcomes: &mut Outcomes,
    ) -> bool {
        self.judge(profile7::check(bytes, data_id), incarnation, outcomes)
    }

    /// The same of a message that no other code could write to since it was protected.
    pub fn accept_as_sent(
        &mut self,
        bytes: &[u8],
        data_id: u32,
        incarnation: u32,
        outcomes: &mut Outcomes,
    ) -> bool {
        self.judge(profile7::check_as_sent(bytes, data_id), incarnation, outcomes)
    }

    fn judge(
        &mut self,
        received: Result<u32, profile7::Corrupted>,
        incarnation: u32,
        outcomes: &mut Outcomes,
    ) -> bool {
        if received.is_ok() && incarnation > self.incarnation {
            // A restarted sender counts from 1 again and has to earn nothing: it is fresh.
            *self = Self { incarnation, ..Self::default() };
        }
        let mut status = self.check.judge(received.ok());
        if status.is_usable() && incarnation < self.incarnation {
            // Left over from a dead sender.
            status = Status::WrongSequence;
        }
        outcomes.count(status);
        let state = self.machine.observe(status);
        let usable = status.is_usable() && state != State::Invalid;
        outcomes.distrusted += u64::from(status.is_usable() && !usable);
        usable
    }

    /// Notes that nothing came although it was due.
    pub fn nothing_new(&mut self, outcomes: &mut Outcomes) {
        outcomes.count(Status::NoNewData);
        self.machine.observe(Status::NoNewData);
    }

    /// What the state machine makes of the channel.
    #[must_use]
    pub fn state(&self) -> State {
        self.machine.state()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(counter: u32) -> [u8; 48] {
        let mut bytes = [7; 48];
        profile7::protect(&mut bytes, 5, counter);
        bytes
    }

    fn channel() -> (Channel, Outcomes) {
        (Channel::default(), Outcomes::default())
    }

    #[test]
    fn the_first_message_and_its_successors_are_used() {
        let (mut channel, mut outcomes) = channel();
        for counter in 1..=5 {
            assert!(channel.accept(&message(counter), 5, 0, &mut outcomes));
        }
        assert_eq!((outcomes.ok, outcomes.refused()), (5, 0));
        assert_eq!(channel.state(), State::Valid);
    }

    #[test]
    fn a_restarted_sender_is_fresh_and_its_dead_self_is_not_heard() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(70), 5, 0, &mut outcomes));
        assert!(channel.accept(&message(1), 5, 1, &mut outcomes));
        assert!(!channel.accept(&message(71), 5, 0, &mut outcomes));
        assert_eq!((outcomes.ok, outcomes.wrong_sequence), (2, 1));
    }

    #[test]
    fn a_channel_full_of_errors_is_distrusted_until_it_has_proved_itself() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(1), 5, 0, &mut outcomes));
        for counter in 2..=6 {
            let mut bad = message(counter);
            bad[40] ^= 1;
            assert!(!channel.accept(&bad, 5, 0, &mut outcomes));
        }
        assert_eq!(channel.state(), State::Invalid);
        let used: Vec<bool> = (7..=14)
            .map(|counter| channel.accept(&message(counter), 5, 0, &mut outcomes))
            .collect();
        assert!(!used[0] && used[7], "{used:?}");
        assert!(outcomes.distrusted > 0 && outcomes.error == 5);
    }
}
