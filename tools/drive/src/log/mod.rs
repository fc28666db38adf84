//! The drive as the launcher receives it on the topics.

mod cycles;
mod further;
mod kept_steps;
mod plane;
mod present;

pub use cycles::CycleHistory;
pub use plane::{Body, EgoPlace, PlaneLog, PlaneScene, Seen, TargetPlace};
pub(crate) use present::Present;

use crate::report::ControlFigures;
use crate::steps::{Drive, DriveStep, PowertrainStep};
use bytemuck::Zeroable;
use further::{Further, Headers, Truths, listen_to};
use kept_steps::{KeptSteps, MOST_IN_REALTIME};
use messages::{
    AllVehicles, Brake, BrakeState, Command, Diagnostics, EgoTruth, Header, Heartbeat, Message,
    Powertrain, RadarTracks, Service, ServiceState, TOPICS, Topic, VehicleTruth,
};
use plane::PlaneTopics;
use present::{place_at, take_step};
use runtime::statistics::Latencies;
use runtime::{Group, Guest, InProcess, Mode, RuntimeError, Subscriber, Timetable};
use scenario::Scenario;

/// Most messages of a topic that have room from the start.
const MOST_ROOM: u64 = 100_000;

/// Listens to a group from before its start.
#[derive(Debug)]
pub struct DriveLog {
    // Ports before the node that owns them.
    ego: Subscriber<EgoTruth>,
    powertrain: Subscriber<Powertrain>,
    truth: Subscriber<VehicleTruth>,
    further: Option<Further>,
    command: Subscriber<Command>,
    diagnostics: Subscriber<Diagnostics>,
    brake: Subscriber<Brake>,
    heartbeat: Subscriber<Heartbeat>,
    /// On a road with a plan.
    plane: Option<PlaneTopics>,
    /// Topics that show the first messages of restarted services in realtime, beside those above.
    others: Vec<Box<dyn Headers>>,
    observer: Guest,
    steps: Vec<DriveStep>,
    /// State of the drive in the last of them.
    meets: Option<EgoTruth>,
    powertrains: Vec<(u64, PowertrainStep)>,
    truths: Truths,
    requests: Vec<(u64, f64)>,
    /// Deadline of a control cycle, ns.
    deadline_ns: i64,
    /// Commands that were published after it.
    late_commands: u64,
    cycles: Vec<Diagnostics>,
    history: CycleHistory,
    signal_ages: Latencies,
    /// The emergency brake braked in its last message.
    is_braking: bool,
    brakes: Vec<(u64, BrakeState)>,
    interventions_s: Vec<f64>,
    /// True in realtime: the supervisor takes the signs of life.
    supervised: bool,
    kept: KeptSteps,
    present: Present,
    signs: Vec<Sign>,
    incarnations: [u32; Service::ALL.len()],
    first_messages: Vec<(Service, u32, i64)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sign {
    pub service: Service,
    /// Process of the service that sent it.
    pub incarnation: u32,
    /// Cycles done so far.
    pub cycles: u64,
    /// True if an input of the service is missing or stale.
    pub degraded: bool,
}

impl DriveLog {
    /// Opens all topics. A command is late `deadline_ns` after its release.
    pub fn listen(
        group: &Group,
        scenario: &Scenario,
        deadline_ns: i64,
    ) -> Result<Self, RuntimeError> {
        let observer = Guest::join(group, "launcher")?;
        Self::by(observer, scenario, group.mode, &group.timetable, deadline_ns)
    }

    /// Opens all topics of a run in this thread, where no command is late.
    pub fn in_process(run: &InProcess, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Self::by(run.observer(), scenario, Mode::Lockstep, &run.timetable(), i64::MAX)
    }

    fn by(
        observer: Guest,
        scenario: &Scenario,
        mode: Mode,
        timetable: &Timetable,
        deadline_ns: i64,
    ) -> Result<Self, RuntimeError> {
        let has_plan = scenario.road.plan().is_some();
        // Room for the whole run, within a bound.
        let room = |service| {
            let messages = timetable.last_step / timetable.stride(service) + 1;
            let most =
                if mode == Mode::Realtime { MOST_IN_REALTIME as u64 + 1_000 } else { MOST_ROOM };
            usize::try_from(messages.min(most)).expect("a small number")
        };
        let (perception, controller) =
            (timetable.stride(Service::PerceptionSim), timetable.stride(Service::Controller));
        let others = TOPICS.into_iter().filter(|topic| topic.shows().is_some());
        let others = others.filter(|topic| {
            mode == Mode::Realtime
                && ![EgoTruth::TOPIC, Command::TOPIC, Brake::TOPIC].contains(topic)
                && !(has_plan && *topic == RadarTracks::TOPIC)
        });
        let mut this = Self {
            ego: observer.subscriber()?,
            powertrain: observer.subscriber()?,
            truth: observer.subscriber()?,
            further: Further::listen(&observer, scenario.actors.len())?,
            command: observer.subscriber()?,
            diagnostics: observer.subscriber()?,
            brake: observer.subscriber()?,
            heartbeat: observer.subscriber()?,
            plane: has_plan
                .then(|| PlaneTopics::listen(&observer, scenario.actors.len()))
                .transpose()?,
            others: others.map(|topic| listen_to(&observer, topic)).collect::<Result<_, _>>()?,
            observer,
            steps: Vec::with_capacity(room(Service::Plant)),
            meets: None,
            powertrains: Vec::new(),
            truths: Truths::with_room(room(Service::PerceptionSim), scenario.actors.len()),
            requests: Vec::with_capacity(room(Service::Controller)),
            deadline_ns,
            late_commands: 0,
            cycles: Vec::with_capacity(room(Service::Controller)),
            history: CycleHistory::new(controller),
            signal_ages: Latencies::default(),
            is_braking: false,
            brakes: Vec::new(),
            interventions_s: Vec::new(),
            supervised: mode == Mode::Realtime,
            kept: KeptSteps::new(mode, perception, controller),
            present: Present::of(scenario),
            signs: Vec::new(),
            incarnations: [0; Service::ALL.len()],
            first_messages: Vec::new(),
        };
        if this.supervised {
            touch(&mut this.steps, DriveStep::default());
            touch(&mut this.truths.steps, AllVehicles::with_room(0));
            touch(&mut this.cycles, Diagnostics::zeroed());
        }
        Ok(this)
    }

    /// Thins out the samples of a long drive.
    fn bound(&mut self) {
        while self.kept.thin_out(self.steps.len()) {
            let kept = self.kept;
            self.steps.retain(|step| kept.has(step.step));
            self.truths.thin_out(&kept);
            self.powertrains.retain(|(step, _)| kept.has(*step));
            self.requests.retain(|(step, _)| kept.has(*step));
            self.brakes.retain(|(step, _)| kept.has(*step));
            self.cycles.retain(|message| kept.has(message.header.step));
            if let Some(plane) = &mut self.plane {
                plane.log.retain(&|step| kept.has(step));
            }
        }
    }

    /// Takes the messages that arrived.
    pub fn drain(&mut self) -> Result<(), RuntimeError> {
        self.bound();
        let kept = self.kept;
        let is_kept = |header: &Header| kept.has(header.step);
        let (incarnations, first) = (&mut self.incarnations, &mut self.first_messages);
        let mut note = |topic: Topic, header: &Header| {
            let sender = Service::by_number(header.source);
            let Some(service) = sender.filter(|service| topic.shows() == Some(*service)) else {
                return;
            };
            let newest = &mut incarnations[service.index()];
            if header.incarnation > *newest {
                *newest = header.incarnation;
                first.push((service, header.incarnation, header.publish_ns));
            }
        };
        self.ego.drain(|m| {
            note(EgoTruth::TOPIC, &m.header);
            // The newest sample is always there; the next one replaces it if it is not to be kept.
            if self.steps.last().is_some_and(|last| !kept.has(last.step)) {
                self.steps.pop();
            }
            self.steps.push(DriveStep::of(m));
            self.meets = Some(*m);
        })?;
        self.powertrain.drain(|m| {
            let step = PowertrainStep {
                gear: m.gear,
                engine_torque_nm: m.engine_torque_nm,
                service_brake_n: m.service_brake_n,
                fuel_g: m.fuel_g,
            };
            if is_kept(&m.header) {
                self.powertrains.push((m.header.step, step));
            }
        })?;
        self.truth.drain(|m| self.truths.take(m, &kept))?;
        if let Some(further) = &mut self.further {
            further.join(&mut self.truths.steps)?;
        }
        self.command.drain(|m| {
            note(Command::TOPIC, &m.header);
            let late = m.header.publish_ns - m.header.acquisition_ns > self.deadline_ns;
            self.late_commands += u64::from(late);
            if m.plan_len > 0 && is_kept(&m.header) {
                self.requests.push((m.header.step, m.plan_mps2[0]));
            }
        })?;
        self.diagnostics.drain(|m| {
            self.history.observe(m);
            if m.spat_age_ns >= 0 {
                self.signal_ages.record_ns(m.spat_age_ns);
            }
            if self.cycles.last().is_some_and(|last| !is_kept(&last.header)) {
                self.cycles.pop();
            }
            self.cycles.push(*m);
        })?;
        self.brake.drain(|m| {
            note(Brake::TOPIC, &m.header);
            let is_braking = m.deceleration_mps2 > 0.0;
            if is_braking && !self.is_braking {
                self.interventions_s.push(m.header.acquisition_ns as f64 / 1e9);
            }
            self.is_braking = is_braking;
            if is_kept(&m.header) {
                self.brakes.push((m.header.step, BrakeState::from_wire(m.state)));
            }
        })?;
        if let Some(plane) = &mut self.plane {
            plane.drain(&mut note)?;
        }
        for topic in &mut self.others {
            topic.drain_headers(&mut note)?;
        }
        self.heartbeat.drain(|m| {
            if self.supervised {
                let service = Service::by_number(m.header.source);
                self.signs.extend(service.map(|service| Sign {
                    service,
                    incarnation: m.header.incarnation,
                    cycles: m.cycles,
                    degraded: m.state == ServiceState::Degraded as u64,
                }));
            }
        })
    }

    pub fn take_signs(&mut self) -> Vec<Sign> {
        std::mem::take(&mut self.signs)
    }

    /// Takes the first messages of restarted services: service, incarnation, run time of the publication in ns.
    pub fn take_first_messages(&mut self) -> Vec<(Service, u32, i64)> {
        std::mem::take(&mut self.first_messages)
    }

    pub fn ego(&self) -> Option<EgoTruth> {
        self.meets
    }

    /// Removes a dead process's ends of the topics, so that no sender waits for it.
    pub fn remove_dead(&self) {
        self.observer.remove_dead();
    }

    /// Samples so far: motion of the ego alone, the other vehicles, control cycles. In a long run they are thinned
    /// out, so that an index does not keep its step.
    pub fn heard(&self) -> (&[DriveStep], &[AllVehicles], &[Diagnostics]) {
        (&self.steps, &self.truths.steps, &self.cycles)
    }

    /// Gap and acceleration of the drive so far.
    pub fn figures(&self) -> ControlFigures {
        let accelerations = || self.steps.iter().map(|step| step.acceleration_mps2);
        let mut truths = self.truths.steps.iter().peekable();
        let gaps = self.steps.iter().filter_map(|ego| {
            let truth = take_step(&mut truths, ego.step, |truth| truth.header.step)?;
            truth.nearest_ahead(ego.position_m).map(|(gap_m, _)| gap_m)
        });
        ControlFigures {
            min_gap_m: gaps.reduce(f64::min),
            min_accel_mps2: accelerations().reduce(f64::min),
            max_accel_mps2: accelerations().reduce(f64::max),
            ..ControlFigures::default()
        }
    }

    /// Run time of the newest sample of the vehicle, s.
    pub fn reached_s(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.time_s)
    }

    /// Commands that were published after the deadline of their cycle.
    pub fn late_commands(&self) -> u64 {
        self.late_commands
    }

    pub fn history(&self) -> &CycleHistory {
        &self.history
    }

    /// Times that the emergency brake has begun to brake.
    pub fn interventions(&self) -> usize {
        self.interventions_s.len()
    }

    /// Step of the newest sample of the vehicle.
    pub fn reached(&self) -> u64 {
        self.steps.last().map_or(0, |step| step.step)
    }

    /// Takes the rest and joins the topics by step.
    pub fn finish(mut self) -> Result<Drive, RuntimeError> {
        self.drain()?;
        self.bound();
        let mut received = vec![
            self.ego.received(),
            self.truth.received(),
            self.command.received(),
            self.diagnostics.received(),
            self.heartbeat.received(),
        ];
        received.extend(self.further.as_ref().map(Further::received));
        if !self.powertrains.is_empty() {
            received.push(self.powertrain.received());
        }
        received.extend(self.plane.iter().flat_map(PlaneTopics::received));
        let mut powertrains = self.powertrains.iter().peekable();
        let mut truths = self.truths.steps.iter().peekable();
        let mut requests = self.requests.iter().peekable();
        let mut cycles = self.cycles.iter().peekable();
        let mut brakes = self.brakes.iter().peekable();
        for ego in &mut self.steps {
            let step = ego.step;
            let truth = take_step(&mut truths, step, |truth| truth.header.step);
            let lead = truth.and_then(|truth| truth.nearest_ahead(ego.position_m));
            let cycle = take_step(&mut cycles, step, |cycle| cycle.header.step);
            ego.request_mps2 = take_step(&mut requests, step, |request| request.0).map(|r| r.1);
            ego.gap_m = lead.map(|(gap_m, _)| gap_m);
            ego.lead_speed_mps = lead.map(|(_, speed_mps)| speed_mps);
            if let Some((truth, (gap_m, _))) = truth.zip(lead) {
                let place = place_at(truth, ego.position_m, gap_m);
                ego.lead_acceleration_mps2 =
                    place.map(|place| truth.vehicles[place].acceleration_mps2);
                ego.lead = place.and_then(|place| self.present.actor(truth, place));
            }
            ego.brake = take_step(&mut brakes, step, |brake| brake.0).map(|brake| brake.1);
            ego.mode = cycle.map(|cycle| cycle.mode);
            ego.quality = cycle.map(|cycle| cycle.quality);
            ego.figures = cycle.map(|cycle| cycle.figures);
            ego.powertrain = take_step(&mut powertrains, step, |p| p.0).map(|p| p.1);
        }
        let signal_age_us = self.signal_ages.percentiles_us();
        let plane = self.plane.map(|plane| plane.log.finish(&self.truths.steps));
        Ok(Drive {
            steps: self.steps,
            plane: plane.unwrap_or_default(),
            vehicles: self.truths.steps,
            interventions_s: self.interventions_s,
            received,
            signal_age_us,
        })
    }
}

/// Writes to all reserved room, so that its pages are there from the start.
fn touch<T: Clone>(room: &mut Vec<T>, anything: T) {
    room.resize(room.capacity(), anything);
    std::hint::black_box(room.as_mut_slice());
    room.clear();
}
