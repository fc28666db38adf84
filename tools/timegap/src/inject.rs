//! `timegap inject`: inject a fault into a run that is going on.

use clap::Args;
use group::Error;
use group::control;
use messages::Service;
use messages::Topic;
use report::print;
use runtime::Group;
use scenario::faults::{BiasedField, Fault, Kind, TopicName};
use scenario::quantity::{Core, Count, DelayMs, Duration, Megabytes, Probability, Shift};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `inject`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InjectArguments {
    /// Results directory of the run
    pub run: PathBuf,
    /// Kind of the fault: kill, stop, restart-storm, hog, memory, delay, drop, duplicate, reorder,
    /// corrupt, freeze, bias, stale, clock-step
    pub kind: Kind,
    /// The service or the topic that it acts on
    pub target: Option<String>,
    /// How long it lasts, s [default: to the end of the run]
    #[arg(long = "for", value_name = "SECONDS")]
    pub length: Option<f64>,
    /// When it begins from now, s
    #[arg(long = "in", value_name = "SECONDS")]
    pub after: Option<f64>,
    /// Probability with which it acts on a message
    #[arg(long, default_value_t = 1.0)]
    pub probability: f64,
    /// `delay`: by how much, ms
    #[arg(long, value_name = "MS")]
    pub delay_ms: Option<i64>,
    /// `delay`: up to so much more, ms
    #[arg(long, value_name = "MS")]
    pub jitter_ms: Option<i64>,
    /// `corrupt`: bits flipped in a message
    #[arg(long)]
    pub bits: Option<i64>,
    /// `bias`: gap_m, relative_speed_mps, speed_mps or end_s
    #[arg(long)]
    pub field: Option<String>,
    /// `bias`: by how much; `stale`, `clock-step`: shift of the stamps, s
    #[arg(long, allow_hyphen_values = true)]
    pub amount: Option<f64>,
    /// `hog`: the core [default: all]
    #[arg(long)]
    pub core: Option<i64>,
    /// `memory`: how much, MiB
    #[arg(long)]
    pub megabytes: Option<i64>,
    /// `restart-storm`: how often
    #[arg(long)]
    pub times: Option<i64>,
    /// Print the answer as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

const EXAMPLES: &str = "Examples:
  timegap inject runs/20261121T120000-following kill controller
  timegap inject RUN stop perception-sim --for 0.2
  timegap inject RUN drop v2x/spat --for 5 --probability 0.5
  timegap inject RUN bias radar/tracks --field gap_m --amount 10 --for 3";

/// Runs the command.
pub fn run(arguments: &InjectArguments) -> Result<ExitCode, Error> {
    let fault = fault(arguments)?;
    fault.check("fault").map_err(|problem| Error::Usage(problem.message))?;
    let root = root(&arguments.run)?;
    let answer = control::inject(&root, &fault)
        .map_err(|e| Error::Usage(format!("{} is not going on: {e}", arguments.run.display())))?;
    if arguments.json {
        print::out(&(serde_json::to_string(&answer).expect("plain data") + "\n"))?;
    } else if answer.ok {
        print::out(&format!("{}\n", answer.message))?;
    }
    if answer.ok {
        Ok(ExitCode::SUCCESS)
    } else if arguments.json {
        Ok(ExitCode::from(2))
    } else {
        Err(Error::Usage(answer.message))
    }
}

/// The root of the run whose results are in `results`.
fn root(results: &Path) -> Result<PathBuf, Error> {
    let path = results.join("live.json");
    let text = std::fs::read_to_string(&path).map_err(|e| {
        Error::Usage(format!(
            "{} holds no run that is going on ({}: {e})",
            results.display(),
            path.display()
        ))
    })?;
    let group: Group = serde_json::from_str(&text)
        .map_err(|e| Error::Usage(format!("{}: {e}", path.display())))?;
    Ok(group.root)
}

fn fault(arguments: &InjectArguments) -> Result<Fault, Error> {
    let usage = Error::Usage;
    let mut fault = Fault::new(arguments.kind);
    if let Some(target) = &arguments.target {
        match (target.parse::<Service>(), Topic::by_name(target)) {
            (Ok(service), _) => fault.service = Some(service),
            (_, Some(_)) => {
                fault.topic = Some(TopicName::try_from(target.clone()).map_err(usage)?);
            }
            (Err(e), None) => return Err(usage(format!("{e}, or a topic such as radar/tracks"))),
        }
    }
    let quantity = |option: &str, e: String| usage(format!("--{option}: {e}"));
    if let Some(length) = arguments.length {
        fault.for_s = Some(Duration::try_from(length).map_err(|e| quantity("for", e))?);
    }
    if let Some(after) = arguments.after {
        let after = scenario::quantity::Time::try_from(after);
        fault.at_s = Some(after.map_err(|e| quantity("in", e))?);
    }
    fault.probability =
        Probability::try_from(arguments.probability).map_err(|e| quantity("probability", e))?;
    if let Some(ms) = arguments.delay_ms {
        fault.delay_ms = Some(DelayMs::try_from(ms).map_err(|e| quantity("delay-ms", e))?);
    }
    if let Some(ms) = arguments.jitter_ms {
        fault.jitter_ms = Some(DelayMs::try_from(ms).map_err(|e| quantity("jitter-ms", e))?);
    }
    if let Some(bits) = arguments.bits {
        fault.bits = Some(Count::try_from(bits).map_err(|e| quantity("bits", e))?);
    }
    if let Some(field) = &arguments.field {
        let field: Result<BiasedField, _> = serde_json::from_value(field.as_str().into());
        let expected = "expected gap_m, relative_speed_mps, speed_mps or end_s";
        fault.field = Some(field.map_err(|_| quantity("field", expected.into()))?);
    }
    if let Some(amount) = arguments.amount {
        fault.amount = Some(Shift::try_from(amount).map_err(|e| quantity("amount", e))?);
    }
    if let Some(core) = arguments.core {
        fault.core = Some(Core::try_from(core).map_err(|e| quantity("core", e))?);
    }
    if let Some(mib) = arguments.megabytes {
        fault.megabytes = Some(Megabytes::try_from(mib).map_err(|e| quantity("megabytes", e))?);
    }
    if let Some(times) = arguments.times {
        fault.times = Some(Count::try_from(times).map_err(|e| quantity("times", e))?);
    }
    Ok(fault)
}
