//! `metadata.yaml` beside a recording: with it a run's directory is a rosbag2.

use crate::{FILE, ReadError, Recording};
use std::fmt::Write;
use std::path::Path;

/// Name of the file.
const YAML: &str = "metadata.yaml";

/// Removes what an earlier recording left in the place of the one at `path`.
pub(crate) fn remove_beside(path: &Path) {
    if is_in_results(path) {
        // One that is not there need not be removed.
        let _ = std::fs::remove_file(path.with_file_name(YAML));
    }
}

/// Writes `metadata.yaml` beside the recording at `path`, if that has the name that it has in a run's
/// results.
///
/// # Errors
/// If the recording cannot be read or the file not written.
pub fn write_beside(path: &Path) -> Result<(), ReadError> {
    if !is_in_results(path) {
        return Ok(());
    }
    let yaml = path.with_file_name(YAML);
    let text = text(&Recording::open(path)?);
    std::fs::write(&yaml, text).map_err(|reason| ReadError::File { path: yaml, reason })
}

fn is_in_results(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == FILE)
}

fn text(recording: &Recording) -> String {
    let topics = recording.topics();
    let messages: u64 = topics.iter().map(|topic| topic.messages).sum();
    let [start_ns, end_ns] = recording.log_times_ns();
    let duration_ns = end_ns - start_ns;
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {duration_ns}\n  starting_time:\n    nanoseconds_since_epoch: {start_ns}\n  \
         message_count: {messages}\n  topics_with_message_count:\n"
    );
    for topic in topics {
        write!(
            text,
            "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: \
             cdr\n        offered_qos_profiles: \"\"\n      message_count: {}\n",
            topic.name, topic.type_name, topic.messages
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
