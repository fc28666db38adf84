//! `timegap run`: one scenario, from the file to the results.

use crate::cli::{GroupOptions, RunArguments, ScenarioOptions};
use crate::error::Error;
use crate::group::{Ended, GroupOutcome, Launch, Moment, launch};
use crate::live::Live;
use crate::output::OutputDirectory;
use crate::report::{self, RunPicture};
use crate::summary::{self, Summary};
use crate::{print, trajectory};
use controller::laws;
use indicatif::{ProgressBar, ProgressStyle};
use shared::report::Outcome;
use shared::runtime::Mode;
use shared::scenario::{Overrides, Scenario};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Runs the command.
pub fn run(arguments: &RunArguments) -> Result<ExitCode, Error> {
    let begun = Instant::now();
    let scenario = open(&arguments.scenario, &arguments.scenario_options)?;
    let mode = arguments.mode.into();
    let output = OutputDirectory::create(arguments.out.as_deref(), scenario.name.as_str())?;
    output.write("scenario.toml", scenario.to_toml().as_bytes())?;

    let mut live = Live::open(&arguments.live, &scenario)?;
    let bar = progress_bar(&scenario, arguments.json || arguments.live.watch);
    let keep = Keep {
        live_file: Some(output.path().join("live.json")),
        recording: (!arguments.no_record).then(|| output.path().join(recorder::FILE)),
    };
    let result = drive(&scenario, mode, &arguments.group, Some(keep), &mut |moment| {
        bar.set_position(moment.time_ns.unsigned_abs() / 1_000_000);
        live.look(moment);
    });
    bar.finish_and_clear();
    let summary = result
        .as_ref()
        .map(|group| Summary::new(&scenario, mode, group, begun.elapsed()))
        .map_err(ToString::to_string);
    live.end(&match &summary {
        Ok(summary) => print::outcome(summary),
        Err(why) => why.clone(),
    });
    let group = result?;
    let summary = summary.expect("a run that succeeded has one");
    let json = serde_json::to_string_pretty(&summary).expect("a summary is plain data");
    let figures = laws::figure_names(&scenario);
    let written = output.write("summary.json", (json.clone() + "\n").as_bytes()).and_then(|()| {
        output.write("trajectory.csv", trajectory::csv(&group.drive, figures).as_bytes())
    });
    let written = written.and_then(|()| match mode {
        Mode::Realtime => output.write_histograms(&summary::histograms(&group)),
        // Simulated time has no latencies of its own.
        Mode::Lockstep => Ok(()),
    });
    let written = written.and_then(|()| {
        let page = report::run_page(&scenario, &summary, &RunPicture::of(&scenario, &group));
        output.write(report::FILE, page.as_bytes())
    });
    for (service, line) in &group.wrote {
        eprintln!("{service}: {line}");
    }
    if arguments.json {
        print::out(&(json + "\n"));
    } else {
        let results = format!("  {:<14} {}\n", "results", output.path().display());
        let page = format!("  {:<14} {}\n", "report", output.path().join(report::FILE).display());
        print::out(&(print::summary(&summary) + &results + &page));
    }
    // What was measured has been told before a full disk is.
    written?;
    Ok(exit_code(&group.ended, summary.outcome))
}

/// Opens a scenario and lays the options over it.
pub fn open(name: &str, options: &ScenarioOptions) -> Result<Scenario, Error> {
    open_with(name, options, "--set", &[])
}

/// The same with more keys set, on behalf of the option that errors shall name.
pub fn open_with(
    name: &str,
    options: &ScenarioOptions,
    option: &str,
    keys: &[String],
) -> Result<Scenario, Error> {
    let mut overrides = Overrides::new();
    if let Some(controller) = &options.controller {
        overrides.option("--controller", "controller.name", controller);
    }
    if let Some(seed) = &options.seed {
        overrides.option("--seed", "seed", seed);
    }
    if let Some(duration) = &options.duration {
        overrides.option("--duration", "duration_s", duration);
    }
    for argument in &options.set {
        overrides.set(argument).map_err(usage)?;
    }
    for argument in keys {
        overrides.set_by(option, argument).map_err(usage)?;
    }
    Scenario::open(name, &overrides, &laws::check).map_err(usage)
}

fn usage(error: impl std::fmt::Display) -> Error {
    Error::Usage(error.to_string())
}

/// What a run shows while it drives, and keeps of it.
#[derive(Debug, Default)]
pub struct Keep {
    /// Tells others how to join, for as long as the run drives.
    pub live_file: Option<PathBuf>,
    /// The recording.
    pub recording: Option<PathBuf>,
}

/// Drives a scenario through a process group. `watch` sees it go.
pub fn drive(
    scenario: &Scenario,
    mode: Mode,
    options: &GroupOptions,
    keep: Option<Keep>,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<GroupOutcome, Error> {
    let start_delay = match mode {
        Mode::Realtime => Duration::from_millis(scenario.runtime.start_delay_ms.value().into()),
        Mode::Lockstep => Duration::ZERO,
    };
    let keep = keep.unwrap_or_default();
    let launching = Launch {
        mode,
        scenario: scenario.clone(),
        programs: options.programs.iter().cloned().collect(),
        ready_timeout: Duration::from_secs_f64(options.ready_timeout),
        start_delay,
        live_file: keep.live_file,
        recording: keep.recording,
    };
    launch(launching, watch)
}

/// A bar on a terminal, for runs longer than a second; nothing elsewhere.
fn progress_bar(scenario: &Scenario, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() || scenario.duration_s.value() <= 1.0 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %")
        .expect("the template is valid");
    let bar = ProgressBar::new((scenario.duration_s.value() * 1e3) as u64).with_style(style);
    bar.set_message(scenario.name.as_str().to_owned());
    bar
}

/// A bar over so many runs on a terminal; nothing elsewhere.
pub fn count_bar(runs: usize, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} to go")
        .expect("the template is valid");
    ProgressBar::new(runs as u64).with_style(style)
}

/// Exit status of a run.
pub fn exit_code(ended: &Ended, outcome: Outcome) -> ExitCode {
    match (ended, outcome) {
        (Ended::Interrupted, _) => ExitCode::from(130),
        (_, Outcome::Completed) => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}
