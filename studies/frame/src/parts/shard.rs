//! The part of a study that a command does: by its option, or by the environment of an array job.

use std::fmt::Display;
use std::num::NonZeroU32;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use supervise::UsageError;

/// A part of a study's runs: those whose number leaves `index - 1` when divided by `count`.
///
/// ```
/// let shard: frame::parts::Shard = "2/3".parse().unwrap();
/// assert_eq!((0..9).filter(|run| shard.holds(*run)).collect::<Vec<_>>(), [1, 4, 7]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    /// Number of the shard, from 1.
    pub index: u32,
    /// Number of shards.
    pub count: u32,
}

impl Shard {
    /// True if the run of this number is in the shard.
    pub fn holds(self, run: usize) -> bool {
        run % self.count as usize == (self.index - 1) as usize
    }
}

/// True if a run belongs to a part. Nothing else decides it.
pub(crate) fn holds(shard: Option<Shard>, run: usize) -> bool {
    shard.is_none_or(|shard| shard.holds(run))
}

fn no_shard(text: &str) -> UsageError {
    let expected = "I/N with I from 1 to N, auto or auto/N";
    UsageError::at(format_args!("`{text}`"), "not a shard", expected)
}

impl FromStr for Shard {
    type Err = UsageError;

    fn from_str(text: &str) -> Result<Self, UsageError> {
        let parts = text.split_once('/').and_then(|(index, count)| {
            Some(Self { index: index.parse().ok()?, count: count.parse().ok()? })
        });
        parts.filter(|shard| (1..=shard.count).contains(&shard.index)).ok_or_else(|| no_shard(text))
    }
}

impl TryFrom<String> for Shard {
    type Error = UsageError;

    fn try_from(text: String) -> Result<Self, UsageError> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        format!("{}/{}", shard.index, shard.count)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShardChoice {
    /// `I/N`.
    Given(Shard),
    /// `auto`, or `auto/N`: the environment gives the index, and N is the number of parts.
    Auto(Option<NonZeroU32>),
}

impl FromStr for ShardChoice {
    type Err = UsageError;

    fn from_str(text: &str) -> Result<Self, UsageError> {
        match text.strip_prefix("auto") {
            Some("") => Ok(Self::Auto(None)),
            Some(count) => {
                let count = count.strip_prefix('/').and_then(|count| count.parse().ok());
                count.map(|count| Self::Auto(Some(count))).ok_or_else(|| no_shard(text))
            }
            None => text.parse().map(Self::Given),
        }
    }
}

/// A refusal of `auto`.
fn refuse(why: impl Display, expected: &str) -> UsageError {
    UsageError::at("--shard auto", why, expected)
}

impl ShardChoice {
    /// The shard, by this process's environment where it is asked for.
    pub fn resolve(self) -> Result<Shard, UsageError> {
        self.resolve_in(&|name| std::env::var(name).ok())
    }

    fn resolve_in(self, variable: Variables<'_>) -> Result<Shard, UsageError> {
        let count = match self {
            Self::Given(shard) => return Ok(shard),
            Self::Auto(count) => count.map(NonZeroU32::get),
        };
        let kubernetes = ["JOB_COMPLETION_INDEX", "JOB_COMPLETIONS"];
        let aws = ["AWS_BATCH_JOB_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_SIZE"];
        let found = slurm(variable)
            .or_else(|| indexed(variable, "Kubernetes (JOB_COMPLETION_INDEX)", kubernetes))
            .or_else(|| indexed(variable, "AWS Batch (AWS_BATCH_JOB_ARRAY_INDEX)", aws));
        let found = found.transpose()?.ok_or_else(|| {
            let why = "this is not an array job: neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX nor \
                       AWS_BATCH_JOB_ARRAY_INDEX is set";
            refuse(why, "--shard I/N")
        })?;
        let Task { engine, index, count: told } = found;
        let count = count.or(told).ok_or_else(|| {
            let why = format_args!("{engine} does not give the number of its tasks");
            refuse(why, "--shard auto/N")
        })?;
        if index >= u64::from(count) {
            let why = format_args!("{engine} names task {index} of {count}");
            return Err(refuse(why, "a task below their number, counted from 0"));
        }
        let index = u32::try_from(index).expect("below the count") + 1;
        Ok(Shard { index, count })
    }
}

/// A task of an array job.
struct Task {
    engine: &'static str,
    index: u64,
    /// Tasks of the job, where the engine gives the number.
    count: Option<u32>,
}

type Variables<'a> = &'a dyn Fn(&str) -> Option<String>;

fn number(variable: Variables<'_>, name: &'static str) -> Option<Result<u64, UsageError>> {
    let text = variable(name)?;
    let number = text.trim().parse::<u64>();
    Some(number.map_err(|_| refuse(format_args!("{name} = `{text}`"), "a whole number")))
}

fn tasks(count: u64) -> Result<u32, UsageError> {
    u32::try_from(count).map_err(|_| refuse(format_args!("{count} tasks"), "fewer of them"))
}

/// `sbatch --array=MIN-MAX[:STEP]`. A job of single tasks (`--array=1,5`) has no even steps.
fn slurm(variable: Variables<'_>) -> Option<Result<Task, UsageError>> {
    let id = number(variable, "SLURM_ARRAY_TASK_ID")?;
    let engine = "Slurm (SLURM_ARRAY_TASK_ID)";
    let bounds = || {
        let id = id?;
        let or = |name, otherwise| number(variable, name).unwrap_or(Ok(otherwise));
        let least = or("SLURM_ARRAY_TASK_MIN", 0)?;
        let step = or("SLURM_ARRAY_TASK_STEP", 1)?.max(1);
        let most = number(variable, "SLURM_ARRAY_TASK_MAX").transpose()?;
        let told = number(variable, "SLURM_ARRAY_TASK_COUNT").transpose()?;
        let spanned = most.map(|most| most.saturating_sub(least) / step + 1);
        if let (Some(told), Some(spanned)) = (told, spanned)
            && told != spanned
        {
            let why =
                format_args!("the array's {told} tasks from {least} on are not at even steps");
            return Err(refuse(why, "--array=A-B, or --shard I/N"));
        }
        if id < least || (id - least) % step != 0 {
            let why = format_args!("SLURM_ARRAY_TASK_ID = {id}");
            return Err(refuse(why, "one of the array's tasks"));
        }
        let count = told.or(spanned).map(tasks).transpose()?;
        Ok(Task { engine, index: (id - least) / step, count })
    };
    Some(bounds())
}

/// Tasks from 0 on, by the variables of the index and of their number. Kubernetes (`completionMode: Indexed`) has the
/// number only where the manifest puts it.
fn indexed(
    variable: Variables<'_>,
    engine: &'static str,
    [index, count]: [&'static str; 2],
) -> Option<Result<Task, UsageError>> {
    let index = number(variable, index)?;
    let count = number(variable, count).transpose();
    Some(index.and_then(|index| {
        let count = count?.map(tasks).transpose()?;
        Ok(Task { engine, index, count })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn auto(choice: &str, variables: &[(&str, &str)]) -> Result<String, String> {
        let choice: ShardChoice = choice.parse().expect("a choice");
        let find = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        choice.resolve_in(&find).map(String::from).map_err(|error| error.to_string())
    }

    #[test]
    fn shards_part_the_runs() {
        let shards: Vec<Shard> =
            ["1/3", "2/3", "3/3"].iter().map(|text| text.parse().expect("a shard")).collect();
        for run in 0..20 {
            assert_eq!(shards.iter().filter(|shard| shard.holds(run)).count(), 1);
        }
        for text in ["0/3", "4/3", "1", "a/b", "1/0", "-1/3", "auto/0", "auto/", "automatic"] {
            assert!(text.parse::<ShardChoice>().is_err(), "{text}");
        }
    }

    #[test]
    fn slurm_tasks_count_from_any_number() {
        let of = |id, min, max, count| {
            let variables = [
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_MIN", min),
                ("SLURM_ARRAY_TASK_MAX", max),
                ("SLURM_ARRAY_TASK_COUNT", count),
            ];
            auto("auto", &variables)
        };
        assert_eq!(of("0", "0", "7", "8"), Ok("1/8".into()));
        assert_eq!(of("8", "1", "8", "8"), Ok("8/8".into()));
        assert_eq!(of("12", "10", "13", "4"), Ok("3/4".into()));
        assert!(of("5", "1", "5", "2").is_err_and(|said| said.contains("even steps")));
        assert!(of("x", "1", "5", "5").is_err_and(|said| said.contains("SLURM_ARRAY_TASK_ID")));
        assert!(of("0", "1", "5", "5").is_err());
        let step = [
            ("SLURM_ARRAY_TASK_ID", "4"),
            ("SLURM_ARRAY_TASK_MIN", "0"),
            ("SLURM_ARRAY_TASK_MAX", "6"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(auto("auto", &step), Ok("3/4".into()));
    }

    #[test]
    fn other_engines_count_from_zero() {
        let kubernetes = [("JOB_COMPLETION_INDEX", "2")];
        assert_eq!(auto("auto/8", &kubernetes), Ok("3/8".into()));
        assert!(auto("auto", &kubernetes).is_err_and(|said| said.contains("auto/N")));
        assert!(auto("auto/2", &kubernetes).is_err_and(|said| said.contains("task 2")));
        let told = [("JOB_COMPLETION_INDEX", "2"), ("JOB_COMPLETIONS", "5")];
        assert_eq!(auto("auto", &told), Ok("3/5".into()));
        let aws = [("AWS_BATCH_JOB_ARRAY_INDEX", "0"), ("AWS_BATCH_JOB_ARRAY_SIZE", "4")];
        assert_eq!(auto("auto", &aws), Ok("1/4".into()));
    }

    #[test]
    fn outside_an_array_job_auto_is_refused_in_one_sentence() {
        let said = auto("auto", &[]).expect_err("no array job");
        assert!(said.contains("not an array job") && !said.contains('\n'), "{said}");
        assert_eq!(auto("2/5", &[]), Ok("2/5".into()));
    }
}
