//! Keys that were written and have no effect: the chosen law or radar model does not read them.
//!
//! A key that was written for this choice is refused. A file that is run with another law or model than its own, or
//! with several, keeps its keys. A note names those without effect.

use std::collections::BTreeSet;

use super::document::Document;
use super::problem::Problem;
use crate::perception::{Perception, RadarModel};

/// Keys of `[controller]` that the control loop itself reads, whatever the law.
const OF_THE_LOOP: [&str; 5] = ["name", "period_ms", "release", "deadline_ms", "curve_speed."];

/// Keys below `[controller]` that a law reads. Paths are relative to that table. One that ends in a dot is a whole table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    law: Option<String>,
    read: BTreeSet<String>,
    idle: BTreeSet<String>,
    backup: BTreeSet<String>,
}

impl Reads {
    /// Every key counts as read: for a reader without a law.
    pub fn everything() -> Self {
        Self::default()
    }

    /// The keys that the control loop reads for a law.
    pub fn of(law: &str) -> Self {
        let read = OF_THE_LOOP.map(str::to_owned).into();
        Self { law: Some(law.to_owned()), read, ..Self::default() }
    }

    pub fn key(&mut self, path: &str) {
        self.read.insert(path.to_owned());
    }

    pub fn table(&mut self, name: &str) {
        self.read.insert(format!("{name}."));
    }

    /// Takes out a key of such a table that the variant or the vehicle does not use.
    pub fn without(&mut self, path: String) {
        self.idle.insert(path);
    }

    /// Adds what a backup law reads that takes over from this one.
    pub fn backup(&mut self, other: Self) {
        self.backup.extend(other.read);
    }

    pub fn has(&self, path: &str) -> bool {
        self.law.is_none() || self.acts(path) || holds(&self.backup, path)
    }

    fn acts(&self, path: &str) -> bool {
        holds(&self.read, path) && !self.idle.contains(path)
    }

    /// Judges the keys that a document has below `[controller]`: what is to be noted of them.
    pub(super) fn judge(&self, document: &Document<'_>) -> Result<Vec<String>, Problem> {
        let Some(law) = &self.law else { return Ok(Vec::new()) };
        let of_several = "a file for several laws runs with --controller";
        let refuse = |key: &str, path: String| {
            let expected = match self.idle.contains(key) {
                true => "a key that this variant of the law reads".to_owned(),
                false => format!("a key that `{law}` reads; {of_several}"),
            };
            Problem::new(path, format!("{key} has no effect with the law `{law}`"), expected)
        };
        let written = document.written_below("controller").into_iter();
        let (backup, unread): (Vec<_>, Vec<_>) =
            written.filter(|key| !self.acts(key)).partition(|key| holds(&self.backup, key));
        let unread = for_another(document, "controller", unread, &["controller.name"], refuse)?;
        let backup: Vec<_> = backup.iter().map(|key| format!("controller.{key}")).collect();
        let unread = note(&unread, &format!("no effect with the law `{law}`"));
        Ok(unread.into_iter().chain(note(&backup, "an effect on the backup law alone")).collect())
    }
}

/// True if one of the keys is the one at `path`, or a table around it.
fn holds(keys: &BTreeSet<String>, path: &str) -> bool {
    keys.iter().any(|key| path == key || (key.ends_with('.') && path.starts_with(key)))
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
    let mut unread = document.written_below("perception");
    unread.retain(|key| idle.iter().any(|start| key.starts_with(start)));
    let effect = format!("no effect in the radar model `{model}`");
    let choosing = ["perception.radar.model", "perception.ideal"];
    let unread = for_another(document, "perception", unread, &choosing, |key, path| {
        let expected = "a key of this model, or another perception.radar.model";
        Problem::new(path, format!("{key} has {effect}"), expected).against(choosing[0])
    })?;
    Ok(note(&unread, &effect).into_iter().collect())
}

/// The paths of keys below `table` that have no effect. One that is not meant for another choice of the keys `choosing`
/// is refused.
fn for_another(
    document: &Document<'_>,
    table: &str,
    unread: Vec<String>,
    choosing: &[&str],
    refuse: impl Fn(&str, String) -> Problem,
) -> Result<Vec<String>, Problem> {
    let path = |key: String| {
        let path = format!("{table}.{key}");
        match document.is_for_another(choosing, &path) {
            true => Ok(path),
            false => Err(refuse(&key, path)),
        }
    };
    unread.into_iter().map(path).collect()
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
