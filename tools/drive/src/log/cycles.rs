//! Counts of a controller's cycles over all its processes. A run of a day takes as much memory as one of a minute.

use messages::Diagnostics;
use messages::level::{Level, LevelLog};

/// Most changes of the mode; later ones are dropped.
const MAX_CHANGES: usize = 10_000;

/// Quality of a command that came from a backup.
const BACKUP: u32 = 2;

/// The cycles so far.
#[derive(Clone, Debug, Default)]
pub struct CycleHistory {
    /// Steps between two releases of the controller.
    stride: u64,
    pub count: u64,
    /// Cycles by the quality of their command.
    quality: [u64; 4],
    /// Cycles in which the law's own backup drove, not the ladder's braking.
    pub by_backup: u64,
    /// Cycles in which the degradation ladder braked.
    pub by_ladder: u64,
    /// Releases without a cycle, between two cycles of one process.
    pub left_out: u64,
    /// Mode before a change, and the first cycle after it.
    pub changes: Vec<(u32, Diagnostics)>,
    pub levels: LevelLog,
    last: Option<Diagnostics>,
}

impl CycleHistory {
    /// A history before the first cycle.
    pub fn new(stride: u64) -> Self {
        Self { stride, ..Self::default() }
    }

    /// Counts the next cycle.
    pub fn observe(&mut self, cycle: &Diagnostics) {
        self.count += 1;
        if let Some(count) = self.quality.get_mut(cycle.quality as usize) {
            *count += 1;
        }
        let level = Level::by_number(cycle.rung);
        let is_ladder = matches!(level, Some(Level::LeadLost | Level::Silent));
        let is_backup = cycle.quality == BACKUP;
        self.by_backup += u64::from(is_backup && !is_ladder);
        self.by_ladder += u64::from(is_backup && is_ladder);
        if let Some(level) = level {
            self.levels.observe(cycle.header.acquisition_ns as f64 / 1e9, level);
        }
        if let Some(last) = &self.last {
            if last.header.incarnation == cycle.header.incarnation {
                let due = last.header.step / self.stride + 1;
                self.left_out += (cycle.header.step / self.stride).saturating_sub(due);
            }
            if last.mode != cycle.mode && self.changes.len() < MAX_CHANGES {
                self.changes.push((last.mode, *cycle));
            }
        }
        self.last = Some(*cycle);
    }

    /// Cycles with a command of this quality.
    pub fn of_quality(&self, quality: usize) -> u64 {
        self.quality[quality]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn history(cycles: &[(u64, u32, u32)]) -> CycleHistory {
        let mut history = CycleHistory::new(10);
        for &(step, incarnation, mode) in cycles {
            let mut cycle = Diagnostics::zeroed();
            cycle.header.step = step;
            cycle.header.incarnation = incarnation;
            cycle.mode = mode;
            history.observe(&cycle);
        }
        history
    }

    #[test]
    fn releases_left_out_are_counted_within_a_process() {
        let history = history(&[(0, 0, 0), (10, 0, 0), (40, 0, 0), (95, 1, 0), (100, 1, 0)]);
        assert_eq!(history.left_out, 2, "20 and 30; what lay between two processes is none's");
        assert_eq!((history.count, history.of_quality(0)), (5, 5));
    }

    #[test]
    fn braking_by_the_ladder_is_not_the_laws_backup() {
        let mut history = CycleHistory::new(10);
        for (quality, level) in [
            (0, Level::Full),
            (BACKUP, Level::Full),
            (BACKUP, Level::SolveFailed),
            (BACKUP, Level::LeadLost),
            (3, Level::OutsideEnvelope),
        ] {
            let mut cycle = Diagnostics::zeroed();
            (cycle.quality, cycle.rung) = (quality, level as u32);
            history.observe(&cycle);
        }
        assert_eq!((history.by_backup, history.by_ladder), (2, 1));
    }

    #[test]
    fn changes_of_the_mode_are_kept_up_to_a_bound() {
        let many: Vec<_> = (0..3 * MAX_CHANGES as u64).map(|k| (10 * k, 0, k as u32 % 2)).collect();
        let history = history(&many);
        assert_eq!(history.changes.len(), MAX_CHANGES);
        assert_eq!((history.changes[0].0, history.changes[0].1.header.step), (0, 10));
    }
}
