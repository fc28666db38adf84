//! Planning in the background, in a thread of its own.
//!
//! A plan takes longer than a cycle may. The law asks for one after a step; a background thread makes it;
//! [`DELAY_CYCLES`] releases later it takes effect. Until then, and when it is late, the law drives by its present
//! plan. It takes the age of that into account.

use crate::law::{Law, Plan, PlanRequest};
use crate::report::PlanningReport;
use runtime::{BackgroundWorker, Release, Runtime, RuntimeError, WorkerReport};

/// Control cycles from the question to the plan's effect.
pub(crate) const DELAY_CYCLES: i64 = 2;

/// The loop's side of the planning thread.
pub(crate) struct PlanningThread {
    worker: BackgroundWorker<PlanRequest, Plan>,
    /// A request that the thread could not take.
    unsent: Option<PlanRequest>,
}

impl PlanningThread {
    /// The thread of a law that plans; `None` for the others.
    pub(crate) fn start(
        runtime: &Runtime,
        law: &mut dyn Law,
        period_ns: i64,
    ) -> Result<Option<Self>, RuntimeError> {
        let Some(planning) = law.planning() else { return Ok(None) };
        let mut planner = planning.planner();
        let work = move |request: &PlanRequest| {
            let mut plan = Plan::default();
            // An empty plan means "no plan".
            planner.plan(request, &mut plan);
            plan
        };
        let worker = BackgroundWorker::start(runtime, "planner", DELAY_CYCLES * period_ns, work)?;
        Ok(Some(Self { worker, unsent: None }))
    }

    /// Before a step: hands over the plan that takes effect now.
    pub(crate) fn before_step(&mut self, law: &mut dyn Law, release: &Release) {
        if let Some(plan) = self.worker.answer(release)
            && let Some(planning) = law.planning()
        {
            planning.accept(&plan);
        }
    }

    /// After a step: asks for the plan that the law needs.
    pub(crate) fn after_step(&mut self, law: &mut dyn Law, release: &Release) {
        if self.worker.is_busy() {
            return;
        }
        let wanted = || law.planning().and_then(|planning| planning.request());
        if let Some(request) = self.unsent.take().or_else(wanted) {
            self.unsent = self.worker.ask(release, request).err();
        }
    }

    pub(crate) fn report(&self) -> PlanningReport {
        let WorkerReport { asked, late, deadline_us, worked_us } = self.worker.report();
        PlanningReport { asked, late, deadline_us, plan_us: worked_us }
    }
}
