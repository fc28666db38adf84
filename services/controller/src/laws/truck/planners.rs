//! The planners by their kind.

use super::dynamic_programming::DynamicProgramming;
use super::paper_n2::PaperN2;
use super::settings::{PlannerKind, Settings};
use crate::law::{Plan, PlanRequest, Planner};

/// The planner of the settings; one that never has a plan for constant speed.
#[must_use]
pub fn create(settings: &Settings) -> Box<dyn Planner> {
    match settings.keys.planner {
        PlannerKind::DynamicProgramming => Box::new(DynamicProgramming::new(settings)),
        PlannerKind::PaperN2 => Box::new(PaperN2::new(settings)),
        PlannerKind::ConstantSpeed => Box::new(NoPlan),
    }
}

struct NoPlan;

impl Planner for NoPlan {
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool {
        plan.begin(request);
        false
    }
}
