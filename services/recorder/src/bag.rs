//! `metadata.yaml` beside a recording: with it a run's directory is a rosbag2.

use crate::{FILE, ReadError};
use mcap::Summary;
use std::fmt::Write;
use std::path::Path;

const YAML: &str = "metadata.yaml";

/// Removes what an earlier recording left in the place of the one at `path`.
pub(crate) fn remove_beside(path: &Path) {
    if is_in_results(path) {
        // One that is not there need not be removed.
        let _ = std::fs::remove_file(path.with_file_name(YAML));
    }
}

/// Writes `metadata.yaml` beside the recording at `path`, if that has the name that it has in a run's results.
///
/// # Errors
/// If the file cannot be written.
pub fn write_beside(path: &Path, summary: &Summary) -> Result<(), ReadError> {
    if !is_in_results(path) {
        return Ok(());
    }
    let yaml = path.with_file_name(YAML);
    std::fs::write(&yaml, text(summary)).map_err(|reason| ReadError::File { path: yaml, reason })
}

fn is_in_results(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == FILE)
}

fn text(summary: &Summary) -> String {
    let statistics = summary.stats.clone().unwrap_or_default();
    let (messages, start_ns) = (statistics.message_count, statistics.message_start_time);
    let duration_ns = statistics.message_end_time.saturating_sub(start_ns);
    let mut channels: Vec<_> = summary.channels.values().collect();
    channels.sort_by_key(|channel| channel.id);
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {duration_ns}\n  starting_time:\n    nanoseconds_since_epoch: {start_ns}\n  \
         message_count: {messages}\n  topics_with_message_count:\n"
    );
    for channel in channels {
        let type_name = channel.schema.as_ref().map_or("", |schema| &schema.name);
        let count = statistics.channel_message_counts.get(&channel.id).unwrap_or(&0);
        write!(
            text,
            "    - topic_metadata:\n        name: {}\n        type: {type_name}\n        serialization_format: \
             cdr\n        offered_qos_profiles: \"\"\n      message_count: {count}\n",
            channel.topic
        )
        .expect("a string takes all");
    }
    write!(
        text,
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {FILE}\n  \
         files:\n    - path: {FILE}\n      starting_time:\n        nanoseconds_since_epoch: {start_ns}\n      \
         duration:\n        nanoseconds: {duration_ns}\n      message_count: {messages}\n"
    )
    .expect("a string takes all");
    text
}
