//! The JSON of a benchmark, for programs: every key of `bench.json` with its meaning.

use report::results::{Column, Kind, Schema, count, fact, nested, number, word};

use super::columns::GOALS;
use super::results::{ChainRow, DeadlineRow, FloorRow, PairedRow, Report, TransportRow};

/// Fields beside the lists.
const FIELDS: &[Column<Report>] = &[
    nested("host", Kind::Object, "The machine, as in summary.json"),
    fact("quick", "", "Shorter: fewer conditions, for a first look"),
    number("seconds", "", "s", 1, "Length of each measurement"),
    nested("wake_ups", Kind::Object, "Loops that hold on this machine, with the histogram"),
    nested("refused", Kind::List, "Requests that the kernel refused, with its reasons"),
    nested("floor.sleep_jitter_us", Kind::Object, "Lateness of absolute sleeps"),
    nested("floor.futex_us", Kind::Object, "Wake-up by futex, by placement"),
    nested("floor.eventfd_us", Kind::Object, "Wake-up by eventfd, by placement"),
    nested("floor.iceoryx2_event_us", Kind::Object, "Wake-up by iceoryx2's events, by placement"),
    nested("not_compared", Kind::List, "Peers that this build lacks, each with the reason"),
    nested("caveats", Kind::List, "Differences between this machine and the goals' machine"),
];

/// Conditions of a row, with its own columns.
fn under_conditions<R>(own: Vec<Column<R>>) -> Vec<Column<R>> {
    let mut columns = vec![
        word("placement", "", "Cores of both ends"),
        word("scheduling", "", "Scheduling of both ends"),
        word("load", "", "Load beside the measurement"),
        count("period_us", "", "Period, µs"),
    ];
    columns.extend(own);
    columns
}

fn percentiles<R>(name: &'static str, meaning: &'static str) -> Column<R> {
    nested(name, Kind::Object, meaning)
}

fn floor() -> Vec<Column<FloorRow>> {
    under_conditions(vec![
        word("measure", "", "Kind of the floor"),
        percentiles("us", "Percentiles, µs"),
    ])
}

fn transport() -> Vec<Column<TransportRow>> {
    under_conditions(vec![
        count("bytes", "", "Size of the message"),
        word("passing", "", "Kind of the hand-over"),
        number("copied_bytes", "", "", 1, "Bytes copied for each message"),
        count("lost", "", "Messages that were sent and never received"),
        percentiles("us", "Percentiles from publish to read, µs"),
    ])
}

fn chain() -> Vec<Column<ChainRow>> {
    under_conditions(vec![
        percentiles("reaction_time_us", "From the radar's measurement to the actuation, µs"),
        percentiles("designed_wait_us", "Radar latency and waits for the next period, µs"),
        percentiles("net_reaction_us", "Reaction time without the designed waits, µs"),
        number("floor_sum_us", "", "µs", 1, "Sum of the medians of the floors"),
        nested("hops_us", Kind::Object, "Percentiles of each hop, µs"),
        percentiles("solve_us", "Time inside the law, µs"),
        percentiles("sleep_jitter_us", "Lateness of a process that only sleeps, µs"),
    ])
}

fn deadlines() -> Vec<Column<DeadlineRow>> {
    under_conditions(vec![
        count("cycles", "", "Cycles of the controller"),
        count("misses", "", "Deadlines that it missed"),
        number("misses_per_million", "", "", 1, "Misses in a million cycles"),
        count(
            "floor_cycles",
            "",
            "Cycles of a process that sleeps and computes as long as the law",
        ),
        count("floor_misses", "", "Deadlines that it missed"),
        number("floor_misses_per_million", "", "", 1, "Its misses in a million cycles"),
    ])
}

fn paired() -> Vec<Column<PairedRow>> {
    under_conditions(vec![
        word("comparison", "", "The compared sides"),
        count("pairs", "", "Pairs of blocks"),
        count("lost", "", "Wake-ups that never arrived"),
        percentiles("ours_us", "Percentiles of ours, µs"),
        percentiles("floor_us", "Percentiles of the floor, µs"),
        number("ratio", "", "", 2, "Ratio of the medians"),
        nested("ci95", Kind::List, "Its 95 % interval, lower and upper end"),
    ])
}

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    let mut goals = GOALS.to_vec();
    goals.push(nested("ci95", Kind::List, "95 % interval of the ratio; null: unbounded"));
    goals.push(nested("caveats", Kind::List, "Differences from the machine that the goal is for"));
    Schema::new("bench", "Overhead of timegap beside the machine's own floor")
        .fields(FIELDS)
        .rows("floor.rows", "The floor under each condition", &floor())
        .rows("transport_us", "Publish, wake and read", &transport())
        .rows("chain", "Reaction time of the chain with its hops", &chain())
        .rows("deadlines", "Deadlines missed by the controller and by the floor", &deadlines())
        .rows("paired", "Comparisons in alternating blocks, which decide the goals", &paired())
        .rows("goals", "Goals, as ratios to the floor", &goals)
}
