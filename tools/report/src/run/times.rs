//! Times, messages and processes of a run as tables, and charts of the times.

use crate::html::{figure, grid};
use crate::picture::RunPicture;
use crate::print::carries;
use crate::results::{Column, Document, Table, count, flag, micros, number, word};
use crate::summary::{ServiceSummary, Summary, TopicCounts};
use crate::timing;
use runtime::statistics::Percentiles;
use serde_json::{Value, json};
use supervise::report::WorstChain;

/// Percentiles of all timed quantities. In lockstep the law alone is timed by the wall clock.
pub fn table(summary: &Summary) -> Table {
    let (timing, radio) = (&summary.timing, summary.radio.as_ref());
    let (hops, signal) = (&timing.hops_us, &timing.signal_hops_us);
    let law = ("The law alone", timing.solve_us);
    let planning = ("Planning", timing.planning.as_ref().and_then(|planning| planning.plan_us));
    let measured = [
        ("Reaction time, radar to first actuation", timing.reaction_time_us),
        ("… software overhead only", timing.net_reaction_us),
        ("… radar to start of the control cycle", hops.radar_to_controller),
        ("… control cycle to its command", hops.parts.controller_compute),
        ("… command to actuation", hops.controller_to_plant),
        ("Data age at every actuation", timing.data_age_us),
        ("Release jitter of the controller", timing.release_jitter_us),
        ("Time on air", radio.and_then(|radio| radio.air_us)),
        ("Age of the forwarded signal timing", radio.and_then(|radio| radio.age_us)),
        ("Time to decode and check a frame", radio.and_then(|radio| radio.decode_us)),
        ("Signal's change to the first actuation that uses it", timing.signal_reaction_us),
        ("… change to the announcement", signal.announce),
        ("… frame, air and decoding", signal.receive),
        ("… controller", signal.control),
        ("… command to actuation", signal.actuate),
    ];
    let measured = measured.into_iter().filter(|_| summary.mode == "realtime");
    let rows: Vec<Value> = ([law, planning].into_iter().chain(measured))
        .filter_map(|(name, p)| Some(row(name, &p.filter(|p| p.max > 0.0)?)))
        .collect();
    let columns: [Column<Value>; 8] = [
        word("of", "time", "Timed quantity"),
        micros("p50", "median", "Median"),
        micros("p90", "90 %", "90th percentile").weight(2),
        micros("p99", "99 %", "99th percentile"),
        micros("p999", "99.9 %", "99.9th percentile").weight(2),
        micros("p9999", "99.99 %", "99.99th percentile").weight(3),
        micros("max", "max", "Largest sample"),
        count("count", "samples", "Samples").weight(1),
    ];
    Table::new("Timing", &columns, &rows)
}

/// A row of percentiles, without those that the number of samples cannot distinguish from the maximum.
fn row(name: &str, p: &Percentiles) -> Value {
    let known = |share: f64, us: f64| carries(p.count, share).then_some(us);
    json!({
        "of": name,
        "p50": known(0.5, p.p50),
        "p90": known(0.9, p.p90),
        "p99": known(0.99, p.p99),
        "p999": known(0.999, p.p999),
        "p9999": known(0.9999, p.p9999),
        "max": p.max,
        "count": p.count,
    })
}

/// Adds the charts of the reaction time in realtime, and the events during its longest chains.
pub fn pictures(document: Document, summary: &Summary, run: &RunPicture) -> Document {
    if summary.mode == "lockstep" {
        return document;
    }
    let count = summary.timing.reaction_time_us.map_or(0, |p| p.count);
    let hops = timing::latencies(run, count).map_or_else(String::new, |plot| figure(&plot));
    let worst =
        timing::worst_chains(&run.worst_chains).map_or_else(String::new, |bands| figure(&bands));
    document.figures("Reaction time", grid(&(hops + &worst))).table(worst_table(&run.worst_chains))
}

/// Events during the longest chains.
fn worst_table(chains: &[WorstChain]) -> Table {
    let columns: [Column<Value>; 8] = [
        word("until", "until", "Instant of the actuation"),
        micros("reaction", "reaction", "Reaction time"),
        micros("net", "without waits", "Reaction time without the designed waits"),
        micros("age", "radar age", "Age of the radar data"),
        count("iterations", "iterations", "Iterations of the solver"),
        word("switches", "switches, own + forced", "Context switches"),
        word("faults", "page faults, minor + major", "Page faults"),
        flag("kept", "control cycle", ("kept", "missed"), "The control cycle kept its deadline"),
    ];
    let row = |chain: &WorstChain| {
        json!({
            "until": format!("{:.3} s", chain.t_s),
            "reaction": chain.reaction_time_us,
            "net": chain.reaction_time_us - chain.designed_wait_us,
            "age": chain.radar_age_us,
            "iterations": chain.solver_iterations,
            "switches": format!("{} + {}", chain.voluntary_switches, chain.involuntary_switches),
            "faults": format!("{} + {}", chain.minor_faults, chain.major_faults),
            "kept": !chain.deadline_missed,
        })
    };
    let rows: Vec<Value> = chains.iter().map(row).collect();
    Table::new("The longest chains", &columns, &rows).for_pages().without_cases()
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_without_samples_behind_it_is_absent() {
        let p = Percentiles {
            p50: 1.0,
            p90: 2.0,
            p99: 3.0,
            p999: 3.0,
            p9999: 3.0,
            max: 3.0,
            count: 100,
        };
        let row = row("x", &p);
        assert_eq!((row["p99"].as_f64(), row["p999"].is_null()), (Some(3.0), true));
        assert_eq!(row["count"], 100);
    }
}
