//! Laws behind a lead, in a closed loop with radar noise, latency and a tracker. The leads brake
//! hard, or stop and go. No emergency brake helps.

mod braking_leads;
mod kinds;
mod stop_and_go;
mod tracker;
mod world;
