//! The controller's path: a command goes from the topic over delivery and gateway to the actuators, and is accounted.

use messages::{Command, Header, Origins, PLAN_LEN};
use runtime::{Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use truck_model::Demand;

use crate::chains::{CONTROL_PATH, Chains};
use crate::delivery::{Arrival, Delivery};
use crate::gateway::{Actuation, Gateway};
use crate::parts::Actuated;
use crate::signal_chain::SignalChain;
use crate::timeliness::Timeliness;

/// The path with its port.
pub(super) struct Control {
    pub(super) command: Subscriber<Command>,
    pub(super) delivery: Delivery,
    pub(super) gateway: Gateway,
    pub(super) chains: Chains,
    pub(super) signal_chain: SignalChain,
    pub(super) timeliness: Timeliness,
    active: Option<Command>,
    /// Run time at which the last command was accepted, ns.
    accepted_ns: Option<i64>,
}

impl Control {
    pub(super) fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let deadline_ns = i64::from(scenario.controller.deadline().value()) * 1_000_000;
        let period_ns = i64::from(scenario.controller.period_ms.value()) * 1_000_000;
        Ok(Self {
            command: runtime.subscriber()?,
            delivery: Delivery::new(scenario),
            gateway: Gateway::new(&scenario.plant),
            chains: Chains::open(deadline_ns, CONTROL_PATH, runtime.figures())?,
            signal_chain: SignalChain::open(runtime.figures())?,
            timeliness: Timeliness::new(period_ns, deadline_ns),
            active: None,
            accepted_ns: None,
        })
    }

    /// Header of the messages of a release: the command that acts shows where they come from.
    pub(super) fn header(&self, release: &Release) -> Header {
        let origins = self.active.as_ref().map_or(Origins::NONE, |active| active.header.origins);
        Header::new(release.step, release.scheduled_ns, origins)
    }

    /// Lets the newest due command act on the actuators.
    pub(super) fn actuate(&mut self, release: &Release, now_ns: i64) -> Actuation {
        if let Some(command) = self.command.newest() {
            self.delivery.take(command, now_ns);
        }
        if let Some(arrival) = self.delivery.arrived(now_ns) {
            self.accept(&arrival, release, now_ns);
        }
        self.timeliness.judge(release.scheduled_ns);
        if let Some(active) = &self.active {
            let (scheduled_ns, start_ns) = (release.scheduled_ns, release.start_ns);
            self.chains.actuated(active, &Actuated { scheduled_ns, start_ns, now_ns });
            self.signal_chain.actuated(active, now_ns);
        }
        self.gateway.actuate(release.scheduled_ns.unsigned_abs())
    }

    fn accept(&mut self, arrival: &Arrival, release: &Release, now_ns: i64) {
        let released_ns = arrival.released_ns(now_ns);
        let Arrival { command, delay_ns, is_repeated, .. } = *arrival;
        let plan_len = usize::try_from(command.plan_len).map_or(0, |len| len.min(PLAN_LEN));
        let plan_len = if is_repeated { 0 } else { plan_len };
        if plan_len > 0 {
            self.timeliness.arrived(released_ns);
        }
        // The plan is moved by the delay with the rest of the command.
        let start_ns = released_ns + delay_ns;
        let engine = (command.has_torque != 0).then(|| Demand {
            engine_torque_nm: command.engine_torque_nm,
            service_brake_n: command.service_brake_n,
            gear: (command.gear as usize).checked_sub(1),
        });
        let accepted = self.gateway.accept(
            release.scheduled_ns.unsigned_abs(),
            start_ns.unsigned_abs(),
            command.plan_period_ns.unsigned_abs(),
            &command.plan_mps2[..plan_len],
            engine,
        );
        if accepted {
            if let Some(last_ns) = self.accepted_ns.replace(now_ns) {
                let longest_ns = &mut self.timeliness.longest_gap_ns;
                *longest_ns = (*longest_ns).max(now_ns - last_ns);
            }
            self.active = Some(command);
        }
    }
}
