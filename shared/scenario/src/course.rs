//! `[perception.course]`: what the path ahead is predicted from.

use serde::{Deserialize, Serialize};

use super::problem::Problem;
use super::schema::Schema;

/// The estimate of the axis ahead on a road with a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Course {
    /// Its sources; an empty list: the straight path.
    pub sources: Vec<CourseSource>,
}

/// A source of the course.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
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

impl Default for Course {
    fn default() -> Self {
        Self { sources: vec![CourseSource::YawRate, CourseSource::Standing, CourseSource::Trails] }
    }
}

impl Course {
    /// True if the source is used.
    #[must_use]
    pub fn uses(&self, source: CourseSource) -> bool {
        self.sources.contains(&source)
    }

    /// True if the sources are the usual ones.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// A source counts once.
    pub(super) fn check(&self) -> Result<(), Problem> {
        let again = (1..self.sources.len())
            .find(|&index| self.sources[..index].contains(&self.sources[index]));
        again.map_or(Ok(()), |index| {
            let path = format!("perception.course.sources.{index}");
            Err(Problem::new(path, "this source stands here twice", "each source once"))
        })
    }
}
