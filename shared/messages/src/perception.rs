//! Measurements of the radar, and the ground truth.

use crate::layout::declare::*;

/// Most tracks that a message carries, and most vehicles and poses of the first message of a step.
pub const MAX_TRACKS: usize = 8;

layout! {
    /// One raw radar track.
    pub struct Track "timegap_msgs/msg/Track" {
        /// Identity of the track.
        pub id: u32,
        /// 1 if the track was selected as the in-path target.
        pub in_path: u32,
        /// Bumper-to-bumper range, m.
        pub range_m: f64,
        /// Range rate, m/s, negative when closing.
        pub range_rate_mps: f64,
        /// Azimuth, rad, positive to the left.
        pub azimuth_rad: f64,
    }

    /// The in-path target after tracking.
    pub struct TrackedTarget "timegap_msgs/msg/TrackedTarget" {
        /// 1 if there is a target; all other fields are 0 otherwise.
        pub valid: u32,
        /// Identity of the track: a new number means a new vehicle.
        pub track_id: u32,
        /// Bumper-to-bumper distance, m.
        pub gap_m: f64,
        /// Target speed minus ego speed, m/s.
        pub relative_speed_mps: f64,
        /// Absolute acceleration of the target, m/s².
        pub acceleration_mps2: f64,
        /// Probability that it stands beside the ego's way; 0 of one that has moved.
        pub doubt_share: f64,
    }

    /// Output of the radar and its tracker.
    pub message RadarTracks "timegap_msgs/msg/RadarTracks" lists tracks: Track {
        /// The selected and filtered in-path target.
        pub target: TrackedTarget,
        /// Valid entries of `tracks`.
        pub count: u64,
        /// Raw tracks, nearest first; unused entries are 0.
        pub tracks: [Track; MAX_TRACKS],
        /// Speed of the ego at the scan as what stands beside the road shows it, m/s; 0 without such
        /// detections.
        pub ego_speed_mps: f64,
        /// Detections behind it; 0: not measured.
        pub ego_speed_points: u64,
        /// Share of the expected detections that came, of tracked vehicles and of objects beside the road. It is 1 if
        /// the radar sees all that it should see, and 0 if it sees nothing.
        pub seen_share: f64,
    }
}

/// Sight of a radar: the part of the expected objects that it sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// All of it, up to chance.
    Full,
    /// A part of it: new vehicles are found late.
    Limited,
    /// Too little to find a vehicle in time.
    Blind,
}

impl Sight {
    /// Below this share of the expected detections the sight is limited. Chosen: three of four scans confirm a
    /// track, and three of four expected detections are 0.75.
    pub const LIMITED_BELOW: f64 = 0.7;
    /// Below this share the radar is blind. Chosen: with one detection in three scans, three hits take 0.45 s at 20
    /// scans per second. A warning should precede braking by at least as much (UN R152, 5.2.1.1).
    pub const BLIND_BELOW: f64 = 0.33;

    /// The sight of a radar with a share of the expected detections. Not a number counts as blind.
    pub fn of_share(seen_share: f64) -> Self {
        match seen_share {
            share if share >= Self::LIMITED_BELOW => Self::Full,
            share if share >= Self::BLIND_BELOW => Self::Limited,
            _ => Self::Blind,
        }
    }
}

impl RadarTracks {
    pub fn sight(&self) -> Sight {
        Sight::of_share(self.seen_share)
    }

    /// Speed of the ego as the radar measured it, m/s.
    pub fn measured_ego_speed_mps(&self) -> Option<f64> {
        (self.ego_speed_points > 0).then_some(self.ego_speed_mps)
    }
}

/// Most detections that a message carries.
pub const MAX_DETECTIONS: usize = 1024;

layout! {
    /// One detection of the radar.
    pub struct Detection "timegap_msgs/msg/Detection" {
        /// Range, m.
        pub range_m: f64,
        /// Range rate, m/s, negative when closing.
        pub range_rate_mps: f64,
        /// Azimuth, rad, positive to the left.
        pub azimuth_rad: f64,
        /// Signal-to-noise ratio, dB.
        pub snr_db: f64,
        /// Radar cross section that follows from it, dB relative to 1 m².
        pub rcs_dbsm: f64,
        /// Reserved: 0.
        pub flags: u32,
        /// Detections with the same number are the same echo at different ambiguous range rates. 0: the range rate is
        /// not ambiguous.
        pub ambiguity_group: u32,
    }

    /// Output of the radar's receiver in one scan: several detections for some vehicles, and none for others. Empty
    /// when the radar's model has no detections. The header's acquisition time is that of the scan.
    pub message RadarDetections "timegap_msgs/msg/RadarDetections" lists detections: Detection {
        /// Speed of the ego at the scan, m/s. It is the radar's own measurement by standing objects if odometry is
        /// missing or contradicts it.
        pub ego_speed_mps: f64,
        /// Detections for which there was no room.
        pub left_out: u64,
        /// Valid entries of `detections`.
        pub count: u64,
        /// Detections, nearest first up to their noise; unused entries are 0.
        pub detections: [Detection; MAX_DETECTIONS],
    }

    /// A vehicle as it really is.
    pub struct VehicleTruthItem "timegap_msgs/msg/VehicleTruthItem" {
        /// 1 if the vehicle's body reaches into the ego's lane.
        pub in_lane: u64,
        /// Position of the rear bumper on the ego's axis, m.
        pub rear_position_m: f64,
        /// Speed, m/s.
        pub speed_mps: f64,
        /// Acceleration, m/s².
        pub acceleration_mps2: f64,
        /// Lateral offset from the ego's lane centre, m, positive to the left.
        pub lateral_m: f64,
    }

    /// All simulated vehicles as they really are at the header's step.
    pub message VehicleTruth "timegap_msgs/msg/VehicleTruth" lists vehicles: VehicleTruthItem {
        /// 1 once the scenario's storyboard has come to its end, and with it the run.
        pub ended: u64,
        /// Valid entries of `vehicles`.
        pub count: u64,
        /// The vehicles in the scenario's order; unused entries are 0.
        pub vehicles: [VehicleTruthItem; MAX_TRACKS],
    }
}
