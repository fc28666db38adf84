//! Numbers of the tracker beside a scenario's keys, each with its origin.
//!
//! The effects that the rows state are those that earlier trackers showed with
//! `cargo run --release -p perception-sim --example perception_numbers -- 80`, over 80 scenes of 20 s. Their figures
//! are: GOSPA 3.98 m; a cut-in is confirmed 0.36 s before the overlap; a false target for 2.6 s in all; an error of 0.41
//! m/s² in the target's acceleration, and one of 0.018 in the seen share. While odometry is wrong, the ego's speed has
//! an error of 0.22 m/s. "Nothing changes" means less than 1 % of GOSPA, 0.02 s, 10 % of that time, 2 % of the
//! acceleration's error, and 5 % of the other two.
//!
//! Effects on lost leads and taken neighbours are those of `--example course -- effects 4 2 NAMES`.
//!
//! ```
//! use perception_sim::tracking::numbers::Numbers;
//!
//! let calm = Numbers { hard_mps2: 5.0, ..Numbers::DEFAULT };
//! assert!(calm.hard_mps2 < calm.hardest_mps2);
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the tracker.
    pub struct Numbers {
        // Motion along the road.

        /// Standard deviation of the acceleration of a lead in emergency braking.
        hard_mps2: f64 = 7.0, "m/s²", 4.0..=12.0, "Chosen. At 4 GOSPA +2 %, error of the target's acceleration +6 %; at 12 no change.";
        /// Hardest braking and acceleration of a vehicle, which bound the estimate.
        hardest_mps2: f64 = 10.0, "m/s²", 6.0..=15.0, "Chosen: tyres on a dry road give about 1 g. At 6 error of the target's acceleration +9 %; at 15 no change.";

        // Motion across the lanes.

        /// Density of the lateral acceleration of a vehicle that keeps its lane.
        in_lane_m2ps3: f64 = 0.01, "m²/s³", 0.001..=0.5, "Chosen. At 0.005 and 0.02 nothing changes.";
        /// Density of the lateral acceleration in a lane change.
        lane_change_m2ps3: f64 = 2.0, "m²/s³", 0.5..=10.0, "Chosen. At 1 cut-in delay -0.09 s; at 4 cut-in delay +0.07 s.";
        /// Time constant with which the lateral speed of a vehicle that keeps its lane fades.
        fading_s: f64 = 1.0, "s", 0.2..=5.0, "Chosen. At 0.5 and 2 nothing changes.";
        /// Mean time that a vehicle keeps its lane.
        in_lane_s: f64 = 5.0, "s", 1.0..=60.0, "Chosen. At 2.5 and 10 nothing changes.";
        /// Mean time of a lane change.
        lane_change_s: f64 = 2.0, "s", 0.5..=10.0, "Chosen. At 1 and 4 nothing changes.";
        /// Standard deviation of the lateral speed of a new vehicle.
        first_lateral_mps: f64 = 1.0, "m/s", 0.2..=3.0, "Chosen. At 0.5 and 2 nothing changes.";

        // Bodies.

        /// Length of a vehicle of which nothing is known yet; also the object list's.
        first_length_m: f64 = 4.5, "m", 3.5..=6.0, "Chosen. At 3.5 and 6 nothing changes.";
        /// Width of a vehicle of which nothing is known yet.
        first_width_m: f64 = 1.8, "m", 1.5..=2.6, "Chosen. At 1.5 cut-in delay -0.06 s; at 2.6 GOSPA +2 %, cut-in delay +0.34 s, time with a false target +16 %.";
        /// Greatest length of a vehicle.
        longest_m: f64 = 25.0, "m", 12.0..=30.0, "Chosen. At 12.5 GOSPA +3 %, time with a false target -82 %; at 30 no change.";
        /// Greatest width of a vehicle.
        widest_m: f64 = 2.6, "m", 2.0..=3.0, "Source: Directive 96/53/EC, Annex I, 1.2: 2.55 m, refrigerated 2.6 m. At 2 and 3 nothing changes.";
        /// Depth behind the nearest echo in which echoes come from the rear.
        rear_depth_m: f64 = 0.8, "m", 0.2..=2.0, "Chosen. At 0.4 GOSPA +1 %, cut-in delay +0.18 s, time with a false target +14 %; at 1.6 GOSPA +2 %, cut-in delay -0.05 s.";
        /// Weight of a scan in length and width.
        extent_weight: f64 = 0.1, "1", 0.01..=0.5, "Chosen. At 0.05 GOSPA +6 %, time with a false target -92 %; at 0.2 GOSPA -4 %.";
        /// Standard deviation of the mean place of the echoes on a rear.
        rear_sigma_m: f64 = 0.1, "m", 0.0..=0.5, "Chosen. At 0.05 and 0.2 nothing changes.";
        /// Standard deviation of an echo from the side.
        side_sigma_m: f64 = 0.2, "m", 0.05..=1.0, "Chosen. At 0.1 and 0.4 nothing changes.";
        /// Share of a uniform distribution's variance in unresolved echoes between the sides: the middle is strong.
        middle_share: f64 = 0.4, "1", 0.1..=1.0, "Chosen. At 0.2 cut-in delay -0.04 s, time with a false target +29 %; at 0.8 cut-in delay +0.03 s.";
        /// Margin to the edge of the field of view within which a vehicle is cut off.
        edge_rad: f64 = 0.05, "rad", 0.0..=0.2, "Chosen. At 0.025 and 0.1 nothing changes.";
        /// Scans in a row that contradict a track before it begins anew.
        misfits: u32 = 3, "scans", 1.0..=20.0, "Chosen. At 2 and 6 nothing changes.";

        // Assignment of detections to tracks.

        /// Standard deviations within which two quantities surely agree.
        surely_sigma: f64 = 3.0, "σ", 2.0..=6.0, "Chosen. At 2 GOSPA -1 %, cut-in delay +0.03 s; at 6 GOSPA +2 %, cut-in delay -0.05 s.";
        /// Standard deviations within which two lateral positions probably agree.
        likely_sigma: f64 = 2.0, "σ", 1.0..=4.0, "Chosen. At 1 no change; at 4 GOSPA -1 %.";
        /// Standard deviation of the place on the body from which an echo comes.
        body_sigma_m: f64 = 0.3, "m", 0.05..=1.0, "Chosen. At 0.15 time with a false target +94 %; at 0.6 GOSPA +2 %.";
        /// Distance beyond the known length from which an echo may come: echoes from under the body are late.
        beyond_m: f64 = 2.5, "m", 0.0..=6.0, "Chosen. At 1.25 time with a false target -27 %; at 5 time with a false target -29 %.";
        /// The same along the side of a vehicle on another lane: on long vehicles the places are far apart.
        beyond_along_side_m: f64 = 6.0, "m", 0.0..=15.0, "Chosen. At 3 GOSPA +26 %, time with a false target -98 %; at 12 GOSPA -7 %.";

        /// Squared distance that is added for a track that is not confirmed: the middle of two vehicles takes no echo
        /// from one that is.
        tentative_penalty: f64 = 4.0, "σ²", 0.0..=20.0, "Chosen. At 2 and 8 nothing changes.";

        // New tracks.

        /// Speed over ground below which something stands.
        standing_mps: f64 = 1.0, "m/s", 0.2..=3.0, "Chosen. At 0.5 and 2 nothing changes.";
        /// Distance from the lane's centre beyond which a standing echo begins no track.
        standing_half_width_m: f64 = 2.0, "m", 1.0..=3.5, "Chosen. At 1 and 3.5 nothing changes.";
        /// Distance from the lane's centre beyond which no track begins: three and a half lanes of 3.5 m.
        farthest_m: f64 = 12.25, "m", 5.0..=30.0, "Chosen: on random roads the lead is lost 2.3 times as long without it. At 6.125 and 24.5 nothing changes.";
        /// Greatest distance between echoes of one new vehicle along the road.
        cluster_length_m: f64 = 5.0, "m", 1.0..=15.0, "Chosen. At 2.5 and 10 nothing changes.";
        /// The same across the lanes.
        cluster_width_m: f64 = 2.0, "m", 0.5..=3.5, "Chosen. At 1 GOSPA +2 %; at 3.5 no change.";
        /// Greatest difference between their speeds.
        cluster_rate_mps: f64 = 1.0, "m/s", 0.2..=4.0, "Chosen. At 0.5 and 2 nothing changes.";

        // One vehicle with two tracks.

        /// Distance by which the newer track may be before the older one in the ego's lane.
        same_before_m: f64 = 2.0, "m", 0.5..=6.0, "Chosen. At 1 and 4 nothing changes.";
        /// Distance across the lanes below which two tracks may be one vehicle.
        same_across_m: f64 = 1.2, "m", 0.4..=2.5, "Chosen. At 0.6 no change; at 2.4 GOSPA +1 %, time with a false target +39 %.";
        /// Difference of speeds below which they may be one vehicle.
        same_mps: f64 = 1.5, "m/s", 0.3..=5.0, "Chosen. At 0.75 time with a false target -92 %; at 3 GOSPA +2 %.";

        // The ego's path.

        /// Lateral speed below which a vehicle wanders within its lane.
        wandering_mps: f64 = 0.3, "m/s", 0.05..=1.0, "Chosen. At 0.15 and 0.6 nothing changes.";
        /// Standard deviations that a lateral speed has to exceed.
        inward_sigma: f64 = 2.0, "σ", 0.0..=4.0, "Chosen. At 1 cut-in delay -0.18 s, time with a false target +37 %; at 4 cut-in delay +0.33 s.";
        /// The same on an estimated course.
        course_inward_sigma: f64 = 4.0, "σ", 0.0..=8.0, "Chosen: with 2 a neighbour on random roads is taken 0.3 times per km at gaps of 40 to 80 m, with 4 at most 0.04 times (example `course`). At 2 neighbour taken +167 %, neighbour taken with the map +900 %; at 8 no change.";
        /// Time beyond the path after which a vehicle leaves an estimated one.
        course_leave_s: f64 = 0.5, "s", 0.0..=2.0, "Chosen: at the start of a curve the course lags for some scans. At 0.25 lead lost +14 %, neighbour taken -51 %, neighbour taken with the map -45 %; at 1 no change.";
        /// Hardest braking of an adaptive cruise control.
        cruise_braking_mps2: f64 = 5.0, "m/s²", 3.0..=8.0, "Source: ISO 15622: 5 m/s² at low speed. At 3 and 8 nothing changes.";
        /// Time until its braking acts: confirmation, control cycle and actuator.
        braking_late_s: f64 = 0.5, "s", 0.0..=1.5, "Chosen. At 0.25 and 1 nothing changes.";

        // Vehicles that are lost in the path.

        /// Time for which a lost vehicle is carried on.
        lost_s: f64 = 2.5, "s", 0.5..=6.0, "Chosen: an outage of 2 s is bridged with a margin of a quarter. At 1.25 GOSPA +2 %; at 5 no change.";
        /// Time after which its last motion takes the place of the filter's prediction.
        chance_s: f64 = 0.12, "s", 0.04..=1.0, "Chosen: two missed scans of 50 ms are chance. At 0.06 and 0.24 nothing changes.";
        /// Distance by which a lost vehicle may be before the one that is found.
        found_m: f64 = 15.0, "m", 2.0..=50.0, "Chosen. At 7.5 and 30 nothing changes.";

        // Share of the expected detections that come.

        /// Memory of the share.
        memory_s: f64 = 1.0, "s", 0.2..=5.0, "Chosen: 20 scans, so that a car's chance misses stay below a tenth. At 0.5 error of the seen share +23 %; at 2 error of the seen share -10 %.";
        /// Weight of the sound radar that is assumed before the first scan.
        assumed: f64 = 4.0, "scans", 0.5..=20.0, "Chosen. At 2 and 8 nothing changes.";
        /// Strength over the threshold from which a post is expected again.
        strong_db: f64 = 10.0, "dB", 3.0..=20.0, "Chosen: an echo of Swerling's case 1 that is 10 dB above comes again in nine of ten scans. At 5 error of the seen share -16 %; at 20 error of the seen share +23 %.";
        /// Probability that such a post is seen again.
        post_again: f64 = 0.9, "1", 0.5..=1.0, "Measured over the built-in scenarios without dropout. At 0.5 error of the seen share +388 %; at 1 error of the seen share +18 %.";
        /// Probability that a tracked vehicle within reach is seen again.
        track_again: f64 = 0.95, "1", 0.5..=1.0, "Measured over the built-in scenarios without dropout. At 0.5 error of the seen share +259 %; at 1 error of the seen share -14 %.";
        /// Distance up to which vehicles and posts are counted: farther echoes are weak.
        reach_m: f64 = 80.0, "m", 30.0..=150.0, "Chosen. At 40 error of the seen share +6 %; at 150 no change.";
        /// Distance of posts from the ego's axis: the next lane is nearer.
        posts_from_m: f64 = 5.0, "m", 3.0..=8.0, "Chosen. At 3 and 8 nothing changes.";
        /// Distance along the road between a post and the place where it is expected.
        post_along_m: f64 = 1.0, "m", 0.3..=4.0, "Chosen. At 0.5 and 2 nothing changes.";
        /// The same across the lanes.
        post_across_m: f64 = 2.0, "m", 0.5..=4.0, "Chosen. At 1 and 4 nothing changes.";
        /// Distance across the lanes within which a nearer vehicle may hide another one.
        hides_m: f64 = 2.5, "m", 1.0..=5.0, "Chosen. At 1.25 no change; at 5 error of the seen share +7 %.";
        /// Posts, times scans, that the map predicted without a detection of post or vehicle, from which the radar is blind.
        promised: f64 = 80.0, "posts", 5.0..=200.0, "Chosen: half a second at 50 posts a kilometre; two of three may be hidden by vehicles.";

        // The ego's speed by standing objects.

        /// Distance from the ego's axis within which a detection may be a vehicle of this lane or the next one.
        off_lane_m: f64 = 4.5, "m", 2.0..=8.0, "Chosen: the far side of a vehicle in the middle of a lane of 3.5 m. At 2.25 GOSPA +11 %; at 8 GOSPA +2 %, error of the ego's speed +59 %.";
        /// Growth of that distance with the range: else a queue that crawls in the next lane passes for standing objects.
        off_lane_rad: f64 = 0.015, "rad", 0.0..=0.06, "Chosen: three standard deviations of the azimuth of an echo at the threshold of 12 dB. At 0.0075 and 0.03 nothing changes.";
        /// Error of the speed of a standing object's detection.
        stand_noise_mps: f64 = 0.6, "m/s", 0.1..=2.0, "Chosen. At 0.3 and 1.2 nothing changes.";
        /// Greatest acceleration of the ego, either way.
        ego_change_mps2: f64 = 12.0, "m/s²", 6.0..=15.0, "Chosen. At 6 and 15 nothing changes.";
        /// Fewest detections that make a measurement.
        least_points: u32 = 3, "detections", 1.0..=20.0, "Chosen. At 2 error of the ego's speed -60 %; at 6 GOSPA +7 %, error of the ego's speed +122 %.";
        /// Fewest detections that agree in a measurement that is not bound.
        least_unbound: u32 = 6, "detections", 1.0..=30.0, "Chosen. At 3 error of the ego's speed -20 %; at 12 no change.";
        /// Places of the objects that contradict odometry.
        least_places: u32 = 3, "places", 1.0..=20.0, "Chosen: a vehicle ahead and one beside it are usual. At 2 error of the ego's speed +11 %; at 6 GOSPA +11 %, error of the ego's speed +353 %.";
        /// Distance along the range within which detections are of one place.
        place_m: f64 = 6.0, "m", 1.0..=30.0, "Chosen: a car's length and a metre. At 3 and 12 nothing changes.";
        /// Difference from which odometry contradicts the measurement.
        disagrees_mps: f64 = 1.0, "m/s", 0.3..=4.0, "Chosen. At 0.5 no change; at 2 GOSPA +91 %, time with a false target +14 %, error of the target's acceleration -42 %, error of the ego's speed +507 %.";
        /// Scans in a row with such a difference before the tracker uses the measurement.
        disagrees_scans: u32 = 2, "scans", 1.0..=20.0, "Chosen. At 1 error of the ego's speed -8 %; at 4 GOSPA +13 %, error of the ego's speed +14 %.";
    }
}
