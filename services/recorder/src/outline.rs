//! Outline of a file, made from record to record without unpacking. It is enough for `info`, and shows whether a
//! recorder of ours wrote the file: in chunks, in the order of their log times.

use crate::definitions::Definitions;
use crate::source::{Source, Spot, Window};
use crate::{Damage, Metadata, Tally};
use bags::mcap::{self as format, Fields, MAGIC, Malformed, Statistics, opcode};
use std::io;

/// Longest record that is read whole, but for chunks, bytes.
const LONGEST_RECORD: u64 = 16 << 20;
/// Bytes of a footer's body: two offsets and a checksum.
const FOOTER_LENGTH: u64 = 20;
/// Bytes of a summary that are checked at once.
const BLOCK: u64 = 64 << 10;
#[derive(Debug, Default)]
pub(crate) struct Outline {
    pub(crate) metadata: Option<Metadata>,
    pub(crate) tally: Option<Tally>,
    pub(crate) statistics: Option<Statistics>,
    pub(crate) definitions: Definitions,
    /// End of the data section.
    pub(crate) end: u64,
    pub(crate) damage: Vec<Damage>,
    /// Mark of another writer.
    pub(crate) foreign: Option<&'static str>,
    /// Latest log time so far.
    last: u64,
}

/// Content of the summary behind the messages, used once its checksum is known to be right.
#[derive(Debug, Default)]
struct Summary {
    /// First byte behind the data section.
    from: u64,
    definitions: Definitions,
    statistics: Option<Statistics>,
    damage: Vec<Damage>,
}

impl Outline {
    /// Goes through `source`, whose magic bytes were checked.
    pub(crate) fn of(source: &Source) -> io::Result<Self> {
        let mut outline = Self::default();
        let mut window = Window::of_heads(source);
        let mut at = MAGIC.len() as u64;
        let mut summary: Option<Summary> = None;
        let mut footed = false;
        while let Some(spot) = window.spot(at)? {
            at = spot.end();
            match &mut summary {
                None if spot.opcode == opcode::DATA_END => {
                    summary = Some(Summary { from: at, ..Summary::default() });
                }
                None => {
                    outline.data(&mut window, spot)?;
                    outline.end = at;
                }
                Some(summary) if spot.opcode == opcode::FOOTER => {
                    footed = true;
                    outline.take_summary(&mut window, std::mem::take(summary), spot)?;
                    break;
                }
                Some(summary) => summary.take(&mut window, spot)?,
            }
        }
        let left = source.length() - at;
        let magic = MAGIC.len() as u64;
        let is_whole = footed && left >= magic && window.bytes(at, MAGIC.len())? == MAGIC;
        match left.checked_sub(magic).filter(|_| is_whole) {
            Some(0) => {}
            Some(_) => outline.foreign = Some("it goes on behind its end"),
            None => outline.damage.push(Damage::CutOff { bytes: left }),
        }
        Ok(outline)
    }

    fn data(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        match spot.opcode {
            opcode::CHUNK if spot.length >= 16 => {
                let mut times = Fields(window.bytes(spot.body(), 16)?);
                let (first, last) = (times.u64().unwrap_or(0), times.u64().unwrap_or(0));
                // A chunk of definitions has no times.
                if last > 0 && first < self.last {
                    self.foreign = Some("its chunks are not in the order of their log times");
                }
                self.last = self.last.max(last);
            }
            opcode::MESSAGE => self.foreign = Some("it has messages outside of chunks"),
            opcode::METADATA | opcode::SCHEMA | opcode::CHANNEL => self.small(window, spot)?,
            _ => {}
        }
        Ok(())
    }

    /// Uses a summary whose checksum is right; a damaged one is left out, since the data section has its content.
    fn take_summary(
        &mut self,
        window: &mut Window,
        summary: Summary,
        footer: Spot,
    ) -> io::Result<()> {
        if !summary.is_intact(window, footer)? {
            self.damage.push(Damage::Summary { bytes: footer.end() - summary.from });
            return Ok(());
        }
        self.definitions.extend(summary.definitions);
        self.statistics = summary.statistics;
        self.damage.extend(summary.damage);
        Ok(())
    }

    /// Takes a record of the data section that is not a message.
    fn small(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        match small_body(window, spot)? {
            Ok(body) if self.take(spot.opcode, body).is_err() => self.damage.push(misfit(spot)),
            Ok(_) => {}
            Err(damage) => self.damage.push(damage),
        }
        Ok(())
    }

    fn take(&mut self, opcode: u8, body: &[u8]) -> Result<(), Malformed> {
        if opcode == opcode::METADATA {
            let (name, map) = format::metadata(body)?;
            self.metadata = self.metadata.take().or_else(|| Metadata::of_record(name, &map));
            self.tally = self.tally.take().or_else(|| Tally::of_record(name, &map));
            return Ok(());
        }
        self.definitions.take(opcode, body)
    }
}

impl Summary {
    fn take(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        match spot.opcode {
            opcode::CHANNEL | opcode::SCHEMA | opcode::STATISTICS => {}
            _ => return Ok(()),
        }
        let taken = match small_body(window, spot)? {
            Ok(body) if spot.opcode == opcode::STATISTICS => {
                format::statistics(body).map(|statistics| self.statistics = Some(statistics))
            }
            Ok(body) => self.definitions.take(spot.opcode, body),
            Err(damage) => {
                self.damage.push(damage);
                Ok(())
            }
        };
        if taken.is_err() {
            self.damage.push(misfit(spot));
        }
        Ok(())
    }

    /// Compares the checksum in the footer with the summary's bytes; a writer may leave it out (0).
    fn is_intact(&self, window: &mut Window, footer: Spot) -> io::Result<bool> {
        if footer.length != FOOTER_LENGTH {
            return Ok(false);
        }
        let body = window.bytes(footer.body(), FOOTER_LENGTH as usize)?;
        let expected = u32::from_le_bytes(body[16..].try_into().expect("four bytes"));
        if expected == 0 {
            return Ok(true);
        }
        // It covers the footer up to itself.
        let (mut at, to) = (self.from, footer.end() - 4);
        let mut checksum = crc32fast::Hasher::new();
        while at < to {
            let count = (to - at).min(BLOCK);
            checksum.update(window.bytes(at, count as usize)?);
            at += count;
        }
        Ok(checksum.finalize() == expected)
    }
}

/// Body of a record that is read whole.
fn small_body(window: &mut Window, spot: Spot) -> io::Result<Result<&[u8], Damage>> {
    if spot.length > LONGEST_RECORD {
        let reason = format!("a record of its kind may have {LONGEST_RECORD} bytes");
        return Ok(Err(Damage::Chunk { offset: spot.at, bytes: spot.length, reason }));
    }
    let length = usize::try_from(spot.length).expect("checked above");
    window.bytes(spot.body(), length).map(Ok)
}

fn misfit(spot: Spot) -> Damage {
    let reason = "its lengths do not fit".into();
    Damage::Chunk { offset: spot.at, bytes: spot.length, reason }
}
