//! A run as a result for people: the chains first, then their hops, nodes, topics, faults.

use crate::group::Record;
use crate::results::{ChainRow, NodeRow, Report};
use report::chart::{Stroke, Tone};
use report::html::figure;
use report::output::{HISTOGRAMS, histogram_log};
use report::print::{carries, duration, p99};
use report::results::{Broken, Column, Document, Table, count, micros, number, word};
use report::{Distribution, distributions};
use runtime::statistics::{Latencies, Percentiles};
use serde_json::{Value, json};

/// The result for every output.
pub fn of(report: &Report, histograms: &[(String, Latencies)]) -> Document {
    let host = &report.host;
    let kind = if host.realtime_kernel { ", real-time kernel" } else { "" };
    let refused = report.refused.iter().map(|why| ("not granted".to_owned(), why.clone()));
    let late: Vec<&ChainRow> = report.chains.iter().filter(|chain| !chain.holds()).collect();
    let held = report.chains.len() - late.len();
    let mut verdict = format!("{held} of {} chains hold", report.chains.len());
    if let Some(jitter) = report.floor.sleep_jitter_us {
        verdict += &format!(
            "; floor on core {}: a sleep is {} late (p50), {} at worst",
            report.floor.core,
            duration(jitter.p50),
            duration(jitter.max)
        );
    }
    let broken = report.broken.iter().cloned().chain(late.into_iter().map(broken));
    Document::new("graph", &format!("Graph {}", report.graph), report)
        .about(format!(
            "{} processors, Linux {}{kind}, {} s",
            host.cpus, host.kernel, report.seconds
        ))
        .facts("Not granted", refused.collect())
        .table(chains(report))
        .figures("Chains", pictures(report, histograms))
        .table(hops(report))
        .table(nodes(report))
        .table(topics(report))
        .table(faults(&report.faults))
        .file(HISTOGRAMS, histogram_log(histograms))
        .verdict(report.ok, verdict)
        .broken(broken.map(|what| Broken::new(what, "")))
}

/// Why a chain does not hold, in words.
fn broken(chain: &ChainRow) -> String {
    let name = &chain.chain;
    match (chain.reactions, chain.misses, chain.deadline_us) {
        (0, ..) => format!("{name}: no message reached the end"),
        (reactions, Some(misses), Some(deadline_us)) => format!(
            "{name}: {misses} of {reactions} reactions are later than {} ({} accepted)",
            duration(deadline_us),
            chain.max_misses
        ),
        _ => name.clone(),
    }
}

fn chains(report: &Report) -> Table {
    let columns: [Column<Value>; 12] = [
        word("chain", "chain", "Chain from its source to its last node"),
        micros("deadline_us", "deadline", "Longest accepted reaction time"),
        count("reactions", "n", "Messages of the source that reached the end"),
        count("not_used", "not used", "Messages of the source that newer ones replaced").weight(1),
        count("misses", "misses", "Reactions later than the deadline"),
        micros(
            "reaction.p50",
            "reaction p50",
            "Median from the source's release to the last node's end",
        ),
        micros("reaction.p99", "p99", "99th percentile of it"),
        micros("reaction.max", "max", "Longest"),
        micros("age.p50", "age p50", "Median age of the data at each end of the last node")
            .weight(1),
        micros("age.max", "max", "Largest").weight(1),
        micros("net.p50", "net p50", "Median reaction without waits for a timer or another topic"),
        micros("net.p99", "p99", "99th percentile of it").weight(1),
    ];
    let row = |chain: &ChainRow| {
        let mut row = json!(chain);
        row["not_used"] = json!(chain.started.saturating_sub(chain.reactions));
        row["reaction"] = shown(chain.reaction_time_us);
        row["age"] = shown(chain.data_age_us);
        row["net"] = shown(chain.net_reaction_us);
        row
    };
    let rows: Vec<Value> = report.chains.iter().map(row).collect();
    Table::new("Chains", &columns, &rows)
}

/// Percentiles that the samples carry.
fn shown(us: Option<Percentiles>) -> Value {
    let p50 = us.filter(|us| carries(us.count, 0.5)).map(|us| us.p50);
    json!({"p50": p50, "p99": us.as_ref().and_then(p99), "max": us.map(|us| us.max)})
}

fn hops(report: &Report) -> Table {
    let columns: [Column<Value>; 8] = [
        word("chain", "chain", "Chain"),
        word("node", "node", "Node on it"),
        micros(
            "wait.p50",
            "wait p50",
            "Median time for which the message was there and the node busy or not due",
        ),
        micros("wait.max", "max", "Longest").weight(1),
        micros("wake.p50", "wake-up p50", "Median time from then to the start of the cycle"),
        micros("wake.max", "max", "Longest"),
        micros("work.p50", "work p50", "Median time from the start to the publication"),
        micros("work.max", "max", "Longest"),
    ];
    let rows: Vec<Value> = (report.chains.iter())
        .flat_map(|chain| chain.hops.iter().map(|hop| (&chain.chain, hop)))
        .map(|(chain, hop)| {
            let [wait, wake, work] = [hop.wait_us, hop.wake_us, hop.work_us].map(shown);
            json!({"chain": chain, "node": hop.node, "wait": wait, "wake": wake, "work": work})
        })
        .collect();
    Table::new("Hops", &columns, &rows).blocks("chain").without_cases()
}

fn nodes(report: &Report) -> Table {
    let columns: [Column<Value>; 10] = [
        word("node", "node", "Node"),
        word("scheduling", "scheduling", "Scheduling that the kernel granted").weight(1),
        count("core", "core", "CPU that it is pinned to").weight(3),
        count("cycles", "cycles", "Cycles of all its processes"),
        count("skipped", "skipped", "Releases that were left out: it was busy or stopped"),
        micros("jitter.p50", "release p50", "Median start of a cycle after its release"),
        micros("jitter.max", "max", "Latest start"),
        micros("work.p50", "work p50", "Median length of a cycle").weight(1),
        count("replacements", "replaced", "Times that another process became the active one"),
        number("starved_ms", "starved", "ms", 0, "Time for which it waited for the processor")
            .weight(2),
    ];
    let row = |node: &NodeRow| {
        let mut row = json!(node);
        row["jitter"] = shown(node.release_jitter_us);
        row["work"] = shown(node.work_us);
        row
    };
    let rows: Vec<Value> = report.nodes.iter().map(row).collect();
    Table::new("Nodes", &columns, &rows).without_cases()
}

fn topics(report: &Report) -> Table {
    let columns = [
        word("topic", "topic", "Topic"),
        count("bytes", "bytes", "Length of a message, with header and stamps"),
        count("sent", "sent", "Messages sent"),
        count("received", "received", "Messages received, by all readers together"),
        count("unused", "unused", "Messages that a newer one replaced before a cycle used them"),
        count("refused", "refused", "Messages that failed a check").weight(1),
    ];
    Table::new("Topics", &columns, &report.topics).without_cases()
}

fn faults(records: &[Record]) -> Table {
    let columns: [Column<Value>; 5] = [
        number("t_s", "t", "s", 3, "Run time of the begin"),
        word("what", "fault", "Fault, or an end that was not asked for"),
        micros(
            "detected_after_us",
            "noticed after",
            "Time until the launcher or the standby noticed it",
        ),
        micros(
            "recovered_after_us",
            "back after",
            "Time until the first cycle of the next process",
        ),
        word("recovered_by", "by", "How it came back"),
    ];
    let row = |record: &Record| {
        let mut row = json!(record);
        let target = record.node.as_ref().or(record.topic.as_ref());
        row["what"] = json!(format!("{} {}", record.kind, target.cloned().unwrap_or_default()));
        row
    };
    let rows: Vec<Value> = records.iter().map(row).collect();
    Table::new("Faults", &columns, &rows).without_cases()
}

/// Each chain's reaction time and data age, with the machine's floor.
fn pictures(report: &Report, histograms: &[(String, Latencies)]) -> String {
    let of = |tag: &str| histograms.iter().find(|(known, _)| known == tag).map(|(_, h)| h);
    let picture = |(number, chain): (usize, &ChainRow)| {
        let drawn = [
            (format!("reaction_time:{number}"), "reaction time", Tone::Series(0), Stroke::Solid),
            (format!("data_age:{number}"), "data age", Tone::Series(1), Stroke::Solid),
            ("sleep".to_owned(), "floor: a process that only sleeps", Tone::Muted, Stroke::Dashed),
        ];
        let drawn = drawn.iter().filter_map(|(tag, label, tone, stroke)| {
            let latencies = of(tag)?;
            let label = format!("{label} (n = {})", latencies.count());
            Some(Distribution { label, tone: *tone, stroke: *stroke, latencies })
        });
        distributions(&chain.chain, &drawn.collect::<Vec<_>>()).map(|plot| figure(&plot))
    };
    let drawn: String = report.chains.iter().enumerate().filter_map(picture).collect();
    if drawn.is_empty() { drawn } else { format!("<div class=\"grid\">\n{drawn}</div>\n") }
}
