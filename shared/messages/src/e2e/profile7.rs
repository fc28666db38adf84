//! AUTOSAR E2E profile 7: a 20-byte header, all big-endian, at the very start of the message.
//!
//! | bytes | field |
//! | --- | --- |
//! | 0..8 | CRC-64 (ECMA-182, reflected, "CRC-64/XZ") over all other bytes that are protected |
//! | 8..12 | length: bytes that are protected, from the start of the message |
//! | 12..16 | counter |
//! | 16..20 | data ID |
//!
//! The bytes in use are protected ([`Layout::bytes_in_use`](crate::Layout::bytes_in_use)). A large message
//! that ends with a counted array is not protected behind its last valid element. No reader uses that part.
//!
//! The CRC is computed by carry-less multiplications if the processor has them, else from tables. It is exact,
//! so that its bits do not depend on the method.
//!
//! ```
//! use messages::e2e::profile7::{Corrupted, check, protect};
//!
//! let mut message = [0; 32];
//! protect(&mut message, 0x1_0001, 7);
//! assert_eq!(check(&message, 0x1_0001), Ok(7));
//! assert_eq!(check(&message, 0x2_0001), Err(Corrupted::DataId));
//! message[30] = 1;
//! assert_eq!(check(&message, 0x1_0001), Err(Corrupted::Crc));
//! ```

use crate::layout::declare::*;
use bytemuck::{Pod, Zeroable};
use crc_fast::{CrcAlgorithm, checksum};

const _: () = assert!(size_of::<Protection>() == 24);

layout! {
    /// The protection of a message, first in its header; filled in by the port that sends it.
    #[derive(Default, Eq)]
    pub struct Protection "timegap_msgs/msg/Protection" {
        /// CRC-64, big-endian.
        pub crc: [u8; 8],
        /// Bytes of the message that are protected, big-endian.
        pub length: [u8; 4],
        /// Counter, big-endian.
        pub counter: [u8; 4],
        /// Data ID: topic and sender, big-endian.
        pub data_id: [u8; 4],
        /// Zero.
        pub reserved: [u8; 4],
    }
}

/// Reason why a message is not the one that was sent on this channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corrupted {
    /// Its CRC is wrong.
    Crc,
    /// Its length is not the stated one.
    Length,
    /// It belongs to another channel.
    DataId,
}

fn crc(bytes: &[u8]) -> u64 {
    checksum(CrcAlgorithm::Crc64Xz, bytes)
}

/// Fills in the protection at the start of `message`.
///
/// # Panics
/// If the message is shorter than its protection.
pub fn protect(message: &mut [u8], data_id: u32, counter: u32) {
    let length = u32::try_from(message.len()).expect("messages are short");
    message[8..12].copy_from_slice(&length.to_be_bytes());
    message[12..16].copy_from_slice(&counter.to_be_bytes());
    message[16..20].copy_from_slice(&data_id.to_be_bytes());
    let crc = crc(&message[8..]);
    message[..8].copy_from_slice(&crc.to_be_bytes());
}

/// Checks the protection of `message`; returns its counter.
///
/// # Errors
/// The first that is wrong, in the order of the standard: CRC, length, data ID.
pub fn check(message: &[u8], data_id: u32) -> Result<u32, Corrupted> {
    if message.len() < 20 {
        return Err(Corrupted::Length);
    }
    let word = |at: usize| {
        u32::from_be_bytes([message[at], message[at + 1], message[at + 2], message[at + 3]])
    };
    if message[..8] != crc(&message[8..]).to_be_bytes() {
        return Err(Corrupted::Crc);
    }
    if word(8) as usize != message.len() {
        return Err(Corrupted::Length);
    }
    if word(16) != data_id {
        return Err(Corrupted::DataId);
    }
    Ok(word(12))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bytes_of_an_independent_implementation() {
        // PyPI autosar-e2e 1.0.0, e2e_p07_protect of 24 zeros with this data ID. The system tests give it
        // real messages.
        let mut message = [0; 24];
        protect(&mut message, 0x0a0b_0c0d, 0);
        assert_eq!(message[..8], 0x1fb2_e737_fced_bcd9_u64.to_be_bytes());
        assert_eq!(message[8..], [0, 0, 0, 24, 0, 0, 0, 0, 10, 11, 12, 13, 0, 0, 0, 0]);
        assert_eq!(check(&message, 0x0a0b_0c0d), Ok(0));
        assert_eq!(check(&message, 0x0a0b_0c0e), Err(Corrupted::DataId));
        assert_eq!(check(&message[..19], 0x0a0b_0c0d), Err(Corrupted::Length));
    }

    #[test]
    fn another_number_of_elements_than_was_protected_is_found() {
        let mut message = [7; 64];
        protect(&mut message[..40], 0x0a0b_0c0d, 9);
        assert_eq!(check(&message[..40], 0x0a0b_0c0d), Ok(9));
        assert_eq!(check(&message[..48], 0x0a0b_0c0d), Err(Corrupted::Crc));
    }

    #[test]
    fn the_shortest_message_is_its_protection() {
        let mut message = [0; 20];
        protect(&mut message, 3, 9);
        assert_eq!(check(&message, 3), Ok(9));
        assert_eq!(check(&message[..19], 3), Err(Corrupted::Length));
    }

    proptest! {
        #[test]
        fn the_fast_crc_equals_the_one_from_tables(
            message in prop::collection::vec(any::<u8>(), 0..9000), from in 0_usize..64,
        ) {
            use crc::{CRC_64_XZ, Crc};
            let tables = Crc::<u64>::new(&CRC_64_XZ);
            // At any alignment.
            let bytes = &message[from.min(message.len())..];
            prop_assert_eq!(crc(bytes), tables.checksum(bytes));
        }

        #[test]
        fn a_protected_message_is_intact(
            mut message in prop::collection::vec(any::<u8>(), 24..2000),
            id in any::<u32>(), counter in any::<u32>(),
        ) {
            protect(&mut message, id, counter);
            prop_assert_eq!(check(&message, id), Ok(counter));
        }

        #[test]
        fn up_to_three_flipped_bits_are_always_seen(
            mut message in prop::collection::vec(any::<u8>(), 24..1500),
            flips in prop::collection::vec(any::<prop::sample::Index>(), 1..=3),
        ) {
            protect(&mut message, 9, 1);
            let intact = message.clone();
            for flip in &flips {
                let bit = flip.index(8 * message.len());
                message[bit / 8] ^= 1 << (bit % 8);
            }
            prop_assume!(message != intact);
            prop_assert!(check(&message, 9).is_err());
        }

        #[test]
        fn random_bytes_are_refused(message in prop::collection::vec(any::<u8>(), 0..100)) {
            prop_assert!(check(&message, 1).is_err());
        }
    }
}
