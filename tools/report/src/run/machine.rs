//! Messages and processes of a run, as tables.

use crate::results::{Column, Table, count, number, word};
use crate::summary::{ServiceSummary, Summary, TopicCounts};
use serde_json::{Value, json};

/// Counts of each topic.
pub fn messages(summary: &Summary) -> Table {
    let columns: [Column<Value>; 6] = [
        word("topic", "topic", "Topic"),
        count("sent", "sent", "Messages of all senders"),
        count("received", "received", "Fewest messages that a reader received"),
        count("lost", "lost", "Most messages that a reader missed"),
        count("e2e_errors", "invalid", "Messages that the readers refused").weight(1),
        count("unknown", "from unknown senders", "Messages of an unknown sender").weight(1),
    ];
    let row = |(topic, counts): (&String, &TopicCounts)| {
        let mut row = json!(counts);
        row["topic"] = json!(topic);
        row["unknown"] = json!(counts.e2e.unknown_sender);
        row
    };
    let rows: Vec<Value> = summary.messages.iter().map(row).collect();
    Table::new("Messages", &columns, &rows).for_pages()
}

/// The processes with their scheduling.
pub fn services(summary: &Summary) -> Table {
    let columns: [Column<ServiceSummary>; 11] = [
        word("name", "service", "Service"),
        word("scheduling.granted", "granted", "Scheduling that the kernel granted"),
        word("scheduling.requested", "requested", "Scheduling that was requested").weight(3),
        word("", "core", "Processor").of(|service| {
            let granted = service.scheduling.as_ref();
            json!(granted.map(|g| g.core.map_or("any".to_owned(), |core| core.to_string())))
        }),
        word("", "memory", "Pages stay in memory").weight(1).of(|service| {
            let granted = service.scheduling.as_ref();
            json!(granted.map(|g| if g.memory_locked { "locked" } else { "not locked" }))
        }),
        number("", "peak", "MiB", 1, "Largest resident set")
            .of(|service| json!(service.peak_rss_kib.map(|kib| kib as f64 / 1024.0))),
        count("restarts", "restarts", "Replacements of its process"),
        count("take_overs", "take-overs", "Replacements by its standby"),
        word("", "standby", "Cost of its standby").weight(2).of(|service| {
            json!(service.standby_cost.map(|cost| {
                let (cpu, mib) = (cost.cpu_percent, cost.private_kib as f64 / 1024.0);
                format!("{cpu:.2} % of a core, {mib:.1} MiB")
            }))
        }),
        number("", "starved", "ms", 1, "Time in which the machine gave it no processor").of(
            |service| {
                let starved_ms = service.heartbeats.map(|heartbeats| heartbeats.starved_ms);
                json!(starved_ms.filter(|ms| *ms > 0.0))
            },
        ),
        word("exit", "end", "Exit status or signal").weight(2),
    ];
    // In lockstep in one process there are no processes to show.
    let rows = summary.services.iter().filter(|service| service.scheduling.is_some());
    Table::new("Processes", &columns, rows).without_cases()
}
