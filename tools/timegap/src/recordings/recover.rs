//! `timegap recover`: a recording that was cut off, made whole.

use super::{count, open};
use clap::Args;
use group::Error;
use group::is_alive;
use recorder::Recording;
use report::print;
use runtime::Group;
use serde_json::json;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `recover`.
#[derive(Debug, Args)]
pub struct RecoverArguments {
    /// A run's directory of results, or a recording
    pub run: PathBuf,
    /// Where to write the whole recording [default: in the broken one's place, which is kept beside
    /// it as *.broken]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print the result as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &RecoverArguments) -> Result<ExitCode, Error> {
    let broken = open(&arguments.run)?;
    if arguments.out.is_none() && is_being_recorded(broken.path()) {
        let path = broken.path().display();
        return Err(Error::Usage(format!(
            "{path} is still being recorded: wait for its run's end"
        )));
    }
    let damage: Vec<_> = broken.damage().iter().map(ToString::to_string).collect();
    let whole = damage.is_empty() && arguments.out.is_none();
    let (path, tally) = if whole {
        (broken.path().to_owned(), super::tally(&broken))
    } else {
        rewrite(&broken, arguments.out.as_deref())?
    };
    if arguments.json {
        let result = json!({
            "schema_version": 1,
            "path": path,
            "recovered": !whole,
            "messages": tally.messages(),
            "lost_between": tally.lost(),
            "duration_s": broken.end_ns() as f64 / 1e9,
            "damage": damage,
        });
        print::out(&(serde_json::to_string_pretty(&result).expect("plain data") + "\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    if whole {
        print::out(&format!("{} is whole: nothing to recover\n", path.display()))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = format!(
        "recovered {} up to {:.2} s, {} lost between them\n",
        count(tally.messages(), "message"),
        broken.end_ns() as f64 / 1e9,
        tally.lost()
    );
    damage.iter().for_each(|damage| text.push_str(&format!("  broken         {damage}\n")));
    text.push_str(&format!("  results        {}\n", path.display()));
    print::out(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// True if the run whose recording this is goes on.
fn is_being_recorded(path: &Path) -> bool {
    let live = std::fs::read_to_string(path.with_file_name("live.json")).unwrap_or_default();
    serde_json::from_str(&live).is_ok_and(|group: Group| is_alive(&group.root))
}

/// Writes the whole file beside the broken one, then puts it in its place or where it was asked for.
fn rewrite(broken: &Recording, out: Option<&Path>) -> Result<(PathBuf, recorder::Tally), Error> {
    let place = out.unwrap_or_else(|| broken.path());
    let error = |action, path: &Path| {
        let path = path.to_owned();
        move |reason| Error::Path { action, path, reason }
    };
    let part = with_suffix(place, "part");
    let file = File::create(&part).map_err(error("write", &part))?;
    let recovered = recorder::recover(broken, &file)
        .map_err(|e| error("write", &part)(std::io::Error::other(e)))?;
    file.sync_all().map_err(error("write", &part))?;
    if out.is_none() {
        let kept = with_suffix(place, "broken");
        std::fs::rename(place, &kept).map_err(error("rename", place))?;
    }
    std::fs::rename(&part, place).map_err(error("rename", &part))?;
    Ok((place.to_owned(), recovered.tally))
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(suffix);
    name.into()
}
