//! Comparison with a decoder that is generated from the standards' ASN.1.

use super::read;
use super::uper::dice::Dice;
use super::uper::{Fields, Number, Reader};
use crate::{Message, MessageKind, PayloadError};

mod theirs;

/// Drawn messages of each kind.
const DRAWN: u64 = 4_000;
/// Falsified versions of each message.
const FALSIFIED: u64 = 4;
/// Messages of each kind in `tests/vectors.txt`, and their longest, bytes.
const KEPT: usize = 12;
const LONGEST_KEPT: usize = 90;

/// A reader that notes content of a later version, which the oracle misreads.
struct Noting<'a> {
    reader: Reader<'a>,
    extended: bool,
}

impl Fields for Noting<'_> {
    fn whole(&mut self, number: Number, given: i64) -> Result<i64, PayloadError> {
        self.reader.whole(number, given)
    }

    fn pass(&mut self, bits: u64) -> Result<(), PayloadError> {
        self.reader.pass(bits)
    }

    fn extended(&mut self) -> Result<bool, PayloadError> {
        let extended = self.reader.extended()?;
        self.extended |= extended;
        Ok(extended)
    }
}

/// Messages of a kind, as bytes and as this crate's decoder reads them.
fn drawn(kind: MessageKind) -> impl Iterator<Item = (Vec<u8>, Result<Message, PayloadError>)> {
    (0..DRAWN).map(move |seed| {
        let mut dice = Dice::new(seed);
        let message = read(kind, &mut dice);
        (dice.finish(), message)
    })
}

/// The bytes with some bits changed, and sometimes truncated.
fn falsified(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut dice = Dice::new(seed);
    let mut bytes = bytes.to_vec();
    for _ in 0..=dice.below(4) {
        let bit = dice.below(8 * bytes.len() as u64);
        bytes[(bit / 8) as usize] ^= 1 << (bit % 8);
    }
    if dice.below(4) == 0 {
        bytes.truncate(dice.below(bytes.len() as u64) as usize);
    }
    bytes
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn messages_of_all_parts_are_the_standards() {
    for kind in MessageKind::ALL {
        let mut read_by_both = 0;
        for (bytes, message) in drawn(kind) {
            let theirs = theirs::decode(kind, &bytes);
            match (message, theirs) {
                (Ok(ours), Ok(theirs)) => {
                    assert_eq!(ours, theirs, "{kind:?} {}", hex(&bytes));
                    read_by_both += 1;
                }
                (Err(_), Err(_)) => {}
                (ours, theirs) => panic!("{kind:?} {}\n{ours:?}\n{theirs:?}", hex(&bytes)),
            }
            assert_eq!(
                read(kind, &mut Reader::new(&bytes)).ok(),
                theirs::decode(kind, &bytes).ok()
            );
        }
        assert!(read_by_both > DRAWN / 3, "{kind:?}: {read_by_both}");
    }
}

#[test]
fn falsified_messages_are_read_alike_or_refused_by_both() {
    for kind in MessageKind::ALL {
        let (mut read_by_both, mut refused_by_both, mut extended) = (0, 0, 0);
        for (number, (bytes, _)) in drawn(kind).enumerate() {
            for version in 0..FALSIFIED {
                let bytes = falsified(&bytes, FALSIFIED * number as u64 + version);
                let mut reader = Noting { reader: Reader::new(&bytes), extended: false };
                let ours = read(kind, &mut reader);
                match (ours, theirs::decode(kind, &bytes)) {
                    _ if reader.extended => extended += 1,
                    (Ok(ours), Ok(theirs)) => {
                        assert_eq!(ours, theirs, "{kind:?} {}", hex(&bytes));
                        read_by_both += 1;
                    }
                    (Err(_), Err(_)) => refused_by_both += 1,
                    (ours, theirs) => panic!("{kind:?} {}\n{ours:?}\n{theirs:?}", hex(&bytes)),
                }
            }
        }
        println!("{kind:?}: {read_by_both} read, {refused_by_both} refused, {extended} extended");
        assert!(read_by_both > 100 && refused_by_both > 100, "{kind:?}");
    }
}

/// Messages after their header, each followed by a falsified version.
fn kept(kind: MessageKind) -> impl Iterator<Item = Vec<u8>> {
    let whole =
        drawn(kind).filter(|(bytes, message)| bytes.len() <= LONGEST_KEPT && message.is_ok());
    let both = whole.take(KEPT).zip(0..).flat_map(move |((bytes, _), seed)| {
        [bytes.clone(), falsified(&bytes, seed)].map(|mut bytes| {
            bytes.splice(..bytes.len().min(2), [2, kind.message_id()]);
            bytes
        })
    });
    both.filter(move |bytes| {
        let mut reader = Noting { reader: Reader::new(bytes), extended: false };
        // Ignore the result here: the oracle decides.
        let _ = read(kind, &mut reader);
        !reader.extended
    })
}

/// Records the oracle's results for an ordinary test.
#[test]
fn the_recorded_messages_are_the_oracles() {
    let mut recorded = String::new();
    for kind in MessageKind::ALL {
        for bytes in kept(kind) {
            let read = theirs::decode(kind, &bytes).ok();
            recorded += &format!("{} {} {read:?}\n", kind.port(), hex(&bytes));
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/vectors.txt");
    if std::env::var_os("TIMEGAP_RECORD").is_some() {
        std::fs::write(path, &recorded).expect("the source is writable");
    }
    let kept = std::fs::read_to_string(path).unwrap_or_default();
    assert!(kept == recorded, "run this test with TIMEGAP_RECORD=1, and review the changes");
}
