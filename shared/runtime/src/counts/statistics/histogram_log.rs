//! Histograms as a file that the tools of the HdrHistogram family read.

use super::Latencies;
use hdrhistogram::serialization::V2DeflateSerializer;
use hdrhistogram::serialization::interval_log::{IntervalLogWriterBuilder, Tag};
use std::io;
use std::time::Duration;

/// Writes an interval log with one line for each tagged histogram of durations in ns. A line's
/// largest value is shown in µs. Tags must not hold commas, spaces or line ends.
///
/// # Errors
/// If `out` fails or a tag is not one.
pub fn write<'a>(
    out: &mut impl io::Write,
    histograms: impl IntoIterator<Item = (&'a str, &'a Latencies)>,
) -> io::Result<()> {
    // Readers other than Rust's accept only the compressed form.
    let mut serializer = V2DeflateSerializer::new();
    let mut log = IntervalLogWriterBuilder::new()
        .add_comment("durations in nanoseconds; interval maxima in microseconds")
        .with_max_value_divisor(1e3)
        .begin_log_with(out, &mut serializer)?;
    for (tag, latencies) in histograms {
        let tag = Tag::new(tag).ok_or(io::ErrorKind::InvalidInput)?;
        log.write_histogram(&latencies.histogram(), Duration::ZERO, Duration::ZERO, Some(tag))
            .map_err(|e| io::Error::other(format!("{e:?}")))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdrhistogram::Histogram;
    use hdrhistogram::serialization::Deserializer;
    use hdrhistogram::serialization::interval_log::{IntervalLogIterator, LogEntry};

    #[test]
    fn written_records_are_read_back() {
        let mut latencies = Latencies::default();
        (1..=1000).for_each(|us| latencies.record_ns(us * 1000));
        let mut file = Vec::new();
        write(&mut file, [("futex:fifo:same_core", &latencies)]).expect("memory takes all");
        let text = String::from_utf8(file.clone()).expect("a text file");
        let read = IntervalLogIterator::new(&file).find_map(|entry| match entry {
            Ok(LogEntry::Interval(interval)) => Some(interval),
            _ => None,
        });
        let read = read.unwrap_or_else(|| panic!("no interval in {text}"));
        assert_eq!(read.tag().map(|tag| tag.as_str()), Some("futex:fifo:same_core"));
        // The payload is base64; its last field is all that matters here.
        assert!(read.encoded_histogram().starts_with("HISTFAAA"), "V2, compressed: {text}");
        let bytes = base64(read.encoded_histogram());
        let back: Histogram<u64> =
            Deserializer::new().deserialize(&mut bytes.as_slice()).expect("our own");
        assert_eq!(back, latencies.histogram());
        assert!(write(&mut Vec::new(), [("no tag", &latencies)]).is_err());
    }

    fn base64(text: &str) -> Vec<u8> {
        let digit = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let digits: Vec<_> = text.bytes().filter(|c| *c != b'=').map(digit).collect();
        let joined = |four: &[u8]| {
            let word = four.iter().fold(0_u32, |word, digit| word << 6 | u32::from(*digit));
            let word = word << (6 * (4 - four.len()));
            word.to_be_bytes()[1..four.len()].to_vec()
        };
        digits.chunks(4).flat_map(joined).collect()
    }
}
