//! Figures that the on-board unit reports at its end.

use its::signed::Envelope;
use runtime::statistics::Percentiles;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Frames on air, by what the on-board unit made of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObuReport {
    pub frames: u64,
    /// Frames that arrived and for which a batch had no room.
    pub left_out: u64,
    pub verdicts: BTreeMap<String, u64>,
    /// Signed frames with the signers that they name; absent without such a frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signed: Option<Signers>,
    pub cams_sent: u64,
    /// Time from the sending of a frame to its arrival.
    pub air_us: Option<Percentiles>,
    /// Time to decode and check a frame, on the wall clock in both modes.
    pub decode_us: Option<Percentiles>,
    /// Age of the oldest timing of the signals ahead when it is handed on.
    pub age_us: Option<Percentiles>,
}

/// Most signers that are named: stations change their certificates while they drive.
const MOST_SIGNERS: usize = 16;

/// Signed frames and their signers, since the process began. Nothing verifies a signature.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signers {
    pub frames: u64,
    /// Signers that the envelopes name, at most 16: the digest of a certificate, `certificates` or `self`.
    pub not_verified: BTreeMap<String, Signed>,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signed {
    pub frames: u64,
    /// Generation time of the last one, ms since the Unix epoch, UTC.
    pub generated_ms: Option<i64>,
}

impl Signers {
    pub fn note(&mut self, envelope: &Envelope) {
        self.frames += 1;
        let name = envelope.signer.to_string();
        if self.not_verified.len() < MOST_SIGNERS || self.not_verified.contains_key(&name) {
            let signed = self.not_verified.entry(name).or_default();
            signed.frames += 1;
            signed.generated_ms = envelope.generated_ms.or(signed.generated_ms);
        }
    }
}
