//! The plant's part of a road with a plan: motion across the road, and its messages.

use messages::{
    AllVehicles, EgoPose, Header, LateralMotion, MAX_TRACKS, MorePoses, VehiclePoses, all_poses,
};
use runtime::{Publisher, Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use scenario::event::VEHICLE_WIDTH_M;

use crate::contact::{Rectangle, closing_at_contact};
use crate::ego::Ego;
use crate::lateral::Lateral;
use crate::longitudinal::State;
use crate::numbers::Numbers;
use crate::referee::InPlane;

/// Distance of two bodies' middles up to which contact is looked for, m. Chosen: two half lorries of 16.5 m and the way
/// of two periods.
const CONTACT_WITHIN_M: f64 = 30.0;

/// Motion across the road with its ports.
pub(super) struct Plane {
    pub(super) lateral: Lateral,
    sensors: Publisher<LateralMotion>,
    pose: Publisher<EgoPose>,
    others: Subscriber<VehiclePoses>,
    more: Option<Subscriber<MorePoses>>,
    length_m: f64,
}

impl Plane {
    /// Opens the ports; `None` without a plan of the road.
    pub(super) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let Some(lateral) = Lateral::of(scenario, &Numbers::DEFAULT) else { return Ok(None) };
        Ok(Some(Self {
            lateral,
            sensors: runtime.publisher()?,
            pose: runtime.publisher()?,
            others: runtime.subscriber()?,
            more: (scenario.actors.len() > MAX_TRACKS).then(|| runtime.subscriber()).transpose()?,
            length_m: scenario.plant.length_m.value(),
        }))
    }

    pub(super) fn publish(&mut self, header: Header, ego: &State) -> Result<(), RuntimeError> {
        let lateral = &self.lateral;
        self.sensors.send_with(|message| {
            message.header = header;
            lateral.measure(message);
        })?;
        self.pose.send_with(|message| {
            message.header = header;
            lateral.write(ego, message);
        })?;
        Ok(())
    }

    pub(super) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        if let Some(more) = &mut self.more {
            runtime.update(more)?;
        }
        runtime.update(&mut self.others)
    }

    /// The ego across the road at a release, for the referee.
    pub(super) fn sample(
        &self,
        release: &Release,
        ego: &State,
        vehicles: Option<&AllVehicles>,
    ) -> InPlane {
        let state = self.lateral.state;
        let body = || {
            let front = self.lateral.placed(ego.position_m);
            Rectangle::behind(&front, self.length_m, VEHICLE_WIDTH_M)
        };
        let more = self.more.as_ref().and_then(Subscriber::newest);
        let posed = self.others.newest().and_then(|first| {
            let age_s = release.time_s - first.header.acquisition_ns as f64 / 1e9;
            all_poses(first, more).map(|poses| (age_s, poses))
        });
        let closing_at_contact_mps = vehicles.zip(posed).and_then(|(vehicles, (age_s, poses))| {
            closing_at_contact(
                &body(),
                ego.speed_mps,
                age_s,
                vehicles.vehicles.iter().zip(poses),
                CONTACT_WITHIN_M,
            )
        });
        InPlane {
            lateral_m: state.lateral_m,
            lateral_acceleration_mps2: state.lateral_acceleration_mps2,
            closing_at_contact_mps,
        }
    }

    /// Moves on by the period in which the ego moved from `from` to where it is.
    pub(super) fn step(&mut self, from: &State, ego: &mut Ego) {
        if let Some(position_m) = self.lateral.step(from, &ego.state()) {
            ego.place(position_m);
        }
    }
}
