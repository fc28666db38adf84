//! Laws side by side on the same scenarios ([`compare`]), and figures as functions of any key ([`sweep`]).
//!
//! ```text
//! compare: scenarios × laws × seeds ─► one table for each scenario; mean ± spread, real differences between laws
//! sweep:   keys × values × seeds ─► points: mean ± spread, or the worst of the seeds
//! ```
//!
//! Both are studies of `frame`, and a good pattern for a new one. The schemas of their results:
//!
//! ```
//! let schema = comparison::compare::schema().json();
//! let gap = &schema["properties"]["rows"]["items"]["properties"]["control"]["properties"]["min_gap_m"];
//! assert_eq!(gap["description"], "Smallest gap to the vehicle ahead, m");
//! ```

pub mod compare;
mod figure;
pub mod sweep;
