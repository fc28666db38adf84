//! The planners by their kind.

use super::dynamic_programming::DynamicProgramming;
use super::paper_n2::PaperN2;
use super::settings::PlannerKind;
use crate::law::{Plan, PlanRequest, Planner};
use truck_model::Truck;

/// A planner for `truck`; one that never has a plan for constant speed.
#[must_use]
pub fn create(kind: PlannerKind, truck: &Truck) -> Box<dyn Planner> {
    match kind {
        PlannerKind::DynamicProgramming => Box::new(DynamicProgramming::new(truck)),
        PlannerKind::PaperN2 => Box::new(PaperN2::new(truck)),
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
