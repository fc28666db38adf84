//! Reading a recording, also one that was cut off.

use crate::counter::Counter;
use crate::definitions::Definitions;
use crate::outline::Outline;
use crate::records::{Records, Timed};
use crate::source::{Source, Window};
use crate::{Damage, FILE, Metadata, ReadError, Tally, TopicTally};
use bags::mcap::MAGIC;
use messages::{Message, TOPICS, Topic};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Content of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Messages by topic, and those that are missing.
    pub tally: Tally,
    /// Latest log time of any message, ns of run time.
    pub end_ns: i64,
    pub damage: Vec<Damage>,
}

/// A recording: its own description, and a way to its messages.
#[derive(Clone, Debug)]
pub struct Recording {
    path: PathBuf,
    source: Source,
    metadata: Metadata,
    outline: Outline,
    definitions: Definitions,
}

impl Recording {
    /// Opens the recording at `path`, a file or a run's directory of results.
    ///
    /// # Errors
    /// If the file is missing, another program wrote it, or it has other messages. One that ends too early is accepted: see
    /// [`Recording::damage`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let path = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
        if std::fs::metadata(&path).is_ok_and(|file| !file.is_file()) {
            let reason = "it is not a regular file".into();
            return Err(ReadError::Foreign { path, reason });
        }
        let failed = |reason| ReadError::File { path: path.clone(), reason };
        let source = File::open(&path).and_then(Source::of_file).map_err(failed)?;
        Self::of_source(path, source)
    }

    /// Opens a recording whose file, known as `path`, has these contents.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn of_bytes(path: PathBuf, file: &[u8]) -> Result<Self, ReadError> {
        Self::of_source(path, Source::of_bytes(file))
    }

    fn of_source(path: PathBuf, source: Source) -> Result<Self, ReadError> {
        let place = path.clone();
        let foreign =
            |reason: &str| ReadError::Foreign { path: place.clone(), reason: reason.into() };
        let failed = |reason| ReadError::File { path: place.clone(), reason };
        match source.length {
            0 => return Err(foreign("it is empty")),
            length if length < MAGIC.len() as u64 => return Err(foreign("it is not an MCAP file")),
            _ => {}
        }
        if Window::new(&source).bytes(0, MAGIC.len()).map_err(failed)? != MAGIC {
            return Err(foreign("it is not an MCAP file"));
        }
        let mut outline = Outline::of(&source).map_err(failed)?;
        let metadata = outline.metadata.take();
        let metadata = metadata.ok_or_else(|| foreign("it does not say of which run"))?;
        if let Some(reason) = outline.foreign {
            return Err(foreign(reason));
        }
        let definitions = Definitions::default();
        let mut recording = Self { path, source, metadata, outline, definitions };
        // The topics come before the first message.
        let mut records = recording.records();
        records.next();
        recording.definitions = records.definitions;
        if let Some(topic) = recording.definitions.other_layout() {
            let topic = topic.to_owned();
            let Self { path, metadata, .. } = recording;
            return Err(ReadError::Layout { path, program: metadata.program, topic });
        }
        if let Some((name, topic)) = recording.definitions.renamed() {
            let (name, ours) = (name.escape_debug(), topic.name());
            return Err(foreign(&format!("the type of its `{name}` is that of `{ours}`")));
        }
        Ok(recording)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn file_bytes(&self) -> u64 {
        self.source.length
    }

    /// Facts about the run.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Counts of the recorder; `None` if it never ended the recording.
    pub fn tally(&self) -> Option<&Tally> {
        self.outline.tally.as_ref()
    }

    /// Damage of the file's outline. Damage inside its chunks shows when the messages are read ([`Records::damage`]).
    pub fn damage(&self) -> &[Damage] {
        &self.outline.damage
    }

    /// All messages, in the order of their log times.
    pub fn records(&self) -> Records {
        self.records_of(&TOPICS)
    }

    /// All messages of `topics`, in the order of their log times.
    pub fn records_of(&self, topics: &[Topic]) -> Records {
        let data = MAGIC.len() as u64..self.outline.end;
        Records::new(&self.source, self.metadata.epoch_ns, &self.definitions, data, topics)
    }

    pub fn messages<T: Message>(&self) -> impl Iterator<Item = Timed<T>> + use<T> {
        self.records_of(&[T::TOPIC]).filter_map(|record| {
            let message = record.message()?;
            Some(Timed { log_time_ns: record.log_time_ns, message })
        })
    }

    /// The file's own statistics, without reading any message; `None` in a file without an end or without statistics.
    pub fn statistics(&self) -> Option<Survey> {
        let (tally, statistics) = (self.outline.tally.as_ref()?, self.outline.statistics.as_ref()?);
        let counts = self.definitions.counts(&statistics.channel_message_counts)?;
        let topics = counts.into_iter().map(|(topic, messages)| {
            let counted = tally.topics.get(topic.name()).copied().unwrap_or_default();
            // Others may have taken messages out of the file since.
            let lost = counted.messages.saturating_add(counted.lost).saturating_sub(messages);
            (topic.name().to_owned(), TopicTally { messages, lost })
        });
        let end_ns = match statistics.message_count {
            0 => 0,
            _ => {
                i64::try_from(statistics.message_end_time).unwrap_or(i64::MAX)
                    - self.metadata.epoch_ns
            }
        };
        Some(Survey {
            tally: Tally { topics: topics.collect(), incarnations: tally.incarnations.clone() },
            end_ns,
            damage: self.outline.damage.clone(),
        })
    }

    /// Reads every message: what is there, gaps in the sequence numbers, and what cannot be read.
    pub fn survey(&self) -> Survey {
        let mut counter = Counter::default();
        let mut end_ns = 0;
        let mut records = self.records();
        for record in records.by_ref() {
            counter.count(record.topic, record.bytes());
            end_ns = end_ns.max(record.log_time_ns);
        }
        let damage = [&self.outline.damage[..], records.damage()].concat();
        Survey { tally: counter.tally(), end_ns, damage }
    }
}
