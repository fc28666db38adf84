//! Console lines about messages, faults and the machine.

use crate::duration::duration;
use crate::fault;
use crate::summary::{Summary, TopicCounts};
use messages::level::Level;
use runtime::scheduling::Asked;
use std::collections::BTreeMap;

pub(super) fn messages(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let sent: u64 = summary.messages.values().map(|topic| topic.sent).sum();
    let lost: u64 = summary.messages.values().filter_map(|topic| topic.lost).sum();
    if sent > 0 {
        line("messages", format!("{sent} sent on {} topics, {lost} lost", summary.messages.len()));
    }
    for text in losses(&summary.messages) {
        line("", text);
    }
}

/// Lost messages by reader and topic: a late reader finds the oldest ones overwritten.
fn losses(topics: &BTreeMap<String, TopicCounts>) -> impl Iterator<Item = String> {
    topics.iter().flat_map(|(topic, counts)| {
        let lost_by = counts.lost_by.iter();
        lost_by.map(move |(reader, lost)| {
            format!(
                "{reader} read {topic} too late: its queue was full, {lost} of {} lost",
                counts.sent
            )
        })
    })
}

/// Most faults that are printed one by one.
const SHOWN_FAULTS: usize = 8;

pub(super) fn faults(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for (index, record) in summary.faults.iter().take(SHOWN_FAULTS).enumerate() {
        let (name, outcome) = (fault::name(record), fault::outcome(record));
        let outcome = if outcome.is_empty() { outcome } else { format!(", {outcome}") };
        let text = format!("{name} at {:.2} s{outcome}", record.t_s);
        line(if index == 0 { "faults" } else { "" }, text);
    }
    if summary.faults.len() > SHOWN_FAULTS {
        line("", format!("and {} more", summary.faults.len() - SHOWN_FAULTS));
    }
    let rungs: Vec<String> = (summary.rungs.iter())
        .flat_map(|(who, rungs)| rungs.time_s.iter().map(move |(rung, time_s)| (who, rung, time_s)))
        .filter(|(_, rung, _)| rung.as_str() != Level::Full.name())
        .map(|(who, rung, time_s)| format!("{who} {rung} {time_s:.2} s"))
        .collect();
    if !rungs.is_empty() {
        line("degraded", rungs.join(", "));
    }
    let refused: u64 = summary.messages.values().filter_map(|topic| topic.e2e_errors).sum();
    let unknown: u64 = summary.messages.values().map(|topic| topic.e2e.unknown_sender).sum();
    if refused > unknown {
        let refused = refused - unknown;
        line("refused", format!("{refused} messages, by the end-to-end check"));
    }
    let ahead: u64 = summary.messages.values().map(|topic| topic.e2e.from_the_future).sum();
    if ahead > 0 {
        line(
            "clocks",
            format!("{ahead} messages of a clock that is ahead, their stamps moved back"),
        );
    }
    for (topic, counts) in &summary.messages {
        if counts.e2e.unknown_sender > 0 {
            let count = counts.e2e.unknown_sender;
            line("refused", format!("{count} messages of an unknown sender on {topic}"));
        }
    }
}

/// A count in words after its subject; empty for zero.
fn how_often(what: &str, count: u32) -> String {
    match count {
        0 => String::new(),
        1 => format!("{what} once"),
        n => format!("{what} {n} times"),
    }
}

pub(super) fn machine(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for service in &summary.services {
        let Some(granted) = &service.scheduling else { continue };
        let core = granted.core.map_or_else(|| "any core".into(), |core| format!("core {core}"));
        let locked = if granted.memory_locked { "memory locked" } else { "memory not locked" };
        let rss = service.peak_rss_kib.unwrap_or(0) as f64 / 1024.0;
        let took_over = service.take_overs.unwrap_or(0);
        let restarts = how_often(", restarted", service.restarts.saturating_sub(took_over))
            + &how_often(", taken over by its standby", took_over);
        let granted = &granted.granted;
        line(service.name, format!("{granted}, {core}, {locked}, {rss:.1} MiB{restarts}"));
    }
    for service in &summary.services {
        if let Some(cost) = &service.standby_cost {
            let (cpu, mib) = (cost.cpu_percent, cost.private_kib as f64 / 1024.0);
            let name = service.name;
            line("standby", format!("{name}: {cpu:.2} % of a core, {mib:.1} MiB private memory"));
        }
    }
    for service in &summary.services {
        let starved_ms = service.heartbeats.map_or(0.0, |heartbeats| heartbeats.starved_ms);
        if starved_ms > 0.0 {
            let starved = duration(starved_ms * 1e3);
            let name = service.name;
            line("starved", format!("{name}: the machine gave it no processor for {starved}"));
        }
    }
    if let Some(text) = refusals(summary) {
        line("not granted", text);
    }
}

/// Requests that the machine refused, each reason once, with the command that shows the remedy.
fn refusals(summary: &Summary) -> Option<String> {
    let granted = summary.services.iter().filter_map(|service| service.scheduling.as_ref());
    let mut refused: Vec<String> = Vec::new();
    for refusal in granted.flat_map(|granted| &granted.refused) {
        // Priorities differ between services; the reason does not.
        let line = match refusal.what {
            Asked::Fifo(_) => format!("real-time priority: {}", refusal.why),
            Asked::TimerSlack | Asked::Core(_) | Asked::LockedMemory => refusal.to_string(),
        };
        if !refused.contains(&line) {
            refused.push(line);
        }
    }
    (!refused.is_empty())
        .then(|| format!("{} (`timegap doctor` shows the remedy)", refused.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_is_reported_with_its_topic_and_its_reader() {
        let late = TopicCounts {
            sent: 600,
            lost_by: [("controller", 6)].into(),
            ..TopicCounts::default()
        };
        let topics =
            [("v2x/map".to_owned(), TopicCounts::default()), ("vehicle/odometry".to_owned(), late)];
        let said: Vec<_> = losses(&topics.into()).collect();
        assert_eq!(
            said,
            ["controller read vehicle/odometry too late: its queue was full, 6 of 600 lost"]
        );
    }
}
