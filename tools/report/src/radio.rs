//! Radio frames, the on-board unit's verdicts, and the delay of a signal's change.

use crate::duration::{duration, percentiles};
use crate::html::{Column, section, table};
use crate::summary::Summary;
use crate::timing;
use group::report::ObuReport;
use runtime::statistics::Percentiles;

/// Lines for the terminal: label and text.
pub(crate) fn lines(summary: &Summary) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(radio) = &summary.radio {
        lines.push(("radio", format!("{} frames, {}", radio.frames, verdicts(radio))));
        if radio.left_out > 0 {
            lines.push(("", format!("{} frames did not fit into a batch", radio.left_out)));
        }
        if let Some(decode) = radio.decode_us.filter(|_| summary.mode == "realtime") {
            lines.push(("", format!("decoded and checked in {}", percentiles(&decode))));
        }
    }
    // In simulated time only the simulated air takes time.
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

/// The page's section; empty where no signal came by radio.
pub(crate) fn page(summary: &Summary) -> String {
    let mut counts = String::new();
    let radio = summary.radio.as_ref();
    if let Some(radio) = radio {
        let verdicts = radio.verdicts.iter().filter(|(_, count)| **count > 0);
        let mut rows: Vec<Vec<String>> = verdicts
            .map(|(verdict, count)| {
                vec![format!("frames {}", verdict.replace('_', " ")), count.to_string()]
            })
            .collect();
        rows.push(vec!["frames that did not fit into a batch".into(), radio.left_out.to_string()]);
        rows.push(vec!["own CAMs sent".into(), radio.cams_sent.to_string()]);
        let of = format!("of {} frames", radio.frames);
        counts = table(&[("signals by radio", Column::Text), (&*of, Column::Number)], &rows)
            + "<p>Frames carry no signature (IEEE 1609.2): the identity of a sender is not proven.</p>\n";
    }
    let hops = hops(summary).map(|(name, _, of_part)| (format!("… {name}"), of_part));
    let times = [
        ("Time on air", radio.and_then(|radio| radio.air_us)),
        ("Age of the forwarded signal timing", radio.and_then(|radio| radio.age_us)),
        ("Time to decode and check a frame", radio.and_then(|radio| radio.decode_us)),
        ("Signal's change to the first actuation that uses it", summary.timing.signal_reaction_us),
    ];
    let hops = hops.iter().map(|(name, of_part)| (name.as_str(), *of_part));
    let times = timing::table(times.into_iter().chain(hops));
    if counts.is_empty() && times.is_empty() {
        return String::new();
    }
    section("Radio", &(counts + &times))
}

fn verdicts(radio: &ObuReport) -> String {
    let given = radio.verdicts.iter().filter(|(_, count)| **count > 0);
    let parts: Vec<_> =
        given.map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " "))).collect();
    if parts.is_empty() { "none received".to_owned() } else { parts.join(", ") }
}

/// Parts of a signal's chain: long and short names.
fn hops(summary: &Summary) -> [(&'static str, &'static str, Option<Percentiles>); 4] {
    let hops = &summary.timing.signal_hops_us;
    [
        ("change to the announcement", "announce", hops.announce),
        ("frame, air and decoding", "receive", hops.receive),
        ("controller", "control", hops.control),
        ("command to actuation", "actuate", hops.actuate),
    ]
}
