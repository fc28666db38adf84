//! Studies in parts: split over machines, interrupted and continued, joined again.
//!
//! ```text
//! --shard I/N ─► part.json (the study)                ┐
//!                runs.jsonl (a line per finished run) ┴─► merge ─► the result of one machine
//!                begun.jsonl (values of long runs that are not finished)
//! ```
//!
//! A part's directory holds the arguments of its study. So a merge can name missing runs with the command that
//! completes them, and refuses parts of different studies.

mod begun;
mod journal;
mod merge;
mod part;
mod records;
mod shard;

pub(crate) use begun::{Begun, SoFar};
pub(crate) use merge::{Merged, name_incomplete};
pub(crate) use part::{Part, PartFile, resume_command};
pub use records::Records;
pub(crate) use shard::holds;
pub use shard::{Shard, ShardChoice};

use serde::{Deserialize, Serialize};

use crate::drives::Drive;

/// Name of the file that describes a part.
pub const FILE: &str = "part.json";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line<T> {
    pub run: usize,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drives: Vec<Drive>,
    pub result: T,
}
