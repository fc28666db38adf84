//! `timegap reproduce`: a paper's scenarios through the real processes, its published figures beside
//! ours.

mod cacc;
mod page;
mod predictive;
mod quadratic_bounded;
mod row;
mod six_mode;

use clap::{Args, ValueEnum};
use group::Error;
use group::{Drive, Ended, GroupOutcome};
use group::{GroupOptions, ScenarioOptions};
use report::RunPicture;
use report::chart::Plot;
use report::output::OutputDirectory;
use report::print;
use report::summary::Summary;
use std::path::PathBuf;

use indicatif::ProgressBar;
use page::page;
use row::{Row, Verdict};
use runtime::Mode;
use scenario::Scenario;
use serde::Serialize;
use std::process::ExitCode;
use std::time::Instant;

/// The papers, in the order of their names.
pub const PAPERS: [PaperName; 4] =
    [PaperName::SixMode, PaperName::QuadraticBounded, PaperName::Predictive, PaperName::Cacc];

#[derive(Debug, Serialize)]
struct Reproduction {
    schema_version: u32,
    ok: bool,
    papers: Vec<Paper>,
}

#[derive(Debug, Serialize)]
struct Paper {
    paper: &'static str,
    rows: Vec<Row>,
    #[serde(skip)]
    drives: Vec<(String, RunPicture)>,
    #[serde(skip)]
    pictures: Vec<Gallery>,
}

/// Pictures of a paper's own, below one heading.
struct Gallery {
    heading: String,
    plots: Vec<Plot>,
}

impl std::fmt::Debug for Gallery {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} pictures)", self.heading, self.plots.len())
    }
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Which paper; all when omitted
    #[arg(value_enum)]
    pub paper: Option<PaperName>,
    /// How each run's processes are started.
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

/// Runs the command.
pub fn run(arguments: &ReproduceArguments) -> Result<ExitCode, Error> {
    let output = OutputDirectory::create(arguments.out.as_deref(), "reproduce")?;
    let papers = arguments.paper.map_or(PAPERS.to_vec(), |paper| vec![paper]);
    let mut runner = Runner::new(&arguments.group, &papers, arguments.json);
    let mut done = Vec::new();
    for name in papers {
        let rows = match name {
            PaperName::SixMode => six_mode::reproduce(&mut runner)?,
            PaperName::QuadraticBounded => quadratic_bounded::reproduce(&mut runner)?,
            PaperName::Predictive => predictive::reproduce(&mut runner)?,
            PaperName::Cacc => cacc::reproduce(&mut runner)?,
        };
        let drives = std::mem::take(&mut runner.drives);
        let pictures = std::mem::take(&mut runner.pictures);
        done.push(Paper { paper: name.as_str(), rows, drives, pictures });
    }
    runner.bar.finish_and_clear();
    let ok = done.iter().flat_map(|paper| &paper.rows).all(|row| row.verdict() != Verdict::Outside);
    let reproduction = Reproduction { schema_version: 1, ok, papers: done };
    let json = serde_json::to_string_pretty(&reproduction).expect("plain data");
    let written = output.write("reproduce.json", (json.clone() + "\n").as_bytes());
    let written = written.and_then(|()| output.write(report::FILE, page(&reproduction).as_bytes()));
    if arguments.json {
        print::out(&(json + "\n"));
    } else {
        for paper in &reproduction.papers {
            print::out(&row::table(paper.paper, &paper.rows));
        }
        print::out(&format!("results: {}\n", output.path().display()));
        print::out(&format!("report:  {}\n", output.path().join(report::FILE).display()));
    }
    written?;
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A scenario that was driven in lockstep.
pub struct Driven {
    /// The scenario as it took effect.
    pub scenario: Scenario,
    /// What was heard of the drive.
    pub drive: Drive,
    /// Its summary.
    pub summary: Summary,
    /// Names of the law's figures in the drive.
    pub figure_names: Vec<&'static str>,
}

impl Driven {
    /// One of the law's figures over the control cycles: (time in s, value).
    pub fn figure(&self, name: &str) -> Vec<(f64, f64)> {
        let index = self.figure_names.iter().position(|figure| *figure == name);
        let index = index.expect("the law has a figure of this name");
        self.drive
            .steps
            .iter()
            .filter_map(|step| step.figures.map(|figures| (step.time_s, figures[index])))
            .collect()
    }
}

/// Drives scenarios in lockstep, one after the other, with a progress bar over all.
pub struct Runner<'a> {
    group: &'a GroupOptions,
    bar: ProgressBar,
    /// What was driven since somebody last looked, with what was set.
    drives: Vec<(String, RunPicture)>,
    /// What the paper wants to be seen beside them.
    pictures: Vec<Gallery>,
}

impl<'a> Runner<'a> {
    fn new(group: &'a GroupOptions, papers: &[PaperName], quiet: bool) -> Self {
        let runs = papers
            .iter()
            .map(|paper| match paper {
                PaperName::SixMode => six_mode::RUNS,
                PaperName::QuadraticBounded => quadratic_bounded::RUNS,
                PaperName::Predictive => predictive::RUNS,
                PaperName::Cacc => cacc::RUNS,
            })
            .sum();
        let bar = report::progress::count_bar(runs, quiet);
        Self { group, bar, drives: Vec::new(), pictures: Vec::new() }
    }

    /// Drives a built-in scenario with these keys set.
    pub fn drive(&mut self, name: &str, keys: &[&str]) -> Result<Driven, Error> {
        self.bar.set_message(name.to_owned());
        let options = ScenarioOptions {
            set: keys.iter().map(ToString::to_string).collect(),
            ..ScenarioOptions::default()
        };
        let scenario = group::open(name, &options)?;
        let begun = Instant::now();
        let group = group::drive(&scenario, Mode::Lockstep, self.group, None, &mut |_| {})?;
        orderly(&group)?;
        let summary = Summary::new(&scenario, Mode::Lockstep, &group, begun.elapsed());
        self.bar.inc(1);
        let what = format!("{name} · {}", scenario.controller.name.as_str());
        self.drives.push((what, RunPicture::of_drive(&scenario, &group.drive)));
        let figure_names = controller::laws::figure_names(&scenario);
        Ok(Driven { scenario, drive: group.drive, summary, figure_names })
    }
}

/// A run that did not reach its end has no figures.
fn orderly(group: &GroupOutcome) -> Result<(), Error> {
    match &group.ended {
        Ended::Orderly => Ok(()),
        Ended::Interrupted => Err(Error::Interrupted),
        Ended::Broken { service, how } => Err(Error::NotReady {
            service: *service,
            what: format!("ended before its time: {how}"),
        }),
    }
}
