//! Faults in words, the same on the console, the page and the live views.

use crate::print::duration;
use messages::Service;
use scenario::faults::Helper;
use supervise::FaultRecord;

/// Kind and target of a fault: `kill controller`.
pub fn name(record: &FaultRecord) -> String {
    let target = record.service.map(Service::name).or(record.topic);
    let target = target.or(record.helper.map(Helper::name)).unwrap_or_default();
    format!("{} {target}", record.kind).trim_end().to_owned()
}

/// Effect and end of a fault, as far as they are known: `detected after 1.20 ms, back after 9.80 ms by restart`.
pub fn outcome(record: &FaultRecord) -> String {
    let after = |us: Option<f64>, what: &str| us.map(|us| format!("{what} after {}", duration(us)));
    let by = record.recovered_by.map_or_else(String::new, |by| format!(" by {}", by.name()));
    let parts = [
        after(record.detected_after_us, "detected"),
        after(record.recovered_after_us, "back").map(|back| back + &by),
        record.messages.map(|messages| format!("{messages} messages")),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
