//! Keys that were written and have no effect: the chosen law or radar model does not read them.
//!
//! A key that was written for this choice is refused. A file that is run with another law or model than its own, or
//! with several, keeps its keys. A note names those without effect.

use std::collections::BTreeSet;

use super::document::Document;
use super::problem::Problem;
use crate::perception::{Perception, RadarModel};

/// Keys of `[controller]` that the control loop itself reads, whatever the law.
const OF_THE_LOOP: [&str; 4] = ["name", "period_ms", "release", "deadline_ms"];
/// A table of the loop's, with the dot before its keys.
const CURVE_SPEED: &str = "curve_speed.";

/// Keys below `[controller]` that a law reads. Paths are relative to that table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    law: Option<String>,
    keys: BTreeSet<String>,
    tables: BTreeSet<String>,
    idle: BTreeSet<String>,
    backup: BTreeSet<String>,
}

impl Reads {
    /// Every key counts as read: for a reader without a law.
    pub fn everything() -> Self {
        Self::default()
    }

    /// The keys of a law that has read nothing yet.
    pub fn of(law: &str) -> Self {
        Self { law: Some(law.to_owned()), ..Self::default() }
    }

    /// Adds a key that the law reads.
    pub fn key(&mut self, path: &str) {
        self.keys.insert(path.to_owned());
    }

    /// Adds a table that the law reads.
    pub fn table(&mut self, name: &str) {
        self.tables.insert(format!("{name}."));
    }

    /// Takes out a key of such a table that the variant or the vehicle does not use.
    pub fn without(&mut self, path: String) {
        self.idle.insert(path);
    }

    /// Adds what a backup law reads that takes over from this one.
    pub fn backup(&mut self, other: Self) {
        self.backup.extend(other.keys.into_iter().chain(other.tables));
    }

    /// True if the law reads the key.
    pub fn has(&self, path: &str) -> bool {
        self.law.is_none() || self.acts(path) || self.acts_on_backup(path)
    }

    fn acts(&self, path: &str) -> bool {
        let in_table = self.tables.iter().any(|table| path.starts_with(table.as_str()));
        let in_own = in_table && !self.idle.contains(path);
        let in_loop = OF_THE_LOOP.contains(&path) || path.starts_with(CURVE_SPEED);
        in_own || in_loop || self.keys.contains(path)
    }

    fn acts_on_backup(&self, path: &str) -> bool {
        self.backup.iter().any(|key| path == key || (key.ends_with('.') && path.starts_with(key)))
    }

    /// Judges the keys that a document has below `[controller]`: what is to be noted of them.
    pub(super) fn judge(&self, document: &Document<'_>) -> Result<Vec<String>, Problem> {
        let Some(law) = &self.law else { return Ok(Vec::new()) };
        let (mut unread, mut backup) = (Vec::new(), Vec::new());
        for key in document.written_below("controller") {
            if self.acts(&key) {
                continue;
            }
            let path = format!("controller.{key}");
            if self.acts_on_backup(&key) {
                backup.push(path);
            } else if document.is_for_another(&["controller.name"], &path) {
                unread.push(path);
            } else {
                let message = format!("{key} has no effect with the law `{law}`");
                let expected = match self.idle.contains(&key) {
                    true => "a key that this variant of the law reads".to_owned(),
                    false => format!(
                        "a key that `{law}` reads; a file for several laws runs with --controller"
                    ),
                };
                return Err(Problem::new(path, message, expected));
            }
        }
        let unread = note(&unread, &format!("no effect with the law `{law}`"));
        Ok(unread.into_iter().chain(note(&backup, "an effect on the backup law alone")).collect())
    }
}

/// Judges the keys that a document has below `[perception]`, as [`Reads::judge`] does.
pub(super) fn judge_radar(
    document: &Document<'_>,
    perception: &Perception,
) -> Result<Vec<String>, Problem> {
    let (model, idle): (_, &[&str]) = match perception.model() {
        RadarModel::Detections => ("detections", &SIGMAS),
        RadarModel::ObjectList => ("object-list", &["radar.detections.", "tracker.confirm_"]),
        RadarModel::Ideal => ("ideal", &NOT_IDEAL),
    };
    let mut unread = Vec::new();
    for key in document.written_below("perception") {
        if !idle.iter().any(|start| key.starts_with(start)) {
            continue;
        }
        let path = format!("perception.{key}");
        if !document.is_for_another(&["perception.radar.model", "perception.ideal"], &path) {
            let message = format!("{key} has no effect in the radar model `{model}`");
            let expected = "a key of this model, or another perception.radar.model";
            return Err(Problem::new(path, message, expected).against("perception.radar.model"));
        }
        unread.push(path);
    }
    Ok(note(&unread, &format!("no effect in the radar model `{model}`")).into_iter().collect())
}

/// Accuracies of the model `object-list`.
const SIGMAS: [&str; 3] =
    ["radar.range_sigma_m", "radar.range_rate_sigma_mps", "radar.azimuth_sigma_deg"];

/// Beginnings of the keys that exact tracks do not read.
const NOT_IDEAL: [&str; 8] = [
    SIGMAS[0],
    SIGMAS[1],
    SIGMAS[2],
    "radar.dropout_probability",
    "radar.latency_ms",
    "radar.detections.",
    "tracker.",
    "target_selection.predict_s",
];

fn note(paths: &[String], effect: &str) -> Option<String> {
    let verb = if paths.len() == 1 { "has" } else { "have" };
    (!paths.is_empty()).then(|| format!("{} {verb} {effect}", paths.join(", ")))
}
