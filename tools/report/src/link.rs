//! Frames between the vehicle and other hosts.

use crate::duration::duration;
use crate::html::{Column, section, table};
use crate::summary::Summary;
use group::report::{LinkReport, StationReport};

/// Lines for the terminal: label and text.
pub(crate) fn lines(summary: &Summary) -> Vec<(&'static str, String)> {
    let Some(link) = &summary.link else { return Vec::new() };
    let LinkReport { carrier, received, sent, .. } = link;
    let mut lines = vec![("link", format!("{carrier}: {received} frames received, {sent} sent"))];
    for station in link.stations.iter().filter(|station| station.received > 0) {
        let StationReport { sender, received, lost, duplicates, reordered, .. } = station;
        let clock = clock(station).map_or_else(String::new, |clock| format!("; {clock}"));
        lines.push((
            "",
            format!(
                "station {sender}: {received} received, {lost} lost, {duplicates} repeated, {reordered} out of order{clock}"
            ),
        ));
    }
    let unused = link.before_start + link.dropped + link.malformed;
    if unused > 0 {
        let LinkReport { before_start, dropped, malformed, .. } = link;
        let text = format!(
            "not used: {before_start} from before the start, {dropped} for which the queue was full, \
             {malformed} that are not frames"
        );
        lines.push(("", text));
    }
    if !link.truth_known {
        lines.push(("", UNKNOWN_TRUTH.to_owned()));
    }
    lines
}

const UNKNOWN_TRUTH: &str =
    "the true signal phases are not known on this host: red lights were not judged";

fn clock(station: &StationReport) -> Option<String> {
    let (offset_us, uncertainty_us) = station.clock_offset_us.zip(station.clock_uncertainty_us)?;
    let (sign, by) = (if offset_us < 0.0 { "behind" } else { "ahead" }, offset_us.abs());
    Some(format!("its clock {} {sign}, known to {}", duration(by), duration(uncertainty_us)))
}

/// The page's section; empty where the roadside units were simulated.
pub(crate) fn page(summary: &Summary) -> String {
    let Some(link) = &summary.link else { return String::new() };
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row = |name: String, value: String| rows.push(vec![name, value]);
    for (name, count) in [
        ("frames received", link.received),
        ("of these, sent before the start", link.before_start),
        ("frames for which the queue was full", link.dropped),
        ("packets that are not frames", link.malformed),
        ("own frames sent", link.sent),
        ("own frames that could not be sent", link.not_sent),
    ] {
        row(name.to_owned(), count.to_string());
    }
    for station in &link.stations {
        let StationReport { sender, received, lost, duplicates, reordered, .. } = station;
        row(
            format!("station {sender}: received, lost, repeated, out of order"),
            format!("{received}, {lost}, {duplicates}, {reordered}"),
        );
        if let Some(clock) = clock(station) {
            row(format!("station {sender}"), clock);
        }
    }
    let note = if link.truth_known { "" } else { UNKNOWN_TRUTH };
    let head = [("between hosts", Column::Text), (link.carrier.as_str(), Column::Number)];
    section("Link", &format!("{}<p>{note}</p>", table(&head, &rows)))
}
