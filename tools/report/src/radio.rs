//! What was on air: the frames and the on-board unit's verdicts, and the way of a signal's change.

use crate::duration::{duration, percentiles};
use crate::html::{Column, section, table};
use crate::summary::Summary;
use runtime::report::ObuReport;
use runtime::statistics::Percentiles;

/// Lines for the terminal: label and text.
pub(crate) fn lines(summary: &Summary) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(radio) = &summary.radio {
        lines.push(("radio", format!("{} frames, {}", radio.frames, verdicts(radio))));
        if radio.left_out > 0 {
            lines.push(("", format!("{} frames found no room in a batch", radio.left_out)));
        }
        if let Some(decode) = radio.decode_us.filter(|_| summary.mode == "realtime") {
            lines.push(("", format!("decoded and checked in {}", percentiles(&decode))));
        }
    }
    // In simulated time nothing takes time but the simulated air.
    let reaction = summary.timing.signal_reaction_us.filter(|reaction| reaction.max > 0.0);
    if let Some(reaction) = reaction {
        let parts = hops(summary).into_iter();
        let parts: Vec<_> = parts
            .filter_map(|(_, short, p)| p.map(|p| format!("{short} {}", duration(p.p50))))
            .collect();
        let (whole, parts) = (percentiles(&reaction), parts.join(", "));
        lines.push(("signal change", format!("to actuation {whole}; medians: {parts}")));
    }
    lines
}

/// The page's section; nothing where no signal came by radio.
pub(crate) fn page(summary: &Summary) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    if let Some(radio) = &summary.radio {
        for (verdict, count) in radio.verdicts.iter().filter(|(_, count)| **count > 0) {
            rows.push(vec![format!("frames {}", verdict.replace('_', " ")), count.to_string()]);
        }
        rows.push(vec!["frames without room in a batch".into(), radio.left_out.to_string()]);
        rows.push(vec!["own CAMs sent".into(), radio.cams_sent.to_string()]);
        let times = [
            ("time on air", radio.air_us),
            ("age of the signal timing handed on", radio.age_us),
            ("time to decode and check a frame", radio.decode_us),
        ];
        rows.extend(times.into_iter().filter_map(|(name, p)| row(name, p)));
    }
    let reaction = summary.timing.signal_reaction_us;
    rows.extend(row("signal's change to the first actuation that knows of it", reaction));
    for (name, _, of_part) in hops(summary) {
        rows.extend(row(&format!("of it: {name}"), of_part));
    }
    if rows.is_empty() {
        return String::new();
    }
    let count = match &summary.radio {
        Some(radio) => format!("of {} frames", radio.frames),
        None => String::new(),
    };
    let note =
        "<p>No frame is signed (IEEE 1609.2): that a sender is who it says is not proven.</p>";
    let note = if summary.radio.is_some() { note } else { "" };
    let head = [("signals by radio", Column::Text), (&*count, Column::Number)];
    section("Radio", &(table(&head, &rows) + note))
}

fn row(name: &str, figure: Option<Percentiles>) -> Option<Vec<String>> {
    figure.map(|figure| vec![name.to_owned(), percentiles(&figure)])
}

fn verdicts(radio: &ObuReport) -> String {
    let given = radio.verdicts.iter().filter(|(_, count)| **count > 0);
    let parts: Vec<_> =
        given.map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " "))).collect();
    if parts.is_empty() { "none heard".to_owned() } else { parts.join(", ") }
}

/// The parts of a signal's chain: long and short names.
fn hops(summary: &Summary) -> [(&'static str, &'static str, Option<Percentiles>); 4] {
    let hops = &summary.timing.signal_hops_us;
    [
        ("change to the making of the timing", "announce", hops.announce),
        ("frame, air and decoding", "receive", hops.receive),
        ("controller", "control", hops.control),
        ("command to actuation", "actuate", hops.actuate),
    ]
}
