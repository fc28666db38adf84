//! The perception loop: move the traffic, scan, track, publish.

use crate::perception::Perception;
use crate::radar::scene::Ego;
use crate::tracking::TrackList;
use crate::traffic::{Kept, Vehicle};
use bytemuck::Zeroable;
use messages::{
    Detection, Header, MAX_TRACKS, Odometry, Origins, RadarDetections, RadarTracks, ServiceState,
    Track, TrackedTarget, VehicleTruth, VehicleTruthItem,
};
use runtime::report::Details;
use runtime::{Checkpoint, Cycle, Mode, Overrun, Publisher, Runtime, RuntimeError};
use scenario::perception::RadarModel;

/// Runs traffic and radar in their group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut perception = Perception::new(&scenario);
    let mut odometry = runtime.subscriber::<Odometry>()?;
    let mut tracks = runtime.publisher::<RadarTracks>()?;
    let mut truth = runtime.publisher::<VehicleTruth>()?;
    let mut output = DetectionOutput::new();
    if scenario.perception.model() == RadarModel::Detections {
        output.port = Some(runtime.publisher::<RadarDetections>()?);
    }
    let start = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
    let mut checkpoint = match runtime.clock().mode() {
        Mode::Realtime => Some(runtime.checkpoint::<Kept>()?),
        Mode::Lockstep => None,
    };
    if runtime.is_restarted()
        && let Some(kept) = checkpoint.as_mut().and_then(Checkpoint::restore)
    {
        perception.traffic().go_on_from(&kept);
    }
    runtime.begin(&scenario)?;
    runtime.run_cycles(|runtime| {
        let Some(release) = runtime.next_release(Overrun::Skip) else { return Ok(Cycle::Last) };
        runtime.update(&mut odometry)?;
        let ego = odometry.newest().map_or(start, |odometry| ego_at(odometry, release.time_s));
        let time_ns = release.scheduled_ns.unsigned_abs();
        let list = *perception.step(time_ns, &ego, &mut output.message.detections);
        if let Some(checkpoint) = &mut checkpoint {
            checkpoint.save(&perception.traffic().kept())?;
        }

        // The referee's copy first: the plant may be waiting for it.
        let origins = Origins { odometry: odometry.origin(), ..Origins::NONE };
        let header = Header::new(release.step, release.scheduled_ns, origins);
        let ended = perception.traffic().is_over();
        truth.send(truth_on_the_wire(header, perception.vehicles(), ended))?;
        let acquired = Header { acquisition_ns: list.acquisition_ns, ..header };
        output.send(acquired, &perception)?;
        tracks.send(tracks_on_the_wire(acquired, &list))?;

        let seen = odometry.newest().is_some();
        runtime.end_cycle(if seen { ServiceState::Running } else { ServiceState::Degraded })?;
        Ok(Cycle::Next)
    })?;
    runtime.finish(Details::Perception(Box::new(perception.report())))
}

/// Where the radar writes its detections, and what sends them.
struct DetectionOutput {
    message: Box<RadarDetections>,
    /// Entries that the last scan has written.
    written: usize,
    port: Option<Publisher<RadarDetections>>,
}

impl DetectionOutput {
    fn new() -> Self {
        Self { message: Box::new(RadarDetections::zeroed()), written: 0, port: None }
    }

    /// Sends what the radar has written, if its model has detections.
    fn send(&mut self, header: Header, perception: &Perception) -> Result<(), RuntimeError> {
        let Some(port) = &mut self.port else { return Ok(()) };
        let received = perception.received();
        if let Some(stale) = self.message.detections.get_mut(received.count..self.written) {
            stale.fill(Detection::zeroed());
        }
        self.written = received.count;
        self.message.header = header;
        self.message.ego_speed_mps = perception.scanned().ego.speed_mps;
        self.message.left_out = received.left_out;
        self.message.count = received.count as u64;
        port.send(*self.message)
    }
}

/// The radar measures from where the ego is, not from where it was last heard of.
fn ego_at(odometry: &Odometry, time_s: f64) -> Ego {
    let (position_m, speed_mps) = odometry.moved_to(time_s);
    Ego { position_m, speed_mps, acceleration_mps2: odometry.acceleration_mps2 }
}

fn truth_on_the_wire(header: Header, vehicles: &[Vehicle], ended: bool) -> VehicleTruth {
    let mut message = VehicleTruth { header, ended: ended.into(), ..VehicleTruth::zeroed() };
    let present = vehicles.iter().filter(|vehicle| vehicle.present).take(MAX_TRACKS);
    for (item, vehicle) in message.vehicles.iter_mut().zip(present) {
        *item = VehicleTruthItem {
            in_lane: vehicle.in_ego_path().into(),
            rear_position_m: vehicle.rear_position_m,
            speed_mps: vehicle.speed_mps,
            acceleration_mps2: vehicle.acceleration_mps2,
            lateral_m: vehicle.lateral_m,
        };
        message.count += 1;
    }
    message
}

fn tracks_on_the_wire(header: Header, list: &TrackList) -> RadarTracks {
    let mut message = RadarTracks { header, ..RadarTracks::zeroed() };
    for (index, (wire, track)) in
        message.tracks.iter_mut().zip(&list.tracks[..list.count]).enumerate()
    {
        *wire = Track {
            id: track.id,
            in_path: (list.target == Some(index)).into(),
            range_m: track.range_m,
            range_rate_mps: track.range_rate_mps,
            azimuth_rad: track.azimuth_rad,
        };
        message.count += 1;
    }
    if let Some(target) = list.target.and_then(|index| list.tracks.get(index)) {
        message.target = TrackedTarget {
            valid: 1,
            track_id: target.id,
            gap_m: target.gap_m,
            relative_speed_mps: target.relative_speed_mps,
            acceleration_mps2: target.acceleration_mps2,
        };
    }
    message
}
