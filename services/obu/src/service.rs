//! The on-board unit's loop: released by a batch of frames, or by its timer if the batch is late.

use crate::awareness::Awareness;
use crate::clock::{ClockError, Moment};
use crate::lanes::Path;
use crate::receiver::Receiver;
use crate::report::ObuReport;
use crate::verdict::Verdicts;
use messages::{
    AnnouncedMotions, Header, Map, Odometry, Origin, Origins, RadioFrames, RadioSent, Service,
    ServiceState, Spat,
};
use runtime::statistics::Latencies;
use runtime::{
    Count, Cycle, Figures, Group, Publisher, Release, Runtime, RuntimeError, Subscriber, Timetable,
    monotonic_ns,
};
use scenario::Scenario;
use scenario::radio::SignedFrames;

/// Periods after which the timer releases a cycle without its batch. Chosen: half of one later the batch counts as lost.
const FALLBACK_PERIODS: f64 = 0.5;
/// Periods without a batch after which the radio counts as dead. Chosen: two lost batches are chance.
const DEAD_PERIODS: i64 = 3;
/// Silence of a unit that was restarted during the run, ns. Meanwhile it receives the maps of the intersections ahead,
/// and the controller uses the earlier timing. Chosen: the period of a map, 1 s, and three batches.
const RESTART_SILENT_NS: i64 = 1_300_000_000;

/// Runs the on-board unit in its group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut unit = Unit::open(&mut runtime, &scenario)?;
    runtime.begin(&scenario)?;
    unit.own_utc_start_ns = runtime.utc_start_ns();
    runtime.run_cycles(|runtime| unit.cycle(runtime))?;
    let signers = &unit.receiver.signers;
    if signers.frames > 0 {
        let (frames, names) = (signers.frames, signers.not_verified.len());
        eprintln!("{frames} signed frames of {names} signers: their signatures are not verified");
    }
    let report = ObuReport {
        signed: (signers.frames > 0).then(|| signers.clone()),
        ..unit.counts.report(&unit.receiver.verdicts)
    };
    runtime.finish(report)
}

struct Unit {
    odometry: Subscriber<Odometry>,
    frames: Subscriber<RadioFrames>,
    spat: Publisher<Spat>,
    map: Publisher<Map>,
    /// Those of the other egos in a net.
    motions: Option<Publisher<AnnouncedMotions>>,
    sent: Publisher<RadioSent>,
    receiver: Receiver,
    awareness: Awareness,
    clock_error: ClockError,
    /// UTC of run time 0 by the vehicle's clock, used until a batch carries one, ns.
    own_utc_start_ns: i64,
    period_ns: i64,
    fallback_ns: i64,
    /// First release at which a restarted unit publishes, ns.
    speaks_from_ns: Option<i64>,
    batch: Origin,
    counts: Counts,
}

/// Counts that outlive the process.
struct Counts {
    air: Latencies,
    decode: Latencies,
    age: Latencies,
    frames: Count,
    left_out: Count,
    cams: Count,
}

impl Counts {
    fn open(figures: &Figures) -> Result<Self, RuntimeError> {
        Ok(Self {
            air: figures.latencies("air")?,
            decode: figures.latencies("decode")?,
            age: figures.latencies("age")?,
            frames: figures.count("frames")?,
            left_out: figures.count("left_out")?,
            cams: figures.count("cams")?,
        })
    }

    fn report(&self, verdicts: &Verdicts) -> ObuReport {
        ObuReport {
            frames: self.frames.get(),
            left_out: self.left_out.get(),
            verdicts: verdicts.by_name(),
            signed: None,
            cams_sent: self.cams.get(),
            air_us: self.air.percentiles_us(),
            decode_us: self.decode.percentiles_us(),
            age_us: self.age.percentiles_us(),
        }
    }
}

/// Report of a unit whose processes have ended, from the counts that they kept; `None` without them.
pub fn last_known(group: &Group) -> Option<ObuReport> {
    let figures = &Figures::of(group, Service::Obu);
    let verdicts = Verdicts::open(figures).ok()?;
    Some(Counts::open(figures).ok()?.report(&verdicts))
}

impl Unit {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let (keys, path) = (&scenario.v2x.obu, Path::of(scenario));
        let period_ns = i64::from(scenario.v2x.period_ms.value()) * 1_000_000;
        let max_age_ms = keys.max_age_ms.value().into();
        let mut receiver = Receiver::new(keys.station_id.value(), max_age_ms, path.plane);
        receiver.path = path;
        receiver.verdicts = Verdicts::open(runtime.figures())?;
        receiver.uses_signed = keys.signed == SignedFrames::Use;
        Ok(Self {
            odometry: runtime.subscriber()?,
            frames: runtime.releasing_subscriber()?,
            spat: runtime.publisher()?,
            map: runtime.publisher()?,
            motions: scenario.traffic.route.as_ref().map(|_| runtime.publisher()).transpose()?,
            sent: runtime.publisher()?,
            receiver,
            awareness: Awareness::of(scenario, keys.station_id.value()),
            clock_error: ClockError {
                offset_ms: keys.clock_offset_ms.value(),
                drift_ppm: keys.clock_drift_ppm.value(),
            },
            own_utc_start_ns: 0,
            period_ns,
            fallback_ns: (Timetable::of(scenario).period_ns(Service::Obu) as f64 * FALLBACK_PERIODS)
                as i64,
            speaks_from_ns: None,
            batch: Origin::NONE,
            counts: Counts::open(runtime.figures())?,
        })
    }

    fn cycle(&mut self, runtime: &mut Runtime) -> Result<Cycle, RuntimeError> {
        let Some(release) = runtime.next_release_by(&mut self.frames, self.fallback_ns)? else {
            return Ok(Cycle::Last);
        };
        runtime.update(&mut self.frames)?;
        runtime.update(&mut self.odometry)?;
        let now_ns = release.scheduled_ns;
        let moment = self.moment(now_ns);
        self.take_batch(&moment);
        let ego_m = self.odometry.newest().map_or(0.0, |o| o.moved_to(release.time_s).0);
        self.receiver.forget(now_ns, ego_m);
        let silent_ns = if runtime.is_restarted() { RESTART_SILENT_NS } else { 0 };
        if now_ns >= *self.speaks_from_ns.get_or_insert(now_ns + silent_ns) {
            self.publish(&release, ego_m)?;
        }
        self.send_cam(&release, &moment)?;
        runtime.end_cycle(match self.receives(now_ns) {
            true => ServiceState::Running,
            false => ServiceState::Degraded,
        })?;
        Ok(Cycle::Next)
    }

    /// The present by the vehicle's clock, with its error, and by the senders' clocks.
    fn moment(&self, now_ns: i64) -> Moment {
        let newest = self.frames.newest();
        let start_ns = newest.map_or(self.own_utc_start_ns, |batch| batch.utc_start_ns);
        Moment {
            now_ns,
            utc_start_ns: start_ns + self.clock_error.at(now_ns),
            ahead_ns: newest.map_or(0, |batch| batch.clock_offset_ns),
        }
    }

    /// Decodes and checks the frames of a new batch.
    fn take_batch(&mut self, moment: &Moment) {
        let origin = self.frames.origin();
        let Some(batch) = self.frames.newest().filter(|_| origin != self.batch) else { return };
        self.batch = origin;
        self.counts.left_out.add(batch.left_out);
        for frame in batch.frames() {
            if let Some(on_the_way_ns) = frame.on_the_way_ns() {
                self.counts.air.record_ns(on_the_way_ns);
            }
            let begun = monotonic_ns();
            self.receiver.take(frame.data(), moment);
            self.counts.decode.record_ns(monotonic_ns() - begun);
            self.counts.frames.add(1);
        }
    }

    fn receives(&self, now_ns: i64) -> bool {
        let newest = self.frames.newest().map(|batch| batch.header.acquisition_ns);
        newest.is_some_and(|newest_ns| now_ns - newest_ns <= DEAD_PERIODS * self.period_ns)
    }

    /// Publishes the signals ahead. The acquisition time is the instant of the oldest timing; without a signal
    /// ahead, the release while the radio lives.
    fn publish(&mut self, release: &Release, ego_m: f64) -> Result<(), RuntimeError> {
        let now_ns = release.scheduled_ns;
        let origins = self.origins();
        let mut map = self.map.loan()?;
        let mut spat = self.spat.loan()?;
        let made_ns = self.receiver.write(now_ns, ego_m, &mut map, &mut spat);
        if let Some(made_ns) = made_ns {
            self.counts.age.record_ns(now_ns - made_ns);
        }
        let newest_ns = self.frames.newest().map_or(0, |batch| batch.header.acquisition_ns);
        let acquired_ns = made_ns.unwrap_or(if self.receives(now_ns) { now_ns } else { newest_ns });
        map.header = Header::new(release.step, now_ns, origins);
        spat.header = Header::new(release.step, acquired_ns.min(now_ns), origins);
        let header = map.header;
        self.map.send(map)?;
        self.spat.send(spat)?;
        if let Some(motions) = &mut self.motions {
            motions.send_with(|message| {
                message.header = header;
                for (place, motion) in message.motions.iter_mut().zip(&self.receiver.motions) {
                    *place = *motion;
                    message.count += 1;
                }
            })?;
        }
        Ok(())
    }

    /// The samples of this cycle, from which it can be replayed.
    fn origins(&self) -> Origins {
        Origins { odometry: self.odometry.origin(), spat: self.batch, ..Origins::NONE }
    }

    fn send_cam(&mut self, release: &Release, moment: &Moment) -> Result<(), RuntimeError> {
        let Some(odometry) = self.odometry.newest() else { return Ok(()) };
        let Some(bytes) = self.awareness.due(odometry, 0.0, moment) else { return Ok(()) };
        let origins = self.origins();
        let header = Header::new(release.step, release.scheduled_ns, origins);
        self.counts.cams.add(1);
        self.sent.send_with(|message| {
            message.header = header;
            message.utc_start_ns = moment.utc_start_ns;
            message.frame.write(release.scheduled_ns, -1, &bytes);
        })?;
        Ok(())
    }
}
