//! The air between roadside units and the vehicle: frames are lost, late, repeated and falsified.
//!
//! Plain code: the same frames, times and seed give the same arrivals. Each frame takes the same number of random
//! draws, so that one key does not move the draws of another.
//!
//! ```text
//! send ─► burst or single loss ─► delay, jitter, reorder ─► truncate, flip a bit ─► arrived
//!                                         └─ duplicate, replay of an old frame ──────┘
//! ```
//!
//! Burst loss follows the channel of Gilbert and Elliott: a good and a bad state, which can change with each frame
//! (E. O. Elliott, 1963).
//!
//! ```
//! use scenario::{Scenario, radio::Air as Keys};
//! use v2x_sim::air::Air;
//!
//! let mut air = Air::new(&Keys::default(), 7);
//! air.send(0, vec![1, 2, 3]);
//! assert_eq!(air.arrived(0)[0].bytes, [1, 2, 3]);
//! ```

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenario::radio::Air as Keys;
use std::collections::VecDeque;

/// Earlier frames that can be replayed.
const HISTORY: usize = 4096;
const STREAM: u64 = 0x5a17_c0de_0a1b_0002;

#[derive(Clone, Debug)]
pub struct Air {
    keys: Keys,
    generator: Pcg64,
    is_bad: bool,
    /// Frames with the order of their sending, which breaks ties.
    on_the_way: Vec<(u64, Arrival)>,
    sent: u64,
    history: VecDeque<(u64, Vec<u8>)>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Instant of sending, ns of run time; of the replay, if it is one.
    pub sent_ns: u64,
    /// Instant of arrival, ns of run time.
    pub received_ns: u64,
    pub bytes: Vec<u8>,
}

impl Air {
    pub fn new(keys: &Keys, seed: u64) -> Self {
        Self {
            keys: *keys,
            generator: Pcg64::seed_from_u64(seed ^ STREAM),
            is_bad: false,
            on_the_way: Vec::new(),
            sent: 0,
            history: VecDeque::new(),
        }
    }

    pub fn send(&mut self, now_ns: u64, mut bytes: Vec<u8>) {
        let [turn, loss, jitter, reorder, duplicate, truncate, length, flip, place, replay] =
            std::array::from_fn(|_| random::unit(self.generator.next_u64()));
        if !self.is_imperfect(now_ns) {
            self.deliver(now_ns, now_ns, bytes);
            return;
        }
        let keys = self.keys;
        let turns =
            if self.is_bad { keys.burst_end_probability } else { keys.burst_begin_probability };
        self.is_bad ^= turn < turns.value();
        let burst = if self.is_bad { keys.burst_loss_probability.value() } else { 0.0 };
        // A frame arrives only if it survives both losses.
        let lost = 1.0 - (1.0 - keys.loss_probability.value()) * (1.0 - burst);
        let jitter_ns = (jitter * keys.jitter_ms.nanoseconds() as f64) as u64;
        let mut arrives_ns = now_ns + keys.delay_ms.nanoseconds() + jitter_ns;
        if reorder < keys.reorder_probability.value() {
            arrives_ns += keys.reorder_ms.nanoseconds();
        }
        if replay < keys.replay_probability.value()
            && let Some(old) =
                self.sent_before(now_ns.saturating_sub(keys.replay_age_s.nanoseconds()))
        {
            self.deliver(now_ns, arrives_ns, old);
        }
        self.remember(now_ns, &bytes);
        if loss < lost {
            return;
        }
        if duplicate < keys.duplicate_probability.value() {
            self.deliver(now_ns, arrives_ns, bytes.clone());
        }
        if truncate < keys.truncate_probability.value() {
            bytes.truncate((length * bytes.len() as f64) as usize);
        }
        if flip < keys.bit_flip_probability.value() && !bytes.is_empty() {
            let bit = (place * (8 * bytes.len()) as f64) as usize;
            bytes[bit / 8] ^= 0x80 >> (bit % 8);
        }
        self.deliver(now_ns, arrives_ns, bytes);
    }

    /// The frames that arrive up to `now_ns`, in the order of arrival.
    pub fn arrived(&mut self, now_ns: u64) -> Vec<Arrival> {
        let is_here = |(_, arrival): &mut (u64, Arrival)| arrival.received_ns <= now_ns;
        let mut here: Vec<_> = self.on_the_way.extract_if(.., is_here).collect();
        here.sort_by_key(|(number, arrival)| (arrival.received_ns, *number));
        here.into_iter().map(|(_, arrival)| arrival).collect()
    }

    fn is_imperfect(&self, now_ns: u64) -> bool {
        let from_ns = self.keys.from_s.nanoseconds();
        let end_ns = self.keys.for_s.map_or(u64::MAX, |length| from_ns + length.nanoseconds());
        (from_ns..end_ns).contains(&now_ns)
    }

    fn deliver(&mut self, sent_ns: u64, received_ns: u64, bytes: Vec<u8>) {
        self.sent += 1;
        self.on_the_way.push((self.sent, Arrival { sent_ns, received_ns, bytes }));
    }

    fn remember(&mut self, now_ns: u64, bytes: &[u8]) {
        if self.keys.replay_probability.value() > 0.0 {
            if self.history.len() == HISTORY {
                self.history.pop_front();
            }
            self.history.push_back((now_ns, bytes.to_vec()));
        }
    }

    /// The newest frame sent up to `time_ns`.
    fn sent_before(&self, time_ns: u64) -> Option<Vec<u8>> {
        let old = self.history.iter().rev().find(|(sent_ns, _)| *sent_ns <= time_ns);
        old.map(|(_, bytes)| bytes.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Scenario;

    const MS: u64 = 1_000_000;

    fn air(keys: &str) -> Air {
        let text = format!(
            "schema_version = 1\nname = \"air\"\n[v2x]\nradio = \"frames\"\n[v2x.air]\n{keys}\n"
        );
        Air::new(&Scenario::parse("air", &text).expect("a right scenario").v2x.air, 7)
    }

    /// Arrivals of ten frames a second for 100 s.
    fn fly(air: &mut Air) -> Vec<Arrival> {
        let mut arrived = Vec::new();
        for k in 0..1_100_u64 {
            if k < 1_000 {
                air.send(k * 100 * MS, k.to_be_bytes().repeat(10));
            }
            arrived.extend(air.arrived(k * 100 * MS));
        }
        arrived
    }

    fn number(arrival: &Arrival) -> u64 {
        u64::from_be_bytes(arrival.bytes[..8].try_into().expect("whole"))
    }

    #[test]
    fn clear_air_delivers_everything_at_once() {
        let arrived = fly(&mut air(""));
        assert_eq!(arrived.len(), 1000);
        assert!(arrived.iter().all(|a| a.received_ns == a.sent_ns));
        assert!(arrived.iter().map(number).eq(0..1000));
    }

    #[test]
    fn losses_stay_in_their_window_and_repeat() {
        let keys = "from_s = 20\nfor_s = 50\nloss_probability = 0.3";
        let arrived = fly(&mut air(keys));
        let lost = 1000 - arrived.len();
        assert!((100..200).contains(&lost), "{lost} of 500 at 30 %");
        assert_eq!(arrived.iter().filter(|a| a.sent_ns < 20_000 * MS).count(), 200);
        assert_eq!(arrived, fly(&mut air(keys)));
    }

    #[test]
    fn bursts_are_longer_than_single_losses() {
        let keys = "burst_begin_probability = 0.02\nburst_end_probability = 0.1";
        let arrived = fly(&mut air(keys));
        let gaps = arrived.windows(2).map(|pair| number(&pair[1]) - number(&pair[0]) - 1);
        let gaps: Vec<u64> = gaps.filter(|gap| *gap > 0).collect();
        let mean = gaps.iter().sum::<u64>() as f64 / gaps.len() as f64;
        assert!((5.0..20.0).contains(&mean), "mean of 1 / 0.1 frames: {mean}");
    }

    #[test]
    fn late_frames_keep_their_order_and_held_back_ones_do_not() {
        let arrived = fly(&mut air("delay_ms = 250"));
        assert!(arrived.iter().all(|a| a.received_ns - a.sent_ns == 250 * MS));
        assert!(arrived.iter().map(number).is_sorted());
        let arrived = fly(&mut air("reorder_probability = 0.1"));
        let overtaken = arrived.windows(2).filter(|p| number(&p[0]) > number(&p[1])).count();
        assert!((50..150).contains(&overtaken), "{overtaken}");
    }

    #[test]
    fn frames_come_twice_cut_off_falsified_and_again() {
        assert!((1050..1200).contains(&fly(&mut air("duplicate_probability = 0.1")).len()));
        let cut = fly(&mut air("truncate_probability = 0.1"));
        let cut = cut.iter().filter(|arrival| arrival.bytes.len() < 80).count();
        assert!((50..150).contains(&cut), "{cut}");
        let flipped = fly(&mut air("bit_flip_probability = 0.1"));
        let wrong = |a: &&Arrival| a.bytes != (a.sent_ns / (100 * MS)).to_be_bytes().repeat(10);
        let count = flipped.iter().filter(wrong).count();
        assert!((50..150).contains(&count), "{count}");
        let replayed = fly(&mut air("replay_probability = 0.1\nreplay_age_s = 5"));
        let old = |a: &&Arrival| a.sent_ns / (100 * MS) == number(a) + 50;
        assert!((50..150).contains(&replayed.iter().filter(old).count()));
    }
}
