//! The command line.

use crate::live::LiveOptions;
use crate::recordings::diff::DiffArguments;
use crate::recordings::export::ExportArguments;
use crate::recordings::info::InfoArguments;
use crate::recordings::layouts::LayoutsArguments;
use crate::recordings::recover::RecoverArguments;
use crate::recordings::replay::ReplayArguments;
use crate::trace::TraceArguments;
use clap::{Args, Parser, Subcommand, ValueEnum};
use shared::Service;
use std::path::PathBuf;

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
    Run(RunArguments),
    /// Run a paper's scenarios in lockstep and print its published figures beside ours
    Reproduce(ReproduceArguments),
    /// Latency, jitter and deadline misses, beside the machine's own floor
    Bench(crate::bench::BenchArguments),
    /// Controllers side by side on the same scenarios
    Compare(CompareArguments),
    /// A recorded run as a trace for Perfetto
    Trace(TraceArguments),
    /// Many seeded runs with faults, and one verdict
    Campaign(crate::campaign::CampaignArguments),
    /// A figure of the drive as a function of any key of a scenario
    Sweep(crate::sweep::SweepArguments),
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
    Synthesize(SynthesizeArguments),
    /// What this machine grants, what the rest costs, and the command that mends it
    Doctor(crate::doctor::DoctorArguments),
    /// A fault into a run that is going on
    Inject(crate::inject::InjectArguments),
    /// List the scenarios, controllers and campaigns
    List(ListArguments),
    /// Run one service; started by the launcher
    #[command(hide = true)]
    Service(ServiceArguments),
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Name of a built-in scenario (see `timegap list`), or a TOML file
    #[arg(default_value = "cacc-a")]
    pub scenario: String,
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    #[command(flatten)]
    pub group: GroupOptions,
    /// Clock: `realtime`, or `lockstep` in simulated time, byte for byte repeatable
    #[arg(long, value_enum, default_value_t = ModeName::Realtime)]
    pub mode: ModeName,
    /// Directory for the results [default: runs/<time>-<scenario>]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub live: LiveOptions,
    /// Keep no recording of the topics
    #[arg(long)]
    pub no_record: bool,
    /// Print the summary as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// What a scenario can be changed by.
#[derive(Clone, Debug, Default, Args)]
pub struct ScenarioOptions {
    /// Control law (see `timegap list`)
    #[arg(long, value_name = "NAME")]
    pub controller: Option<String>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub seed: Option<String>,
    /// Length of the run, s
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    pub duration: Option<String>,
    /// Change any key of the scenario, by its dotted path; may be given again
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// How a group is brought up.
#[derive(Clone, Debug, Args)]
pub struct GroupOptions {
    /// Run PROGRAM in the place of a service; may be given again
    #[arg(long = "service", value_name = "NAME=PROGRAM", value_parser = service_program)]
    pub programs: Vec<(Service, PathBuf)>,
    /// Time in which all services must be ready, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = positive_seconds)]
    pub ready_timeout: f64,
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Which paper; all when omitted
    #[arg(value_enum)]
    pub paper: Option<PaperName>,
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory for the results [default: runs/<time>-reproduce]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the rows as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// A paper by the name of its controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PaperName {
    /// Wang, Liu, Zhang, Tong 2014.
    SixMode,
    /// Gao, Yan, Li, Hu 2015.
    QuadraticBounded,
    /// Li, Zheng, Wang, Wang.
    Predictive,
    /// He, Xi, Huang, Chen, Huang 2024.
    Cacc,
}

impl PaperName {
    /// Name on the command line and in results.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::SixMode => "six-mode",
            Self::QuadraticBounded => "quadratic-bounded",
            Self::Predictive => "predictive",
            Self::Cacc => "cacc",
        }
    }
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Names of built-in scenarios, or TOML files
    #[arg(required = true)]
    pub scenarios: Vec<String>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Clock: figures of the drive repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_enum, default_value_t = ModeName::Lockstep)]
    pub mode: ModeName,
    /// Change any key of every scenario, by its dotted path; may be given again
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory for the results [default: runs/<time>-compare]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the rows as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `synthesize`.
#[derive(Debug, Args)]
pub struct SynthesizeArguments {
    /// Which controller
    #[arg(value_enum)]
    pub controller: DesignName,
    /// Parameters, TOML (see services/controller/designs/quadratic-bounded.toml)
    pub file: PathBuf,
    /// Where to write the design
    #[arg(long, value_name = "FILE", default_value = "design.json")]
    pub out: PathBuf,
    /// Print the design as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// A controller that is designed offline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DesignName {
    /// Gao, Yan, Li, Hu 2015.
    QuadraticBounded,
}

/// Clock by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeName {
    /// The wall's clock.
    Realtime,
    /// Simulated time.
    Lockstep,
}

impl From<ModeName> for shared::runtime::Mode {
    fn from(name: ModeName) -> Self {
        match name {
            ModeName::Realtime => Self::Realtime,
            ModeName::Lockstep => Self::Lockstep,
        }
    }
}

/// Arguments of `list`.
#[derive(Debug, Args)]
pub struct ListArguments {
    /// Print this built-in scenario's or campaign's file
    #[arg(long, value_name = "NAME")]
    pub show: Option<String>,
    /// Print the list as JSON
    #[arg(long, conflicts_with = "show")]
    pub json: bool,
}

/// Arguments of `service`.
#[derive(Debug, Args)]
pub struct ServiceArguments {
    /// Which one
    pub name: String,
    /// The service's own arguments
    pub arguments: Vec<String>,
}

fn service_program(argument: &str) -> Result<(Service, PathBuf), String> {
    let (name, program) = argument.split_once('=').ok_or("expected NAME=PROGRAM")?;
    Ok((name.parse()?, PathBuf::from(program)))
}

fn positive_seconds(argument: &str) -> Result<f64, String> {
    match argument.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 3600.0 => Ok(seconds),
        _ => Err("expected a number of seconds above 0 and at most 3600".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn a_service_program_names_a_service() {
        let (service, program) = service_program("controller=./mine").expect("a known service");
        assert_eq!((service, program), (Service::Controller, PathBuf::from("./mine")));
        assert!(service_program("radar=./mine").is_err_and(|e| e.contains("perception-sim")));
    }
}
