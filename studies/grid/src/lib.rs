//! Laws side by side on the same scenarios ([`compare`]), and figures as functions of any key ([`sweep`]).
//!
//! ```text
//! scenarios × laws × values of keys ─► cells × seeds ─► rows ─┬─ compare: A - B seed by seed, real differences
//!                                                             └─ points: mean ± spread, or the worst of the seeds
//! ```
//!
//! Both are studies with one engine (`cells`), one row a run (`row`), and one fold over the seeds (`point`).
//!
//! ```
//! let schema = grid::compare::schema().json();
//! let gap = &schema["properties"]["rows"]["items"]["properties"]["figures"]["properties"]["min_gap_m"];
//! assert_eq!(gap["description"], "Smallest gap to the vehicle ahead, m");
//! ```

pub mod compare;
mod row;
pub mod sweep;
