//! Request of the controller to the vehicle, and its reasons.

use crate::layout::declare::*;

/// Requests that a command can carry.
pub const PLAN_LEN: usize = 128;
/// Law-specific figures in a diagnostics message.
pub const FIGURES: usize = 8;

layout! {
    /// The controller's request with its whole plan: the plant has a valid future to follow when the
    /// controller dies.
    pub message Command "timegap_msgs/msg/Command" {
        /// Scheduled release of the radar's cycle that published the radar sample, ns of run time; −1
        /// without a sample.
        pub radar_release_ns: i64,
        /// Since when the controller waited for its release, ns of run time.
        pub idle_ns: i64,
        /// Time when the cycle began to work on its inputs, ns of run time.
        pub start_ns: i64,
        /// Times that the cycle gave the processor up, from its start to its command.
        pub voluntary_switches: u32,
        /// Times that the processor was taken from it.
        pub involuntary_switches: u32,
        /// Pages that it found in memory but not mapped.
        pub minor_faults: u32,
        /// Pages that it had to wait for.
        pub major_faults: u32,
        /// Iterations of the law's solver.
        pub solver_iterations: u32,
        /// Mode of the law.
        pub mode: u32,
        /// Time between two requests of the plan, ns.
        pub plan_period_ns: i64,
        /// Valid entries of `plan_mps2`; 0 for a cycle without a command.
        pub plan_len: u64,
        /// Requested accelerations, m/s²; the first is for now. Unused entries are 0.
        pub plan_mps2: [f64; PLAN_LEN],
        /// 1: `engine_torque_nm` acts now in place of the plan's first request. The rest of the plan is for
        /// the time without a newer command. 0: there is no torque.
        pub has_torque: u32,
        /// Gear that the torque is for, counted from 1; 0 leaves it to the gearbox.
        pub gear: u32,
        /// Requested torque at the crankshaft, N m; below the drag torque it asks for the engine brake.
        pub engine_torque_nm: f64,
        /// Requested force of the service brakes beside the torque, N.
        pub service_brake_n: f64,
    }

    /// State and decisions of the controller in one cycle. It is sent in every cycle, also in one without a command.
    pub message Diagnostics "timegap_msgs/msg/Diagnostics" {
        /// Time when the cycle began to work on its inputs, ns of run time.
        pub start_ns: i64,
        /// Mode of the law, an index into its mode names.
        pub mode: u32,
        /// Reason of the last mode change, an index into its reason names.
        pub mode_reason: u32,
        /// Quality of the command: 0 full, 1 relaxed, 2 backup.
        pub quality: u32,
        /// Iterations of the solver.
        pub solver_iterations: u32,
        /// `Level` of the controller, as a number.
        pub rung: u32,
        /// 1 while the driver is asked to take over.
        pub takeover: u32,
        /// First request, m/s².
        pub request_mps2: f64,
        /// Age of the odometry sample at the release, ns; −1 without a sample.
        pub odometry_age_ns: i64,
        /// Age of the radar sample at the release, ns; −1 without a sample.
        pub radar_age_ns: i64,
        /// Age of the SPAT sample at the release, ns; −1 without a sample.
        pub spat_age_ns: i64,
        /// Figures of the law, named by it.
        pub figures: [f64; FIGURES],
    }
}
