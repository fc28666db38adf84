use super::*;
use crate::{Clock, Mode};
use bytemuck::Zeroable;
use messages::e2e::{Channel, Outcomes, profile7};
use messages::{EgoTruth, Message, RadarTracks, Service};
use scenario::Scenario;
use std::rc::Rc;

const SOURCE: u32 = Service::PerceptionSim.to_wire();

fn faults(text: &str) -> Rc<Faults> {
    let text = format!("schema_version = 1\nname = \"faulty\"\nseed = 7\n{text}");
    let scenario = Scenario::parse("faults", &text).expect("a scenario");
    Rc::new(Faults::of(&scenario, None))
}

/// An ego there, so fast, that meets nothing.
fn driving(position_m: f64, speed_mps: f64) -> EgoTruth {
    let time_to_collision_s = f64::INFINITY;
    EgoTruth { position_m, speed_mps, time_to_collision_s, ..EgoTruth::zeroed() }
}

fn statistics(faults: &Faults) -> Vec<FaultStatistics> {
    let mut found = Vec::new();
    faults.statistics(&mut found);
    found
}

/// A disturbed channel and its clock.
fn channel(faults: &Rc<Faults>) -> (Disturbed<RadarTracks>, Rc<Clock>) {
    let clock = Rc::new(Clock::new(Mode::Lockstep, 1));
    (Disturbed::new(Rc::clone(faults), Rc::clone(&clock)), clock)
}

fn message(sequence: u64) -> RadarTracks {
    let mut message = RadarTracks::zeroed();
    message.header.sequence = sequence;
    message.header.source = SOURCE;
    message.target.gap_m = sequence as f64;
    let counter = u32::try_from(sequence).expect("small");
    profile7::protect(bytemuck::bytes_of_mut(&mut message), 9, counter);
    message
}

/// Sequence numbers in the order of their hand-over, one arrival every 50 ms from 0 on.
fn through(text: &str, messages: u64) -> Vec<(i64, u64)> {
    let faults = faults(text);
    let (mut channel, clock) = channel(&faults);
    let mut out = Vec::new();
    for k in 0..messages {
        let now_ns = i64::try_from(k).expect("small") * 50_000_000;
        clock.set_simulated(now_ns);
        if channel.passes(&message(k + 1)) {
            out.push((now_ns / 1_000_000, k + 1));
        }
        while let Some(message) = channel.hand_over() {
            out.push((now_ns / 1_000_000, message.message.header.sequence));
        }
    }
    out
}

fn sequences(text: &str, messages: u64) -> Vec<u64> {
    through(text, messages).into_iter().map(|(_, sequence)| sequence).collect()
}

#[test]
fn the_wire_does_as_it_is_set() {
    let at = |kind| {
        format!(
            "[[faults]]\nkind = \"{kind}\"\ntopic = \"radar/tracks\"\nat_s = 0.1\nfor_s = 0.1\n"
        )
    };
    assert_eq!(sequences(&at("drop"), 6), [1, 2, 5, 6]);
    assert_eq!(sequences(&at("duplicate"), 6), [1, 2, 3, 3, 4, 4, 5, 6]);
    assert_eq!(sequences(&at("reorder"), 6), [1, 2, 4, 3, 5, 6]);
    let late = through(&(at("delay") + "delay_ms = 120"), 8);
    assert_eq!(late[2..], [(200, 5), (250, 3), (250, 6), (300, 4), (300, 7), (350, 8)]);
}

#[test]
fn every_corruption_is_detected() {
    let faults = faults("[[faults]]\nkind = \"corrupt\"\ntopic = \"radar/tracks\"\nbits = 2");
    let (mut check, mut outcomes) = (Channel::default(), Outcomes::default());
    let (mut channel, _) = channel(&faults);
    for k in 1..=20_000 {
        assert!(!channel.passes(&message(k)));
        let corrupted = channel.hand_over().expect("due at once");
        assert!(!check.accept(bytemuck::bytes_of(&corrupted.message), 9, 0, &mut outcomes));
    }
    assert_eq!(outcomes.error, 20_000);
}

#[test]
fn a_message_handed_over_late_still_names_the_fault_that_corrupted_it() {
    let faults = faults(
        "[[faults]]\nkind = \"delay\"\ntopic = \"radar/tracks\"\ndelay_ms = 100\n\
         [[faults]]\nkind = \"corrupt\"\ntopic = \"radar/tracks\"\nfor_s = 0.05",
    );
    let (mut channel, clock) = channel(&faults);
    assert!(!channel.passes(&message(1)));
    clock.set_simulated(60_000_000);
    assert!(!channel.passes(&message(2)));
    clock.set_simulated(99_000_000);
    assert!(channel.hand_over().is_none(), "still on its way: neither noticed nor missed");
    for (now_ns, by) in [(100_000_000, Some(1)), (160_000_000, None)] {
        clock.set_simulated(now_ns);
        let late = channel.hand_over().expect("due");
        assert_eq!(late.corrupted_by, by);
        channel.note_passed(&late);
    }
    let undetected: Vec<_> = statistics(&faults).iter().map(|s| s.undetected).collect();
    assert_eq!(undetected, [0, 1]);
}

#[test]
fn chance_is_as_likely_as_said_and_repeats() {
    let text =
        "[[faults]]\nkind = \"drop\"\ntopic = \"radar/tracks\"\nprobability = 0.25\n".to_owned();
    let first = sequences(&text, 4000);
    assert_eq!(first, sequences(&text, 4000));
    let kept = first.len() as f64 / 4000.0;
    assert!((kept - 0.75).abs() < 0.03, "{kept}");
}

#[test]
fn a_condition_begins_the_fault_once_it_holds() {
    let text = "[[faults]]\nkind = \"drop\"\ntopic = \"radar/tracks\"\nfor_s = 1\n\
                when = { position_above_m = 50, speed_below_mps = 10 }";
    let faults = faults(text);
    let (mut channel, clock) = channel(&faults);
    let (fast, slow) = (driving(60.0, 11.0), driving(60.0, 9.0));
    faults.observe(|| Some(&fast), 0);
    assert!(channel.passes(&message(1)), "not begun: it passes at once");
    faults.observe(|| Some(&slow), 1);
    faults.observe(|| Some(&fast), 2);
    clock.set_simulated(2);
    assert!(!channel.passes(&message(2)));
    assert!(channel.hand_over().is_none(), "begun at 1, though the condition holds no more");
    clock.set_simulated(1_000_000_001);
    assert!(channel.passes(&message(3)), "over");
    assert_eq!(
        statistics(&faults),
        [FaultStatistics { fault: 0, begun_ns: 1, messages: 1, undetected: 0 }]
    );
}

#[test]
fn sender_faults_come_before_the_protection() {
    let tell = |text: &str, k: u64| {
        let mut sender_faults = Falsified::new(faults(text));
        let mut last = RadarTracks::zeroed();
        for sequence in 1..=k {
            last = message(sequence);
            last.header.acquisition_ns = 10_000_000_000;
            let now_ns = i64::try_from(sequence).expect("small") * 1_000_000_000;
            sender_faults.apply(&mut last, now_ns);
        }
        last
    };
    let topic = "topic = \"radar/tracks\"";
    let frozen = tell(&format!("[[faults]]\nkind = \"freeze\"\n{topic}\nat_s = 3"), 6);
    assert_eq!((frozen.target.gap_m, frozen.header().sequence), (2.0, 6));
    let biased =
        tell(&format!("[[faults]]\nkind = \"bias\"\n{topic}\nfield = \"gap_m\"\namount = 5.5"), 4);
    assert_eq!(biased.target.gap_m, 9.5);
    let stale = tell(&format!("[[faults]]\nkind = \"stale\"\n{topic}\namount = 2"), 1);
    assert_eq!(stale.header.acquisition_ns, 8_000_000_000);
    let stepped =
        tell("[[faults]]\nkind = \"clock-step\"\nservice = \"perception-sim\"\namount = -1.5", 1);
    assert_eq!(
        (stepped.header.acquisition_ns, stepped.header.publish_ns),
        (8_500_000_000, -1_500_000_000)
    );
}
