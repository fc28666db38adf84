//! The perception loop: move the traffic, scan, track, publish.

use crate::perception::Perception;
use crate::plane::PlanePorts;
use crate::poses::Poses;
use crate::radar::scene::Ego;
use crate::sumo_world::SumoWorld;
use crate::tracking::TrackList;
use crate::traffic::Snapshot;
use crate::vehicle::Vehicle;
use bytemuck::Zeroable;
use messages::{
    Detection, EgoTruth, Header, MAX_DETECTIONS, MAX_TRACKS, MoreVehicles, Odometry, Origins,
    RadarDetections, RadarTracks, ServiceState, Track, TrackedTarget, VehicleTruth,
    VehicleTruthItem,
};
use runtime::{Checkpoint, Cycle, Loan, Mode, Overrun, Publisher, Release, Runtime, RuntimeError};
use scenario::perception::RadarModel;

/// Age beyond which the tracker does not use odometry, ns.
const STALE_ODOMETRY_NS: i64 = 200_000_000;

/// Runs traffic and radar in their group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut perception = Perception::new(&scenario);
    let mut odometry = runtime.subscriber::<Odometry>()?;
    let mut ego_truth = runtime.subscriber::<EgoTruth>()?;
    let mut tracks = runtime.publisher::<RadarTracks>()?;
    let mut truth = runtime.publisher::<VehicleTruth>()?;
    let has_more = scenario.actors.len() > MAX_TRACKS;
    let mut more = has_more.then(|| runtime.publisher::<MoreVehicles>()).transpose()?;
    let mut plane = PlanePorts::open(&mut runtime, &scenario)?;
    let mut poses = Poses::open(&mut runtime, &scenario)?;
    let mut output = DetectionOutput::open(&mut runtime, scenario.perception.model())?;
    let mut sumo = SumoWorld::open(&mut runtime, &scenario)?;
    let start = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
    let mut checkpoint = match runtime.clock().mode {
        Mode::Realtime => Some(runtime.checkpoint::<Snapshot>()?),
        Mode::Lockstep => None,
    };
    if runtime.is_restarted()
        && let Some(kept) = checkpoint.as_mut().and_then(Checkpoint::restore)
    {
        perception.traffic.restore(&kept);
    }
    runtime.begin(&scenario)?;
    runtime.run_cycles(|runtime| {
        let Some(release) = runtime.next_release(Overrun::Skip)? else { return Ok(Cycle::Last) };
        runtime.update(&mut odometry)?;
        runtime.update(&mut ego_truth)?;
        if let Some(plane) = &mut plane {
            plane.update(runtime)?;
        }
        // The radar measures from the ego's true place, not from that of its last message.
        let ego = ego_truth.newest().map_or(start, |truth| {
            let (position_m, speed_mps) = truth.moved_to(release.time_s);
            Ego { position_m, speed_mps, acceleration_mps2: truth.acceleration_mps2 }
        });
        let told = told_at(odometry.newest(), start, &release);
        let time_ns = release.scheduled_ns.unsigned_abs();
        if runtime.is_standby() {
            follow(&mut perception, checkpoint.as_mut(), time_ns);
        }
        let mut detections = output.loan()?;
        let room = output.room(detections.as_mut());
        let in_plane = plane.as_ref().map(|plane| plane.ego(&ego, ego_truth.newest(), &release));
        if let (Some(sumo), Some(in_plane)) = (&mut sumo, &in_plane) {
            sumo.advance(time_ns, &ego, in_plane, &mut perception.traffic)?;
        }
        let map = plane.as_ref().and_then(|plane| plane.map(told));
        let list = *perception.step_in_plane(time_ns, &ego, told, in_plane, map.as_ref(), room);
        if let Some(checkpoint) = checkpoint.as_mut().filter(|_| !runtime.is_standby()) {
            checkpoint.save(&perception.traffic.snapshot())?;
        }

        // Others wait for tracks and detections: these go first, the smaller before the larger.
        let origins = Origins { odometry: odometry.origin(), ..Origins::NONE };
        let header = Header::new(release.step, release.scheduled_ns, origins);
        let acquired = Header { acquisition_ns: list.acquisition_ns, ..header };
        let measured = perception.ego_speed.measured;
        let seen_share = perception.seen_share();
        tracks.send_with(|message| {
            write_tracks(message, acquired, &list, measured);
            message.seen_share = seen_share;
        })?;
        if let Some(detections) = detections {
            output.send(detections, acquired, &perception)?;
        }
        let (vehicles, ended) = (perception.vehicles(), perception.is_over());
        // A reader with the first message of the vehicles has both.
        if let Some(more) = &mut more {
            more.send_with(|message| {
                message.header = header;
                message.count = write_vehicles(&mut message.vehicles, vehicles, MAX_TRACKS);
            })?;
        }
        truth.send_with(|message| {
            (message.header, message.ended) = (header, ended.into());
            message.count = write_vehicles(&mut message.vehicles, vehicles, 0);
        })?;
        if let Some(plane) = &mut plane {
            plane.send(acquired, perception.road_ahead())?;
        }
        if let Some(poses) = &mut poses {
            poses.send(header, vehicles)?;
        }
        if let Some(sumo) = &mut sumo {
            sumo.send(header, ego.position_m)?;
        }

        let seen = odometry.newest().is_some();
        runtime.end_cycle(if seen { ServiceState::Running } else { ServiceState::Degraded })?;
        Ok(Cycle::Next)
    })?;
    runtime.finish(perception.report())
}

/// Takes the traffic as the active process has it: there is one, and a standby does not move it.
fn follow(perception: &mut Perception, kept: Option<&mut Checkpoint<Snapshot>>, time_ns: u64) {
    let kept = kept.and_then(Checkpoint::restore);
    // A standby that is late by a period finds a state later than its own step.
    if let Some(kept) = kept.filter(|kept| kept.newest_ns() <= time_ns) {
        perception.traffic.restore(&kept);
    }
}

/// Room for the radar's detections, and their publisher.
struct DetectionOutput {
    port: Option<Publisher<RadarDetections>>,
    /// Room for the output of a radar model without detections.
    unused: Box<[Detection; MAX_DETECTIONS]>,
}

impl DetectionOutput {
    fn open(runtime: &mut Runtime, model: RadarModel) -> Result<Self, RuntimeError> {
        let port = match model {
            RadarModel::Detections => Some(runtime.publisher()?),
            RadarModel::ObjectList | RadarModel::Ideal => None,
        };
        Ok(Self { port, unused: Box::new([Detection::zeroed(); MAX_DETECTIONS]) })
    }

    /// The next message, if the radar's model has detections; it holds an earlier one.
    fn loan(&self) -> Result<Option<Loan<RadarDetections>>, RuntimeError> {
        self.port.as_ref().map(Publisher::loan_used).transpose()
    }

    fn room<'a>(
        &'a mut self,
        message: Option<&'a mut Loan<RadarDetections>>,
    ) -> &'a mut [Detection; MAX_DETECTIONS] {
        match message {
            Some(message) => &mut message.detections,
            None => &mut self.unused,
        }
    }

    /// Sends what the radar has written into `message`.
    fn send(
        &mut self,
        mut message: Loan<RadarDetections>,
        header: Header,
        perception: &Perception,
    ) -> Result<(), RuntimeError> {
        let Some(port) = &mut self.port else { return Ok(()) };
        let received = perception.received;
        // Clear leftovers of the previous message; the rest is already zero.
        let before = message.detections().len();
        if let Some(left_over) = message.detections.get_mut(received.count..before) {
            left_over.fill(Detection::zeroed());
        }
        message.header = header;
        message.ego_speed_mps = perception.known.speed_mps;
        message.left_out = received.left_out;
        message.count = received.count as u64;
        port.send(message).map(|_| ())
    }
}

/// The ego by its odometry; `None` if that is too old.
fn told_at(odometry: Option<&Odometry>, start: Ego, release: &Release) -> Option<Ego> {
    let Some(odometry) = odometry else { return Some(start).filter(|_| release.step == 0) };
    if release.scheduled_ns - odometry.header.acquisition_ns > STALE_ODOMETRY_NS {
        return None;
    }
    let (position_m, speed_mps) = odometry.moved_to(release.time_s);
    Some(Ego { position_m, speed_mps, acceleration_mps2: odometry.acceleration_mps2 })
}

/// Writes the vehicles that are present, but for the first `skipped`; returns how many.
fn write_vehicles(room: &mut [VehicleTruthItem], vehicles: &[Vehicle], skipped: usize) -> u64 {
    let present = vehicles.iter().filter(|vehicle| vehicle.present).skip(skipped);
    let mut count = 0;
    for (item, vehicle) in room.iter_mut().zip(present) {
        *item = VehicleTruthItem {
            in_lane: vehicle.in_ego_path().into(),
            rear_position_m: vehicle.rear_position_m,
            speed_mps: vehicle.speed_mps,
            acceleration_mps2: vehicle.acceleration_mps2,
            lateral_m: vehicle.lateral_m,
        };
        count += 1;
    }
    count
}

fn write_tracks(
    message: &mut RadarTracks,
    header: Header,
    list: &TrackList,
    measured: Option<(f64, u64)>,
) {
    message.header = header;
    (message.ego_speed_mps, message.ego_speed_points) = measured.unwrap_or_default();
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
            doubt_share: target.doubt_share,
        };
    }
}
