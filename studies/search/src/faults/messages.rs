//! All faults of messages and of timing that a scenario can have.
//!
//! | fault | size | from, to |
//! | --- | --- | --- |
//! | `delay` of each topic | delay | 10 ms, 1 s |
//! | `drop`, `duplicate`, `reorder`, `corrupt` of each topic | share of the messages | 5 %, all |
//! | `freeze` of each topic | - | - |
//! | `bias` of a figure, up and down | the figure's unit | a tenth of the largest one |
//! | `stale` of each topic | age added | 50 ms, 5 s |
//! | `clock-step` of each service | time ahead | 50 ms, 5 s |
//! | `runtime.extra_delay_ms`, `runtime.extra_jitter_ms` | delay | 10 ms, 500 ms, in steps of the plant's period |
//! | `runtime.miss_probability` | share of the cycles | 5 %, 95 % |
//!
//! Chosen: the largest sizes are beyond what a system in order could show.

use messages::Service;
use scenario::faults::TopicName;

use super::sort::Sort;

pub(super) fn sorts() -> Vec<Sort> {
    let text = |word: &str| format!("\"{word}\"");
    let mut all = Vec::new();
    for topic in TopicName::all() {
        let keys = |kind| vec![("kind", text(kind)), ("topic", text(topic.name()))];
        let of = |kind: &'static str, unit, size| Sort {
            name: format!("{kind} {}", topic.name()),
            unit,
            size,
            keys: Some(keys(kind)),
        };
        all.push(of("delay", "ms", Some(("delay_ms", 10.0, 1_000.0))));
        for kind in ["drop", "duplicate", "reorder", "corrupt"] {
            all.push(of(kind, "", Some(("probability", 0.05, 1.0))));
        }
        all.push(of("freeze", "", None));
        all.push(of("stale", "s", Some(("amount", 0.05, 5.0))));
    }
    for (topic, field, unit, most) in [
        ("radar/tracks", "gap_m", "m", 40.0),
        ("radar/tracks", "relative_speed_mps", "m/s", 15.0),
        ("vehicle/odometry", "speed_mps", "m/s", 15.0),
        ("v2x/spat", "end_s", "s", 20.0),
    ] {
        for (sign, word) in [(1.0, "up"), (-1.0, "down")] {
            let keys = vec![("kind", text("bias")), ("topic", text(topic)), ("field", text(field))];
            all.push(Sort {
                name: format!("bias {field} {word}"),
                unit,
                size: Some(("amount", sign * most / 10.0, sign * most)),
                keys: Some(keys),
            });
        }
    }
    for service in Service::ALL {
        let keys = vec![("kind", text("clock-step")), ("service", text(service.name()))];
        all.push(Sort {
            name: format!("clock-step {}", service.name()),
            unit: "s",
            size: Some(("amount", 0.05, 5.0)),
            keys: Some(keys),
        });
    }
    for (key, unit, from, to) in [
        ("runtime.extra_delay_ms", "ms", 10.0, 500.0),
        ("runtime.extra_jitter_ms", "ms", 10.0, 500.0),
        ("runtime.miss_probability", "", 0.05, 0.95),
    ] {
        let name = key.trim_start_matches("runtime.").to_owned();
        all.push(Sort { name, unit, size: Some((key, from, to)), keys: None });
    }
    all
}
