//! The predictive truck on whole roads and behind a lead, against the figures of the paper's page.

mod following;
mod maps;
mod planners;
mod reference;
mod roads;
mod savings;
