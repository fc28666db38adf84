//! `[v2x]`, the radio: how the signals reach the vehicle, and what goes wrong on the way.

use scenario_derive::tables;
use serde::{Deserialize, Serialize};
use std::path::Path;

use crate::carrier::CarrierAddress;
use crate::quantity::{
    DelayMs, DriftPpm, Duration, Heading, IntersectionId, Latitude, Longitude, MapShift, OffsetMs,
    Probability, Shift, StationId, Time,
};

/// UTC of run time 0 in simulated time, ns since 1970: noon of 2026-06-01.
pub const SIMULATED_START_NS: i64 = 1_780_315_200_000_000_000;

/// Way of the signals to the vehicle: `direct`, `frames`, or the address of a carrier.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Radio {
    /// As structs, from the roadside unit to the controller.
    #[default]
    Direct,
    /// As frames (SPATEM, MAPEM), which an on-board unit decodes and checks.
    Frames,
    /// As frames of roadside units on other hosts, or of a capture.
    Carrier(CarrierAddress),
}

pub(crate) const RADIOS: &str =
    "one of direct, frames, udp://ADDRESS:PORT, zenoh, zenoh:FILE.json5, pcap:FILE";

impl Radio {
    /// Carrier of the frames that are not simulated in the run.
    pub fn carrier(&self) -> Option<&CarrierAddress> {
        match self {
            Self::Direct | Self::Frames => None,
            Self::Carrier(address) => Some(address),
        }
    }

    /// True if frames come from other hosts as they are sent.
    pub fn is_live(&self) -> bool {
        self.carrier().is_some_and(CarrierAddress::is_live)
    }

    /// Settles where a carrier's file is: beside the scenario's own file, in `directory`.
    pub(crate) fn place(&mut self, directory: Option<&Path>) {
        let Self::Carrier(address) = self else { return };
        let here = std::env::current_dir().unwrap_or_default();
        address.place(&directory.map_or_else(|| here.clone(), |own| here.join(own)));
    }
}

impl TryFrom<String> for Radio {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.as_str() {
            "direct" => Ok(Self::Direct),
            "frames" => Ok(Self::Frames),
            other => match CarrierAddress::read(other) {
                Some(address) => address.map(Self::Carrier).map_err(|error| error.to_string()),
                None => Err(format!("`{other}` is not a radio, expected {RADIOS}")),
            },
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

tables! {
    /// Place of the road on the Earth, with frames. A capture's maps fit a road that begins and leads as theirs does.
    #[derive(Copy)]
    pub struct Origin {
        /// Latitude of the road's beginning, degrees, north positive.
        pub latitude_deg: Latitude = 48.7,
        /// Longitude of the road's beginning, degrees, east positive.
        pub longitude_deg: Longitude = 9.1,
        /// Direction of the straight road, degrees clockwise from north.
        pub heading_deg: Heading = 90.0,
    }

    /// The air between the roadside units and the vehicle. Without any key nothing is lost, late or wrong.
    #[derive(Copy)]
    pub struct Air {
        /// Time when the imperfections begin, s.
        pub from_s: Time = 0.0,
        /// Duration of them, s. Absent: to the end.
        pub for_s: Option<Duration>,
        /// Probability that a frame is lost.
        pub loss_probability: Probability = 0.0,
        /// Burst loss (Gilbert-Elliott): probability that the channel turns bad, asked for each frame.
        pub burst_begin_probability: Probability = 0.0,
        /// Probability that a bad channel turns good again, asked for each frame.
        pub burst_end_probability: Probability = 0.1,
        /// Probability that a frame is lost while the channel is bad.
        pub burst_loss_probability: Probability = 1.0,
        /// Time that every frame takes, ms. Frames reach the on-board unit in batches, once in `v2x.period_ms`.
        pub delay_ms: DelayMs = 0,
        /// Longest time on top of that, ms, drawn for each frame.
        pub jitter_ms: DelayMs = 0,
        /// Probability that a frame is held back behind the next ones.
        pub reorder_probability: Probability = 0.0,
        /// Time for which such a frame is held back, ms.
        pub reorder_ms: DelayMs = 200,
        /// Probability that a frame arrives twice.
        pub duplicate_probability: Probability = 0.0,
        /// Probability that a frame is cut off.
        pub truncate_probability: Probability = 0.0,
        /// Probability that one bit of a frame is wrong, as after a checksum that matched by chance.
        pub bit_flip_probability: Probability = 0.0,
        /// Probability that an earlier frame is sent again with a new one.
        pub replay_probability: Probability = 0.0,
        /// Age of the frame that is sent again, s.
        pub replay_age_s: Time = 10.0,
    }

    /// Errors of the roadside units. Without any key they make no errors.
    #[derive(Copy)]
    pub struct Unit {
        /// Time by which their clocks are ahead at the start, ms.
        pub clock_offset_ms: OffsetMs = 0,
        /// Rate by which their clocks are too fast, millionths.
        pub clock_drift_ppm: DriftPpm = 0,
        /// Time when a second unit begins to announce that every signal is green, s. Absent: never.
        pub contradicted_from_s: Option<Time>,
        /// Time when the map is replaced by another revision, s; absent: never.
        pub map_changes_at_s: Option<Time>,
        /// The intersection whose map is replaced; absent: all.
        pub map_changes_of: Option<IntersectionId>,
        /// Distance by which stop lines are farther along the road in that revision, m.
        pub map_shift_m: MapShift = 0.0,
        /// Time when the countdowns begin to be wrong, s; absent: never.
        pub countdown_wrong_from_s: Option<Time>,
        /// Jump of the announced ends then, s.
        pub countdown_jump_s: Shift = 0.0,
        /// Slide of the ends from then on, s in each s. 1 is a countdown that stands still.
        pub countdown_slide: Shift = 0.0,
        /// Largest random error of the ends from then on, s, drawn anew for each message and signal.
        pub countdown_jitter_s: Time = 0.0,
        /// Ends from then on are announced in steps of this time, s. The next step is announced when the one before has
        /// come, as of a light that vehicles extend. 0: without steps.
        pub countdown_extends_s: Time = 0.0,
        /// From then on the present phase is announced alone.
        pub countdown_lacks_next: bool = false,
    }

    /// The vehicle's on-board unit.
    #[derive(Copy, Eq)]
    pub struct Obu {
        /// Its station id.
        pub station_id: StationId = 4711,
        /// Largest age of a used frame's content by its own stamp, ms. The same is the limit for stamps in the future.
        pub max_age_ms: DelayMs = 500,
        /// Time by which the vehicle's clock is ahead at the start, ms.
        pub clock_offset_ms: OffsetMs = 0,
        /// Rate by which it is too fast, millionths.
        pub clock_drift_ppm: DriftPpm = 0,
        /// Largest difference between the clocks of senders and vehicle, ms. Greens and yellows are taken to end so
        /// much earlier than announced, reds so much later.
        pub clock_tolerance_ms: DelayMs = 250,
        /// Signed frames (ETSI TS 103 097). No signature is verified, whichever is chosen.
        pub signed: SignedFrames = Use,
    }

    /// Signed frames that arrive.
    pub enum SignedFrames {
        /// Taken out of their envelope and used as frames without a signature.
        #[default]
        Use,
        /// Counted alone.
        Ignore,
    }
}

impl Origin {
    /// Latitude and longitude as messages have them, 1e-7 degrees.
    pub fn steps(&self) -> (i32, i32) {
        let steps = |degrees: f64| (degrees * 1e7).round() as i32;
        (steps(self.latitude_deg.value()), steps(self.longitude_deg.value()))
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
