//! The counts over some runs. Each has one row: its field, its name in results, its column, and a run's part.

use report::results::{Column, count};
use schemars::JsonSchema;
use serde::Serialize;
use supervise::report::Outcome;

use super::record::Record;

/// Appearance and limit of a count.
enum Shown {
    /// A column of the tables of runs with this weight, and a limit of campaigns.
    Column(u8),
    /// The same without a limit.
    Unlimited(u8),
    /// Among the totals of all runs, and a limit of campaigns.
    Total,
    /// The same without a limit.
    UnlimitedTotal,
}

use Shown::{Column as Shows, Total, Unlimited, UnlimitedTotal};

/// Declares the counts: `field "name", "heading", "meaning", shown, record -> its share;`.
macro_rules! counts {
    ($($field:ident $name:literal, $heading:literal, $meaning:literal, $shown:expr, $of:expr;)+) => {
        /// Counts over some runs.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
        pub struct Counts {
            $(#[doc = $meaning] #[serde(rename = $name)] pub $field: u64,)+
        }

        impl Counts {
            pub fn add(&mut self, record: &Record) {
                $(
                    let of: fn(&Record) -> u64 = $of;
                    self.$field += of(record);
                )+
            }
        }

        const NAMED: &[(&str, fn(&Counts) -> u64)] =
            &[$((stringify!($field), |counts| counts.$field)),+];

        const SHOWN: &[Shown] = &[$($shown),+];

        pub fn columns<R>() -> Vec<Column<R>> {
            let all = vec![$(count($name, $heading, $meaning)),+];
            let shown = |(column, shown): (Column<R>, &Shown)| match shown {
                Shows(weight) | Unlimited(weight) => column.weight(*weight),
                Total | UnlimitedTotal => column.hidden(),
            };
            all.into_iter().zip(SHOWN).map(shown).collect()
        }
    };
}

fn ended(record: &Record, outcome: Outcome) -> u64 {
    u64::from(record.outcome == outcome)
}

/// A group whose launcher is killed always ends as aborted.
fn aborted(record: &Record, by_its_launcher: bool) -> u64 {
    u64::from(
        record.outcome == Outcome::Aborted && record.measured.launcher_died == by_its_launcher,
    )
}

counts! {
    runs "runs", "runs", "Runs", Unlimited(0), |_| 1;
    completed "completed", "completed", "Runs that reached their end", Unlimited(0), |r| ended(r, Outcome::Completed);
    safe_stops "safe_stops", "safe stops", "Runs that ended in a safe stop", Shows(2), |r| ended(r, Outcome::SafeStop);
    collisions "collisions", "collisions", "Runs that ended in a collision", Shows(0), |r| ended(r, Outcome::Collision);
    interventions "interventions", "emergency brakings", "Interventions of the emergency brake", Shows(1),
        |r| r.measured.interventions;
    red_lights "red_lights", "red lights", "Runs that ended at a red light", Shows(0), |r| ended(r, Outcome::RedLight);
    driven_by_backup "driven_by_backup", "driven by backup", "Runs that the backup law drove", Shows(3),
        |r| ended(r, Outcome::DrivenByBackup);
    requirements_broken "requirements_broken", "requirement broken", "Runs that broke a requirement of their scenario",
        Shows(4), |r| ended(r, Outcome::RequirementBroken);
    aborted "aborted", "aborted", "Runs that were aborted", Shows(2), |r| aborted(r, false);
    avoidable_collisions "avoidable_collisions", "avoidable collisions", "That a braking reference avoids", Total,
        |r| u64::from(r.measured.avoidable);
    faults_struck "faults", "faults that acted", "Faults that acted", Total, |r| r.measured.faults;
    critical_faults "critical_faults", "faults in critical phases", "Faults that acted in a critical phase", Total,
        |r| r.measured.critical_faults;
    kills "kills", "processes killed", "Killed processes", Total, |r| r.measured.kills;
    double_kills "double_kills", "pairs killed within 5 ms", "Pairs of services killed within 5 ms", Total,
        |r| r.measured.double_kills;
    starting_kills "starting_kills", "killed while starting", "Killed before they took part", Total,
        |r| r.measured.starting_kills;
    helper_kills "helper_kills", "helpers killed", "Killed recorders, janitors and launchers", Total,
        |r| r.measured.helper_kills;
    launcher_kills "launcher_kills", "launchers killed", "Runs that ended with their launcher", Total,
        |r| aborted(r, true);
    recordings_lost "recordings_lost", "recordings lost", "Recordings that cannot be read or end early", Total,
        |r| u64::from(r.measured.recording_lost);
    unrecovered "unrecovered", "unrecovered", "Process faults without a recovery", Total, |r| r.measured.unrecovered;
    degraded "degraded", "services degraded at the end", "Services below the first level at the end", Total,
        |r| r.measured.degraded.len() as u64;
    leaks "leaks", "leftovers", "Objects and processes left behind", Total, |r| r.measured.leaks.len() as u64;
    messages_lost "messages_lost", "messages lost", "Lost messages", Total, |r| r.measured.messages_lost;
    disturbed "disturbed", "messages disturbed", "Disturbed by faults, over all receivers", UnlimitedTotal,
        |r| r.measured.disturbed;
    corrupted "corrupted", "messages corrupted", "Corrupted by faults", UnlimitedTotal, |r| r.measured.corrupted;
    undetected_corruptions "undetected_corruptions", "corruptions accepted", "Accepted corrupted messages", Total,
        |r| r.measured.undetected;
}

/// The counts that a campaign can limit, by the names behind `max_` and `min_`.
pub fn limited() -> impl Iterator<Item = (&'static str, fn(&Counts) -> u64)> {
    let all = NAMED.iter().zip(SHOWN);
    all.filter(|(_, shown)| matches!(shown, Shows(_) | Total)).map(|(named, _)| *named)
}
