//! Messages of the loop, written in the place where they are read.

use super::Loop;
use crate::law::{MAX_PLAN, Quality};
use messages::level::Level;
use messages::{Command, Diagnostics, Header, Message};
use runtime::{Release, Subscriber, Usage};

impl Loop {
    pub(super) fn write_command(
        &self,
        message: &mut Command,
        header: Header,
        release: &Release,
        radar_release_ns: i64,
        used: &Usage,
    ) {
        let plan_len = self.output.plan_len.min(MAX_PLAN);
        message.header = header;
        message.radar_release_ns = radar_release_ns;
        message.idle_ns = release.idle_ns;
        message.start_ns = release.start_ns;
        message.voluntary_switches = used.voluntary_switches;
        message.involuntary_switches = used.involuntary_switches;
        message.minor_faults = used.minor_faults;
        message.major_faults = used.major_faults;
        message.solver_iterations = self.output.solver_iterations;
        message.mode = self.output.mode;
        message.plan_period_ns = self.plan_period_ns;
        message.plan_len = plan_len as u64;
        message.plan_mps2[..plan_len].copy_from_slice(&self.output.plan_mps2[..plan_len]);
        if let Some(torque) = self.output.torque {
            message.has_torque = 1;
            message.gear = torque.gear.map_or(0, |gear| gear as u32 + 1);
            message.engine_torque_nm = torque.engine_torque_nm;
            message.service_brake_n = torque.service_brake_n;
        }
    }

    pub(super) fn write_diagnostics(
        &self,
        message: &mut Diagnostics,
        header: Header,
        release: &Release,
        level: Level,
    ) {
        let age = |acquisition_ns: Option<i64>| {
            acquisition_ns.map_or(-1, |acquired| release.start_ns - acquired)
        };
        message.header = header;
        message.start_ns = release.start_ns;
        message.mode = self.output.mode;
        message.mode_reason = self.output.mode_reason;
        message.quality = match self.output.quality {
            Quality::Full => 0,
            Quality::Relaxed => 1,
            Quality::Backup => 2,
            Quality::FallBack => 3,
        };
        message.solver_iterations = self.output.solver_iterations;
        message.rung = level as u32;
        message.takeover = u32::from(level == Level::LeadLost);
        message.request_mps2 = self.output.request_mps2();
        message.odometry_age_ns = age(acquired(&self.inputs.odometry));
        message.radar_age_ns = age(acquired(&self.inputs.radar));
        message.spat_age_ns = age(acquired(&self.inputs.spat));
        message.figures.copy_from_slice(&self.output.figures);
    }
}

fn acquired<T: Message>(topic: &Subscriber<T>) -> Option<i64> {
    topic.newest().map(|sample| sample.header().acquisition_ns)
}
