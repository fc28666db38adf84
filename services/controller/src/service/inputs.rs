//! The topics that the loop reads.

use super::curves::CurveTopics;
use messages::{
    AnnouncedMotions, Map, Odometry, Origin, Origins, Powertrain, Preview, RadarTracks, Spat,
};
use runtime::{Runtime, RuntimeError, Subscriber};
use scenario::{Scenario, controller};

pub(super) struct Inputs {
    pub(super) odometry: Subscriber<Odometry>,
    pub(super) radar: Subscriber<RadarTracks>,
    pub(super) spat: Subscriber<Spat>,
    pub(super) map: Subscriber<Map>,
    /// Motions of the other egos in a net.
    pub(super) motions: Option<Subscriber<AnnouncedMotions>>,
    /// A truck's alone.
    truck: Option<(Subscriber<Powertrain>, Subscriber<Preview>)>,
    /// Those of a road with a plan.
    pub(super) curves: Option<CurveTopics>,
}

impl Inputs {
    pub(super) fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Ok(Self {
            odometry: runtime.subscriber()?,
            radar: match scenario.controller.release {
                controller::Release::Radar => runtime.releasing_subscriber()?,
                controller::Release::Timer => runtime.subscriber()?,
            },
            spat: runtime.subscriber()?,
            map: runtime.subscriber()?,
            motions: scenario.traffic.route.as_ref().map(|_| runtime.subscriber()).transpose()?,
            truck: match scenario.plant.vehicle.is_truck() {
                true => Some((runtime.subscriber()?, runtime.subscriber()?)),
                false => None,
            },
            curves: CurveTopics::open(runtime, scenario)?,
        })
    }

    /// Takes the newest samples. The radar's comes first: after waiting for it the others are there.
    pub(super) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        runtime.update(&mut self.radar)?;
        runtime.update(&mut self.odometry)?;
        runtime.update(&mut self.spat)?;
        runtime.update(&mut self.map)?;
        if let Some(motions) = &mut self.motions {
            runtime.update(motions)?;
        }
        if let Some((powertrain, preview)) = &mut self.truck {
            runtime.update(powertrain)?;
            runtime.update(preview)?;
        }
        self.curves.as_mut().map_or(Ok(()), |curves| curves.update(runtime))
    }

    /// Engine and gears of a truck.
    pub(super) fn powertrain(&self) -> Option<&Powertrain> {
        self.truck.as_ref().and_then(|(powertrain, _)| powertrain.newest())
    }

    /// The road ahead of a truck.
    pub(super) fn preview(&self) -> Option<&Preview> {
        self.truck.as_ref().and_then(|(_, preview)| preview.newest())
    }

    /// Origins of the samples. The map of a road with a plan takes the place of a truck's preview.
    pub(super) fn origins(&self) -> Origins {
        let truck = self.truck.as_ref();
        Origins {
            odometry: self.odometry.origin(),
            radar: self.radar.origin(),
            spat: self.spat.origin(),
            map: self.map.origin(),
            powertrain: truck.map_or(Origin::NONE, |(powertrain, _)| powertrain.origin()),
            preview: match truck {
                Some((_, preview)) => preview.origin(),
                None => self.curves.as_ref().map_or(Origin::NONE, |curves| curves.map.origin()),
            },
        }
    }
}
