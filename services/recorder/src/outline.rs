//! What a file holds, found by going from record to record without unpacking any: enough for `info`,
//! and to read the messages in the order of their log times afterwards.

use crate::definitions::Definitions;
use crate::format::{self, Fields, MAGIC, Malformed, Statistics, opcode};
use crate::source::{Source, Spot, Window};
use crate::{Damage, Metadata, Tally};
use std::io;

/// Longest record that is read whole, but for chunks, bytes.
const LONGEST_RECORD: u64 = 16 << 20;
/// Most segments that are kept apart; beyond them the file's own order is taken.
const MOST_SEGMENTS: usize = 1 << 20;

/// A part of the file in which log times do not go back from one chunk to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Segment {
    pub(crate) from: u64,
    pub(crate) to: u64,
    /// Earliest and latest log time in it.
    pub(crate) first: u64,
    pub(crate) last: u64,
}

/// A file in outline.
#[derive(Debug, Default)]
pub(crate) struct Outline {
    pub(crate) metadata: Option<Metadata>,
    pub(crate) tally: Option<Tally>,
    pub(crate) statistics: Option<Statistics>,
    pub(crate) definitions: Definitions,
    pub(crate) segments: Vec<Segment>,
    pub(crate) damage: Vec<Damage>,
    /// True if the summary behind the messages repeats the definitions.
    pub(crate) has_summary: bool,
}

impl Outline {
    /// Goes through `source`, whose magic bytes were checked.
    pub(crate) fn of(source: &Source) -> io::Result<Self> {
        let mut outline = Self::default();
        let mut window = Window::of_heads(source);
        let mut at = MAGIC.len() as u64;
        let (mut ended, mut footed) = (false, false);
        while let Some(spot) = window.spot(at)? {
            if spot.opcode == opcode::DATA_END {
                ended = true;
            } else if ended {
                outline.summary(&mut window, spot)?;
            } else {
                outline.data(&mut window, spot)?;
            }
            at = spot.end();
            footed = ended && spot.opcode == opcode::FOOTER;
            if footed {
                break;
            }
        }
        let left = source.length() - at;
        let magic = MAGIC.len() as u64;
        let is_whole = footed && left >= magic && window.bytes(at, MAGIC.len())? == MAGIC;
        match left.checked_sub(magic).filter(|_| is_whole) {
            Some(0) => {}
            Some(bytes) => outline.damage.push(Damage::BehindEnd { bytes }),
            None => outline.damage.push(Damage::CutOff { bytes: left }),
        }
        Ok(outline)
    }

    fn data(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        match spot.opcode {
            opcode::CHUNK if spot.length >= 16 => {
                let mut times = Fields(window.bytes(spot.body(), 16)?);
                let (first, last) = (times.u64(), times.u64());
                self.extend(spot, first.unwrap_or(0), last.unwrap_or(0));
            }
            opcode::CHUNK => self.extend(spot, 0, 0),
            opcode::MESSAGE if spot.length >= format::MESSAGE_HEAD as u64 => {
                let body = window.bytes(spot.body(), format::MESSAGE_HEAD)?;
                let log_time = format::message(body).expect("a whole head").0.log_time;
                self.extend(spot, log_time, log_time);
            }
            opcode::METADATA | opcode::SCHEMA | opcode::CHANNEL => self.small(window, spot)?,
            _ => {}
        }
        Ok(())
    }

    fn summary(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        match spot.opcode {
            opcode::CHANNEL => self.has_summary = true,
            opcode::SCHEMA | opcode::STATISTICS => {}
            _ => return Ok(()),
        }
        self.small(window, spot)
    }

    /// Takes a record that is not a message.
    fn small(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        let damage = |reason: String| Damage::Chunk { offset: spot.at, bytes: spot.length, reason };
        if spot.length > LONGEST_RECORD {
            let most = LONGEST_RECORD;
            self.damage.push(damage(format!("a record of its kind may have {most} bytes")));
            return Ok(());
        }
        let length = usize::try_from(spot.length).expect("checked above");
        if self.take(spot.opcode, window.bytes(spot.body(), length)?).is_err() {
            self.damage.push(damage("its lengths do not fit".into()));
        }
        Ok(())
    }

    fn take(&mut self, opcode: u8, body: &[u8]) -> Result<(), Malformed> {
        match opcode {
            opcode::METADATA => {
                let (name, map) = format::metadata(body)?;
                self.metadata = self.metadata.take().or_else(|| Metadata::of_record(name, &map));
                self.tally = self.tally.take().or_else(|| Tally::of_record(name, &map));
            }
            opcode::SCHEMA => self.definitions.schema(&format::schema(body)?),
            opcode::CHANNEL => self.definitions.channel(&format::channel(body)?),
            _ => self.statistics = Some(format::statistics(body)?),
        }
        Ok(())
    }

    /// Adds a chunk or a message that has log times from `first` to `last`.
    fn extend(&mut self, spot: Spot, first: u64, last: u64) {
        let end = spot.end();
        let last = last.max(first);
        let is_full = self.segments.len() >= MOST_SEGMENTS;
        match self.segments.last_mut() {
            // An empty chunk has no times; it may hold definitions.
            Some(segment) if first >= segment.last || last == 0 || is_full => {
                segment.to = end;
                segment.last = segment.last.max(last);
            }
            _ => self.segments.push(Segment { from: spot.at, to: end, first, last }),
        }
    }
}
