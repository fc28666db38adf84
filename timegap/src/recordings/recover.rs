//! `timegap recording recover`: repairs a truncated recording.

use super::{expect_another_file, is_being_recorded, open};
use clap::Args;
use recorder::{Recording, Summary, Survey};
use report::print;
use report::results::Document;
use serde_json::json;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, UsageError};

#[derive(Debug, Args)]
pub struct RecoverArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// File for the repaired recording [default: replaces the damaged one, which is kept as *.broken]
    #[arg(long, value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Print the result as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &RecoverArguments) -> Result<ExitCode, Error> {
    let broken = open(&arguments.run)?;
    if arguments.file.is_none() && is_being_recorded(broken.path()) {
        let place = broken.path().display();
        return Err(UsageError::at(place, "is still being recorded", "its run's end").into());
    }
    if let Some(out) = &arguments.file {
        expect_another_file(&broken, out)?;
    }
    let survey = broken.survey();
    let is_asked_for = arguments.file.is_some() || !survey.damage.is_empty();
    if survey.tally.messages() == 0 && is_asked_for {
        super::print_damage(&broken, &survey.damage);
        let place = broken.path().display();
        return Err(UsageError::at(place, "holds no complete message", "one to recover").into());
    }
    let damage: Vec<_> = survey.damage.iter().map(ToString::to_string).collect();
    let whole = damage.is_empty() && arguments.file.is_none();
    let (path, tally) = if whole {
        (broken.path().to_owned(), survey.tally)
    } else {
        rewrite(&broken, arguments.file.as_deref())?
    };
    let duration_s = survey.end_ns as f64 / 1e9;
    let whole_result = json!({
        "schema_version": 1,
        "path": path.to_string_lossy(),
        "recovered": !whole,
        "messages": tally.messages(),
        "lost_between": tally.lost(),
        "duration_s": duration_s,
        "damage": damage,
    });
    let verdict = match (whole, tally.lost()) {
        (true, _) => format!("{} is complete: nothing to recover", path.display()),
        (false, lost) => {
            let messages = print::counted(tally.messages(), "message");
            format!("recovered {messages} up to {duration_s:.2} s, {lost} lost between them")
        }
    };
    let broken = super::lines(&survey.damage, ToString::to_string);
    let mut facts: Vec<_> = broken.map(|line| ("broken", line)).collect();
    facts.push(("results", path.display().to_string()));
    let document = Document::new("recover", "Recovery", &whole_result);
    print::show(arguments.json, &document.facts("Recovery", facts).verdict(true, verdict))?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the repaired file beside the broken one, then moves it to its place.
fn rewrite(broken: &Recording, out: Option<&Path>) -> Result<(PathBuf, recorder::Tally), Error> {
    let place = out.unwrap_or_else(|| broken.path());
    let part = with_suffix(place, "part");
    let written = write(broken, &part).inspect_err(|_| {
        // A partial file is useless.
        let _ = std::fs::remove_file(&part);
    });
    let (recovered, summary) = written.map_err(Error::path("write", &part))?;
    if out.is_none() {
        let kept = with_suffix(place, "broken");
        std::fs::rename(place, &kept).map_err(Error::path("rename", place))?;
    }
    std::fs::rename(&part, place).map_err(Error::path("rename", &part))?;
    recorder::bag::write_beside(place, &summary)?;
    Ok((place.to_owned(), recovered.tally))
}

fn write(broken: &Recording, part: &Path) -> std::io::Result<(Survey, Summary)> {
    let file = File::create(part)?;
    let recovered = recorder::recover(broken, &file)?;
    file.sync_all()?;
    Ok(recovered)
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(suffix);
    name.into()
}
