//! Outline of a file, made from record to record without unpacking. It is enough for `info`, and shows whether a
//! recorder of ours wrote the file: in chunks, in the order of their log times.

use crate::source::{Source, Spot, Window};
use crate::{Damage, Metadata, Tally};
use bags::mcap::{MAGIC, Malformed, Record, opcode, parse};
use mcap::records::Statistics;
use std::io;

/// Longest record that is read whole, but for chunks, bytes.
const LONGEST_RECORD: u64 = 16 << 20;
/// Bytes of a footer's body: two offsets and a checksum.
const FOOTER_LENGTH: u64 = 20;
/// Bytes of a summary that are checked at once.
const BLOCK: u64 = 64 << 10;

#[derive(Clone, Debug, Default)]
pub(crate) struct Outline {
    pub(crate) metadata: Option<Metadata>,
    pub(crate) tally: Option<Tally>,
    pub(crate) statistics: Option<Statistics>,
    /// End of the data section.
    pub(crate) end: u64,
    pub(crate) damage: Vec<Damage>,
    /// Mark of another writer.
    pub(crate) foreign: Option<&'static str>,
    /// Latest log time so far.
    last: u64,
    /// A topic was outside of chunks.
    loose: bool,
}

impl Outline {
    /// Goes through `source`, whose magic bytes were checked.
    pub(crate) fn of(source: &Source) -> io::Result<Self> {
        let mut outline = Self::default();
        let mut window = Window::of_heads(source);
        let mut at = MAGIC.len() as u64;
        // The first byte of the summary behind the messages.
        let mut summary = None;
        let (mut footed, mut intact) = (false, false);
        while let Some(spot) = window.spot(at)? {
            at = spot.end();
            match (summary, spot.opcode) {
                (None, opcode::DATA_END) => summary = Some(at),
                (None, _) => {
                    outline.data(&mut window, spot)?;
                    outline.end = at;
                }
                (Some(from), opcode::FOOTER) => {
                    (footed, intact) = (true, is_intact(&mut window, from, spot)?);
                    if !intact {
                        outline.damage.push(Damage::Summary { bytes: spot.end() - from });
                    }
                    break;
                }
                (Some(_), opcode::STATISTICS) => outline.small(&mut window, spot)?,
                _ => {}
            }
        }
        // The messages have the content of a damaged summary.
        outline.statistics.take_if(|_| !intact);
        let left = source.length - at;
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
                let [first, last]: [u64; 2] =
                    bytemuck::pod_read_unaligned(window.bytes(spot.body(), 16)?);
                // A chunk of definitions has no times.
                if last > 0 && first < self.last {
                    self.foreign = Some("its chunks are not in the order of their log times");
                }
                self.last = self.last.max(last);
                if self.loose {
                    self.foreign = Some("it has topics outside of chunks");
                }
            }
            opcode::MESSAGE => self.foreign = Some("it has messages outside of chunks"),
            // Behind the last chunk they are the summary of a file whose end of data is damaged.
            opcode::SCHEMA | opcode::CHANNEL => self.loose = true,
            opcode::METADATA => self.small(window, spot)?,
            _ => {}
        }
        Ok(())
    }

    /// Takes a map or the statistics.
    fn small(&mut self, window: &mut Window, spot: Spot) -> io::Result<()> {
        let damage = |reason| Damage::Chunk { offset: spot.at, bytes: spot.length, reason };
        if spot.length > LONGEST_RECORD {
            let reason = format!("a record of its kind may have {LONGEST_RECORD} bytes");
            self.damage.push(damage(reason));
            return Ok(());
        }
        let length = usize::try_from(spot.length).expect("checked above");
        if self.take(spot.opcode, window.bytes(spot.body(), length)?).is_err() {
            self.damage.push(damage("its lengths do not fit".into()));
        }
        Ok(())
    }

    fn take(&mut self, opcode: u8, body: &[u8]) -> Result<(), Malformed> {
        match parse(opcode, body)? {
            Record::Metadata(record) => {
                let (name, map) = (&*record.name, &record.metadata);
                self.metadata = self.metadata.take().or_else(|| Metadata::of_record(name, map));
                self.tally = self.tally.take().or_else(|| Tally::of_record(name, map));
            }
            Record::Statistics(statistics) => self.statistics = Some(statistics),
            _ => {}
        }
        Ok(())
    }
}

/// Compares the checksum in the footer with the summary's bytes; a writer may leave it out (0).
fn is_intact(window: &mut Window, from: u64, footer: Spot) -> io::Result<bool> {
    if footer.length != FOOTER_LENGTH {
        return Ok(false);
    }
    let body = window.bytes(footer.body(), FOOTER_LENGTH as usize)?;
    let expected = u32::from_le_bytes(body[16..].try_into().expect("four bytes"));
    if expected == 0 {
        return Ok(true);
    }
    // It covers the footer up to itself.
    let (mut at, to) = (from, footer.end() - 4);
    let mut checksum = crc32fast::Hasher::new();
    while at < to {
        let count = (to - at).min(BLOCK);
        checksum.update(window.bytes(at, count as usize)?);
        at += count;
    }
    Ok(checksum.finalize() == expected)
}
