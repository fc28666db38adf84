//! Laws behind a lead, in a closed loop with radar noise, latency and a tracker: leads that brake
//! hard, and drive cycles. No emergency brake helps.

mod braking_leads;
mod tracker;
mod world;
