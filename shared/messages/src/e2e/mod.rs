//! End-to-end protection of every message, in the terms of the AUTOSAR E2E protocol (R22-11).
//!
//! ```text
//! bytes ─► profile7::check ─► counter ─────────► StateMachine ─► used, or not
//!          CRC, length, ID    of the one before  last six
//!                └──────────────┴── Outcomes ─────┘ counts
//! ```
//!
//! [`profile7`] protects the bytes of one message and checks them. A [`Channel`] judges the messages of one sender on
//! one topic: by their bytes, by their counter, and by its state over the last messages. A consumer uses a message only
//! if its channel accepts it.
//!
//! In a message of this size the CRC-64 detects every corruption of up to 3 bits. It detects every burst of
//! up to 64 bits. It misses one in 2⁶⁴ of all others.

pub mod profile7;
mod state_machine;

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use state_machine::{State, StateMachine, Status};

/// Largest step of the counter after which a message is used. A consumer that missed more joins again through its
/// state machine.
const MAX_DELTA_COUNTER: u32 = 64;

/// Counts of each outcome on a topic.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, Serialize, Deserialize)]
pub struct Outcomes {
    /// Intact, next in sequence.
    pub ok: u64,
    /// Intact; messages before it were lost, no more than allowed.
    pub ok_some_lost: u64,
    /// The same counter again.
    pub repeated: u64,
    /// The counter went back, or ahead by more than allowed.
    pub wrong_sequence: u64,
    /// Wrong CRC, length or data ID.
    pub error: u64,
    /// No message came although one was due.
    pub no_new_data: u64,
    /// Sent by a process that is not a member of the group; `stranger` in results.
    #[serde(rename = "stranger")]
    pub unknown_sender: u64,
    /// Accepted, and stamped later than the receiver's present: the stamps were moved back to it.
    pub from_the_future: u64,
    /// Intact, but its channel is invalid: not used.
    pub distrusted: u64,
}

impl Outcomes {
    /// Messages that were received and refused.
    pub fn refused(&self) -> u64 {
        self.repeated + self.wrong_sequence + self.error + self.unknown_sender + self.distrusted
    }

    fn count(&mut self, status: Status) {
        let counts: &mut [u64; 9] = bytemuck::cast_mut(self);
        counts[status as usize] += 1;
    }

    /// Adds the counts of another consumer.
    pub fn add(&mut self, other: &Self) {
        let counts: &mut [u64; 9] = bytemuck::cast_mut(self);
        counts.iter_mut().zip(bytemuck::cast::<_, [u64; 9]>(*other)).for_each(|(a, b)| *a += b);
    }
}

/// One sender on one topic, judged by one consumer.
#[derive(Clone, Debug, Default)]
pub struct Channel {
    /// Counter of the last intact message.
    last: Option<u32>,
    machine: StateMachine,
    incarnation: u32,
}

impl Channel {
    /// Judges a message from process `incarnation` of its sender, and counts the outcome; true if it can
    /// be used.
    pub fn accept(
        &mut self,
        bytes: &[u8],
        data_id: u32,
        incarnation: u32,
        outcomes: &mut Outcomes,
    ) -> bool {
        let received = profile7::check(bytes, data_id);
        if received.is_ok() && incarnation > self.incarnation {
            // A restarted sender counts from 1 again, on a new channel.
            *self = Self { incarnation, ..Self::default() };
        }
        let mut status = self.compare(received.ok());
        if status.is_usable() && incarnation < self.incarnation {
            // A message of a sender that was replaced.
            status = Status::WrongSequence;
        }
        outcomes.count(status);
        let state = self.machine.observe(status);
        let usable = status.is_usable() && state != State::Invalid;
        outcomes.distrusted += u64::from(status.is_usable() && !usable);
        usable
    }

    /// Notes that no message came although one was due.
    pub fn nothing_new(&mut self, outcomes: &mut Outcomes) {
        outcomes.count(Status::NoNewData);
        self.machine.observe(Status::NoNewData);
    }

    /// The standard's check of the counter against that of the message before; `None` stands for corrupted bytes.
    fn compare(&mut self, counter: Option<u32>) -> Status {
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
        assert_eq!(channel.machine.state, State::Valid);
    }

    #[test]
    fn a_restarted_sender_begins_anew_and_its_earlier_process_is_refused() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(70), 5, 0, &mut outcomes));
        assert!(channel.accept(&message(1), 5, 1, &mut outcomes));
        assert!(!channel.accept(&message(71), 5, 0, &mut outcomes));
        assert_eq!((outcomes.ok, outcomes.wrong_sequence), (2, 1));
    }

    #[test]
    fn a_channel_with_errors_is_invalid_until_five_messages_in_order() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(1), 5, 0, &mut outcomes));
        for counter in 2..=6 {
            let mut bad = message(counter);
            bad[40] ^= 1;
            assert!(!channel.accept(&bad, 5, 0, &mut outcomes));
        }
        assert_eq!(channel.machine.state, State::Invalid);
        let used = [7, 8, 9, 10, 11, 12, 13, 14]
            .map(|counter| channel.accept(&message(counter), 5, 0, &mut outcomes));
        assert_eq!(used, [false, false, false, false, true, true, true, true]);
        let expected =
            Outcomes { ok: 8, ok_some_lost: 1, error: 5, distrusted: 4, ..Outcomes::default() };
        assert_eq!(outcomes, expected);
        assert_eq!(outcomes.refused(), 9);
    }

    #[test]
    fn each_outcome_has_its_count() {
        let (mut channel, mut outcomes) = channel();
        let mut accept = |counter, id, incarnation| {
            let before = outcomes;
            let is_used = channel.accept(&message(counter), id, incarnation, &mut outcomes);
            (is_used, before, outcomes)
        };
        let (used, before, after) = accept(1, 5, 1);
        assert_eq!((used, after), (true, Outcomes { ok: 1, ..before }));
        let (used, before, after) = accept(3, 5, 1);
        assert_eq!((used, after), (true, Outcomes { ok_some_lost: 1, ..before }));
        let (used, before, after) = accept(3, 5, 1);
        assert_eq!((used, after), (false, Outcomes { repeated: 1, ..before }));
        let (used, before, after) = accept(500, 5, 1);
        assert_eq!((used, after), (false, Outcomes { wrong_sequence: 1, ..before }));
        let (used, before, after) = accept(501, 6, 1);
        assert_eq!((used, after), (false, Outcomes { error: 1, ..before }));
        // A message of the process before, in the right order and repeated.
        let (used, before, after) = accept(501, 5, 0);
        assert_eq!((used, after), (false, Outcomes { wrong_sequence: 2, ..before }));
        let (used, before, after) = accept(501, 5, 0);
        assert_eq!((used, after), (false, Outcomes { repeated: 2, ..before }));
        assert_eq!(outcomes.refused(), 5);
    }

    #[test]
    fn silence_makes_a_channel_invalid_and_is_counted() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(1), 5, 0, &mut outcomes));
        assert!(channel.accept(&message(2), 5, 0, &mut outcomes));
        (0..5).for_each(|_| channel.nothing_new(&mut outcomes));
        assert_eq!(channel.machine.state, State::Valid);
        channel.nothing_new(&mut outcomes);
        assert_eq!((channel.machine.state, outcomes.no_new_data), (State::Invalid, 6));
        assert_eq!(outcomes.refused(), 0);
    }

    #[test]
    fn a_corrupted_message_of_a_later_process_changes_no_process() {
        let (mut channel, mut outcomes) = channel();
        assert!(channel.accept(&message(1), 5, 0, &mut outcomes));
        assert!(!channel.accept(&message(1), 6, 1, &mut outcomes));
        assert!(channel.accept(&message(2), 5, 0, &mut outcomes));
        assert_eq!((outcomes.ok, outcomes.error), (2, 1));
    }

    #[test]
    fn counters_by_the_book() {
        let mut channel = Channel::default();
        let statuses: Vec<Status> =
            [Some(7), Some(8), Some(8), Some(10), None, Some(11), Some(9), Some(200), Some(201)]
                .map(|counter| channel.compare(counter))
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
            let mut channel = Channel { last: Some(1000), ..Channel::default() };
            let status = channel.compare(Some(1000_u32.wrapping_add(step)));
            // Each counter becomes the next one's reference, whatever its status was.
            assert_eq!(channel.compare(Some(1001_u32.wrapping_add(step))), Ok);
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
        let mut channel = Channel { last: Some(u32::MAX), ..Channel::default() };
        assert_eq!(channel.compare(Some(0)), Status::Ok);
    }

    #[test]
    fn counts_of_consumers_add_up_one_by_one() {
        let mut sum = Outcomes {
            ok: 1,
            ok_some_lost: 2,
            repeated: 4,
            wrong_sequence: 8,
            error: 16,
            no_new_data: 32,
            unknown_sender: 64,
            from_the_future: 128,
            distrusted: 256,
        };
        assert_eq!(sum.refused(), 4 + 8 + 16 + 64 + 256);
        sum.add(&Outcomes {
            ok: 1000,
            ok_some_lost: 2000,
            repeated: 3000,
            wrong_sequence: 4000,
            error: 5000,
            no_new_data: 6000,
            unknown_sender: 7000,
            from_the_future: 8000,
            distrusted: 9000,
        });
        let json = serde_json::json!(sum);
        let expected = serde_json::json!({
            "ok": 1001, "ok_some_lost": 2002, "repeated": 3004, "wrong_sequence": 4008,
            "error": 5016, "no_new_data": 6032, "stranger": 7064, "from_the_future": 8128,
            "distrusted": 9256,
        });
        assert_eq!(json, expected);
    }
}
