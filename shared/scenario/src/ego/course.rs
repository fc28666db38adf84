//! `[perception.course]`: what the path ahead is predicted from.

use scenario_derive::tables;

use crate::Problem;

tables! {
    /// The estimate of the axis ahead on a road with a plan.
    pub struct Course {
        /// Its sources; an empty list: the straight path.
        pub sources: Vec<CourseSource> = vec![CourseSource::YawRate, CourseSource::Standing, CourseSource::Trails],
        /// Their estimate: one course by a filter, or a belief in many hypotheses. The yaw rate alone makes a circle by
        /// both.
        #[sparse]
        pub road: RoadEstimate = default,
    }

    /// An estimate of the road ahead.
    pub enum RoadEstimate {
        /// A Kalman filter of one course.
        #[default]
        Filter,
        /// Weighted hypotheses.
        Belief,
    }

    /// A source of the course.
    pub enum CourseSource {
        /// The yaw rate and the speed of the ego.
        YawRate,
        /// Standing objects beside the road.
        Standing,
        /// Ways of the vehicles ahead.
        Trails,
        /// Curvatures of the map, `v2x/curves`.
        Map,
    }
}

impl Course {
    /// True if the source is used.
    #[must_use]
    pub fn uses(&self, source: CourseSource) -> bool {
        self.sources.contains(&source)
    }

    /// A source counts once.
    pub(crate) fn check(&self) -> Result<(), Problem> {
        let again = (1..self.sources.len())
            .find(|&index| self.sources[..index].contains(&self.sources[index]));
        again.map_or(Ok(()), |index| {
            let path = format!("perception.course.sources.{index}");
            Err(Problem::new(path, "this source stands here twice", "each source once"))
        })
    }
}
