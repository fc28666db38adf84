//! Counts of the loop's cycles, for its report.

use crate::law::{Formulation, Output, Quality};
use crate::report::ModeChange;
use messages::FIGURES;
use messages::level::{Level, LevelLog};

/// Mode changes that are kept. Further changes are dropped.
const MAX_MODE_CHANGES: usize = 4096;

#[derive(Clone, Copy)]
struct Change {
    time_s: f64,
    from: u32,
    to: u32,
    reason: u32,
    figures: [f64; FIGURES],
}

#[derive(Default)]
pub struct Account {
    /// Commands that were sent after their deadline.
    pub deadline_misses: u64,
    /// Cycles in which a constraint was relaxed.
    pub relaxed: u64,
    /// Cycles in which the backup drove.
    pub backup: u64,
    pub levels: LevelLog,
    mode: Option<u32>,
    changes: Vec<Change>,
}

impl Account {
    /// Nothing yet; it allocates no more after this.
    pub fn new() -> Self {
        Self { changes: Vec::with_capacity(MAX_MODE_CHANGES), ..Self::default() }
    }

    pub fn count(&mut self, time_s: f64, output: &Output, level: Level) {
        match output.quality {
            Quality::Full => {}
            Quality::Relaxed => self.relaxed += 1,
            Quality::Backup | Quality::FallBack => self.backup += 1,
        }
        let to = output.mode;
        if let Some(from) = self.mode
            && from != to
            && self.changes.len() < MAX_MODE_CHANGES
        {
            let (reason, figures) = (output.mode_reason, output.figures);
            self.changes.push(Change { time_s, from, to, reason, figures });
        }
        self.mode = Some(to);
        self.levels.observe(time_s, level);
    }

    /// The mode changes in the words of `formulation`.
    pub fn mode_changes(&self, formulation: &Formulation) -> Vec<ModeChange> {
        let name = |names: &[&str], index: u32| {
            names.get(index as usize).map_or_else(|| index.to_string(), ToString::to_string)
        };
        let figures = |values: &[f64; FIGURES]| {
            let names = formulation.figures.iter().map(|figure| figure.name.to_owned());
            // A figure that does not apply in this mode is left out.
            names.zip(*values).filter(|(_, value)| value.is_finite()).collect()
        };
        let change = |change: &Change| ModeChange {
            t_s: change.time_s,
            from: name(formulation.modes, change.from),
            to: name(formulation.modes, change.to),
            reason: name(formulation.reasons, change.reason),
            figures: figures(&change.figures),
        };
        self.changes.iter().map(change).collect()
    }
}
