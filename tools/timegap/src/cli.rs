//! The command line.

use crate::recordings::diff::DiffArguments;
use crate::recordings::export::ExportArguments;
use crate::recordings::info::InfoArguments;
use crate::recordings::layouts::LayoutsArguments;
use crate::recordings::recover::RecoverArguments;
use crate::recordings::replay::ReplayArguments;
use crate::trace::TraceArguments;
use clap::{Parser, Subcommand};

/// An adaptive-cruise stack as real processes over shared memory: driven, measured, broken.
#[derive(Debug, Parser)]
#[command(name = "timegap", version, after_help = EXIT_STATUS, disable_help_subcommand = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_STATUS: &str = "Exit status: 0 all well; 1 the run broke a requirement (a collision, a \
red light, a failed check); 2 bad usage or a bad file; 3 the machine would not let it run; \
130 interrupted.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the process group through a scenario
    Run(crate::run::RunArguments),
    /// Run a paper's scenarios in lockstep and print its published figures beside ours
    Reproduce(campaign::reproduce::ReproduceArguments),
    /// Latency, jitter and deadline misses, beside the machine's own floor
    Bench(bench::BenchArguments),
    /// Controllers side by side on the same scenarios
    Compare(campaign::compare::CompareArguments),
    /// A recorded run as a trace for Perfetto
    Trace(TraceArguments),
    /// Many seeded runs with faults, and one verdict
    Campaign(campaign::campaign::CampaignArguments),
    /// A figure of the drive as a function of any key of a scenario
    Sweep(campaign::sweep::SweepArguments),
    /// What a recording holds
    Info(InfoArguments),
    /// Make a recording whole that was cut off
    Recover(RecoverArguments),
    /// Write a recording as tables
    Export(ExportArguments),
    /// Give a recorded run's inputs to the controller again and compare its commands
    Replay(ReplayArguments),
    /// Find where two recordings part
    Diff(DiffArguments),
    /// Print the messages' layouts for Python or C
    Layouts(LayoutsArguments),
    /// Design a controller offline (cargo feature `synthesize`)
    Synthesize(crate::synthesize::SynthesizeArguments),
    /// What this machine grants, what the rest costs, and the command that mends it
    Doctor(doctor::DoctorArguments),
    /// A fault into a run that is going on
    Inject(crate::inject::InjectArguments),
    /// List the scenarios, controllers and campaigns
    List(crate::list::ListArguments),
    /// Run one service; started by the launcher
    #[command(hide = true)]
    Service(crate::service::ServiceArguments),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
