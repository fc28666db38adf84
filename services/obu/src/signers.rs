//! Signers of frames, as the envelopes name them. Nothing verifies a signature here.

use its::signed::Envelope;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most signers that are named: stations change their certificates while they drive.
const MOST_SIGNERS: usize = 16;

/// Signed frames and their signers, since the process began.
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
    /// Counts a frame.
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
