//! `timegap campaign`: many seeded runs with faults, and one verdict.
//!
//! A campaign file names scenarios, controllers, faults and limits. Each combination has a number of runs, and each run
//! draws its faults from its own seed. A run keeps one record, and the verdict is made of the records alone. So a
//! campaign comes to the same verdict if it is interrupted and continued, or done in parts that are merged.
//!
//! ```text
//! file ─ plan ─► run 0 … run N-1 ─ job ─► drive ─ record ─► journal (a line per run, on the disk) ─► verdict
//!                                                                              └─ campaign.json, .csv, page
//! ```
//!
//! A collision counts as avoidable if braking with 6 m/s², 0.35 s after the need, avoids it
//! ([`supervise::is_avoidable_collision`]). A campaign fails when its faults meet nothing (`exposure`), and is refused when
//! its faults have no receiver (`targets`).
//!
//! ```toml
//! schema_version = 1
//! name = "lost-commands"
//! scenarios = ["following", "cut-in"]
//! seeds = 50
//!
//! [[faults]]
//! kind = "drop"
//! topic = "control/command"
//! probability = [0.1, 1.0] # one number between them is drawn for each run
//! at_s = [1.0, 20.0]
//! for_s = 5.0
//!
//! [require]
//! max_avoidable_collisions = 0
//! ```

mod blame;
mod columns;
mod document;
mod exposure;
mod file;
mod jobs;
mod launcher_death;
mod measured;
mod open;
mod plan;
mod record;
mod study;
mod sums;
mod template;
mod variation;
mod verdict;

pub use columns::schema;
pub use open::{BUILTIN, summaries};
pub use study::{CampaignArguments, ENTRY, run};
