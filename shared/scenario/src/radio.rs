//! `[v2x]`, the radio: how the signals reach the vehicle, and what goes wrong on the way.

use serde::{Deserialize, Serialize};
use std::path::Path;

use super::carrier::{CarrierAddress, CarrierAddressError};
use super::quantity::{
    DelayMs, DriftPpm, Duration, Heading, IntersectionId, Latitude, Longitude, MapShift, OffsetMs,
    Probability, Shift, StationId, Time,
};
use super::refusal::{Explained, read_from};
use super::schema::{Schema, Shape};

/// UTC of run time 0 in simulated time, ns since 1970: noon of 2026-06-01.
pub const SIMULATED_START_NS: i64 = 1_780_315_200_000_000_000;

/// Way of the signals to the vehicle: `direct`, `frames`, or the address of a carrier.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Radio {
    /// As structs, from the roadside unit to the controller.
    #[default]
    Direct,
    /// As frames (SPATEM, MAPEM), which an on-board unit decodes and checks.
    Frames,
    /// As frames of roadside units on other hosts, or of a capture.
    Carrier(CarrierAddress),
}

/// Text that is not a radio.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RadioError {
    /// It is neither a known word nor an address.
    #[error("{}, expected {RADIOS}", self.message())]
    Unknown(String),
    /// The address of a carrier is wrong.
    #[error(transparent)]
    Address(CarrierAddressError),
}

/// The radios in words.
const RADIOS: &str =
    "one of direct, frames, udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5, pcap:FILE";

impl Explained for RadioError {
    fn message(&self) -> String {
        match self {
            Self::Unknown(text) => format!("`{text}` is not a radio"),
            Self::Address(error) => error.message(),
        }
    }

    fn expected(&self) -> String {
        match self {
            Self::Unknown(_) => RADIOS.to_owned(),
            Self::Address(error) => error.expected(),
        }
    }
}

impl Schema for Radio {
    fn shape() -> Shape {
        String::shape()
    }

    fn expected() -> Option<String> {
        Some(RADIOS.to_owned())
    }
}

read_from!(Radio, String);

impl Radio {
    /// True for structs.
    #[must_use]
    pub fn is_direct(&self) -> bool {
        *self == Self::Direct
    }

    /// Carrier of the frames that are not simulated in the run.
    #[must_use]
    pub fn carrier(&self) -> Option<&CarrierAddress> {
        match self {
            Self::Direct | Self::Frames => None,
            Self::Carrier(address) => Some(address),
        }
    }

    /// True if frames come from other hosts as they are sent.
    #[must_use]
    pub fn is_live(&self) -> bool {
        self.carrier().is_some_and(CarrierAddress::is_live)
    }

    /// Settles where a carrier's file is: beside the scenario's own file, in `directory`.
    pub(super) fn place(&mut self, directory: Option<&Path>) {
        let Self::Carrier(address) = self else { return };
        let here = std::env::current_dir().unwrap_or_default();
        address.place(&directory.map_or_else(|| here.clone(), |own| here.join(own)));
    }
}

impl TryFrom<String> for Radio {
    type Error = RadioError;

    fn try_from(text: String) -> Result<Self, RadioError> {
        match text.as_str() {
            "direct" => Ok(Self::Direct),
            "frames" => Ok(Self::Frames),
            other => other.parse().map(Self::Carrier).map_err(|error| match error {
                CarrierAddressError::Scheme(text) => RadioError::Unknown(text),
                error => RadioError::Address(error),
            }),
        }
    }
}

impl From<Radio> for String {
    fn from(radio: Radio) -> Self {
        match radio {
            Radio::Direct => "direct".to_owned(),
            Radio::Frames => "frames".to_owned(),
            Radio::Carrier(address) => address.to_string(),
        }
    }
}

/// Place of the road on the Earth, with frames. A capture's maps fit a road that begins and leads as theirs does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Origin {
    /// Latitude of the road's beginning, degrees, north positive.
    pub latitude_deg: Latitude,
    /// Longitude of the road's beginning, degrees, east positive.
    pub longitude_deg: Longitude,
    /// Direction of the straight road, degrees clockwise from north.
    pub heading_deg: Heading,
}

impl Default for Origin {
    fn default() -> Self {
        Self {
            latitude_deg: Latitude::of(48.7),
            longitude_deg: Longitude::of(9.1),
            heading_deg: Heading::of(90.0),
        }
    }
}

impl Origin {
    /// Latitude and longitude as messages have them, 1e-7 degrees.
    #[must_use]
    pub fn steps(&self) -> (i32, i32) {
        let steps = |degrees: f64| (degrees * 1e7).round() as i32;
        (steps(self.latitude_deg.value()), steps(self.longitude_deg.value()))
    }

    /// True if it is the usual one.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// The air between the roadside units and the vehicle. Without any key nothing is lost, late or wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Time when the imperfections begin, s.
    pub from_s: Time,
    /// Duration of them, s. Absent: to the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<Duration>,
    /// Probability that a frame is lost.
    pub loss_probability: Probability,
    /// Burst loss (Gilbert-Elliott): probability that the channel turns bad, asked for each frame.
    pub burst_begin_probability: Probability,
    /// Probability that a bad channel turns good again, asked for each frame.
    pub burst_end_probability: Probability,
    /// Probability that a frame is lost while the channel is bad.
    pub burst_loss_probability: Probability,
    /// Time that every frame takes, ms. Frames reach the on-board unit in batches, once in `v2x.period_ms`.
    pub delay_ms: DelayMs,
    /// Longest time on top of that, ms, drawn for each frame.
    pub jitter_ms: DelayMs,
    /// Probability that a frame is held back behind the next ones.
    pub reorder_probability: Probability,
    /// Time for which such a frame is held back, ms.
    pub reorder_ms: DelayMs,
    /// Probability that a frame arrives twice.
    pub duplicate_probability: Probability,
    /// Probability that a frame is cut off.
    pub truncate_probability: Probability,
    /// Probability that one bit of a frame is wrong, as after a checksum that matched by chance.
    pub bit_flip_probability: Probability,
    /// Probability that an earlier frame is sent again with a new one.
    pub replay_probability: Probability,
    /// Age of the frame that is sent again, s.
    pub replay_age_s: Time,
}

impl Default for Air {
    fn default() -> Self {
        let never = Probability::of(0.0);
        Self {
            from_s: Time::of(0.0),
            for_s: None,
            loss_probability: never,
            burst_begin_probability: never,
            burst_end_probability: Probability::of(0.1),
            burst_loss_probability: Probability::of(1.0),
            delay_ms: DelayMs::of(0),
            jitter_ms: DelayMs::of(0),
            reorder_probability: never,
            reorder_ms: DelayMs::of(200),
            duplicate_probability: never,
            truncate_probability: never,
            bit_flip_probability: never,
            replay_probability: never,
            replay_age_s: Time::of(10.0),
        }
    }
}

impl Air {
    /// True if nothing is wrong.
    #[must_use]
    pub fn is_right(&self) -> bool {
        *self == Self::default()
    }
}

/// Errors of the roadside units. Without any key they make no errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Unit {
    /// Time by which their clocks are ahead at the start, ms.
    pub clock_offset_ms: OffsetMs,
    /// Rate by which their clocks are too fast, millionths.
    pub clock_drift_ppm: DriftPpm,
    /// Time when a second unit begins to announce that every signal is green, s. Absent: never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradicted_from_s: Option<Time>,
    /// Time when the map is replaced by another revision, s; absent: never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_changes_at_s: Option<Time>,
    /// The intersection whose map is replaced; absent: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_changes_of: Option<IntersectionId>,
    /// Distance by which stop lines are farther along the road in that revision, m.
    pub map_shift_m: MapShift,
    /// Time when the countdowns begin to be wrong, s; absent: never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub countdown_wrong_from_s: Option<Time>,
    /// Jump of the announced ends then, s.
    pub countdown_jump_s: Shift,
    /// Slide of the ends from then on, s in each s. 1 is a countdown that stands still.
    pub countdown_slide: Shift,
    /// Largest random error of the ends from then on, s, drawn anew for each message and signal.
    pub countdown_jitter_s: Time,
    /// Ends from then on are announced in steps of this time, s. The next step is announced when the one before has
    /// come, as of a light that vehicles extend. 0: without steps.
    pub countdown_extends_s: Time,
    /// From then on the present phase is announced alone.
    pub countdown_lacks_next: bool,
}

impl Default for Unit {
    fn default() -> Self {
        Self {
            clock_offset_ms: OffsetMs::of(0),
            clock_drift_ppm: DriftPpm::of(0),
            contradicted_from_s: None,
            map_changes_at_s: None,
            map_changes_of: None,
            map_shift_m: MapShift::of(0.0),
            countdown_wrong_from_s: None,
            countdown_jump_s: Shift::of(0.0),
            countdown_slide: Shift::of(0.0),
            countdown_jitter_s: Time::of(0.0),
            countdown_extends_s: Time::of(0.0),
            countdown_lacks_next: false,
        }
    }
}

impl Unit {
    /// True if nothing is wrong.
    #[must_use]
    pub fn is_right(&self) -> bool {
        *self == Self::default()
    }
}

/// The vehicle's on-board unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Obu {
    /// Its station id.
    pub station_id: StationId,
    /// Largest age of a used frame's content by its own stamp, ms. The same is the limit for stamps in the future.
    pub max_age_ms: DelayMs,
    /// Time by which the vehicle's clock is ahead at the start, ms.
    pub clock_offset_ms: OffsetMs,
    /// Rate by which it is too fast, millionths.
    pub clock_drift_ppm: DriftPpm,
    /// Largest difference between the clocks of senders and vehicle, ms. Greens and yellows are taken to end so much
    /// earlier than announced, reds so much later.
    pub clock_tolerance_ms: DelayMs,
}

impl Default for Obu {
    fn default() -> Self {
        Self {
            station_id: StationId::of(4711),
            max_age_ms: DelayMs::of(500),
            clock_offset_ms: OffsetMs::of(0),
            clock_drift_ppm: DriftPpm::of(0),
            clock_tolerance_ms: DelayMs::of(250),
        }
    }
}

impl Obu {
    /// True if it is as usual.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use crate::Scenario;

    fn read(keys: &str) -> Result<Scenario, String> {
        let text = format!("schema_version = 1\nname = \"radio\"\n[v2x]\n{keys}\n");
        Scenario::parse("radio", &text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_radio_reads_back_and_a_file_is_found_from_anywhere() {
        for radio in ["direct", "frames", "udp://239.255.3.1:5520?interface=eth0", "zenoh"] {
            let scenario = read(&format!("radio = \"{radio}\"")).expect(radio);
            assert_eq!(String::from(scenario.v2x.radio.clone()), radio);
            assert_eq!(Scenario::parse("again", &scenario.to_toml()), Ok(scenario));
        }
        let capture = read("radio = \"pcap:drive.pcap\"").expect("an address");
        let here = std::env::current_dir().expect("it is there");
        let expected = format!("pcap:{}", here.join("drive.pcap").display());
        assert_eq!(String::from(capture.v2x.radio), expected);
    }

    #[test]
    fn useless_options_of_a_carrier_are_refused() {
        for (keys, said) in [
            ("radio = \"morse\"", "`morse` is not a radio"),
            ("radio = \"udp://nowhere\"", "is not an IP address with a port"),
            ("poll_ms = 10", "v2x.poll_ms has no effect"),
            ("radio = \"zenoh\"\npoll_ms = 15", "v2x.poll_ms = 15 is not a whole multiple"),
            ("radio = \"zenoh\"\nair.delay_ms = 20", "the air is simulated"),
            ("radio = \"zenoh\"\n[supervision]\nstandby = [\"v2x-sim\"]", "cannot have the radio"),
        ] {
            let error = read(keys).expect_err(keys);
            assert!(error.contains(said), "{keys}: {error}");
        }
    }
}
