//! The numbers of the decision, each with its origin.
//!
//! To brake for nothing costs something too: who follows may not stop in time. The decision brakes when the expected
//! cost of not braking is the greater one:
//!
//! ```text
//! P (c + Δv) > (1 - P) (c + f)          P: probability of the contact, Δv: closing speed
//!                                       c: cost of any contact at all, f: closing speed of a contact
//! P > (c + f) / (2 c + f + Δv)             that is as bad as braking for nothing
//! ```
//!
//! The effects are those of `DRIVES=60 cargo test -p aebs --test drives -- --ignored --nocapture`: 60 drives of each of
//! five kinds. The brake acts in 163 of the 300. No collision is avoidable, and no intervention needless.
//!
//! The cut-ins of UN R157 show more. With `severe_mps` 5 and `better_share` 1 together 25 of 500 cases collide instead
//! of 18 (`timegap test r157 --matrix cut-in --sample 500 --controllers acc-mpc`).
//!
//! ```
//! use aebs::numbers::Numbers;
//!
//! let numbers = Numbers::DEFAULT;
//! assert!(numbers.likely(20.0) < numbers.likely(5.0), "the faster the contact, the less sure it has to be");
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the decision.
    pub struct Numbers {
        /// Time for which the brakes are held after a stop.
        hold_s: f64 = 1.0, "s", 0.0..=10.0, "Chosen: the driver has that time to take over; no contact depends on it. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Time for which the brake acts on a threat that is no longer seen.
        unseen_s: f64 = 0.3, "s", 0.0..=2.0, "Chosen: six scans of 50 ms, as long as an object outlives its last echo. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Deceleration that the last point counts on.
        counted_on_mps2: f64 = 6.0, "m/s²", 3.0..=12.0, "Chosen: braking that any dry road gives; the rest of the authority is the reserve for a lead that begins to brake. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Braking of driver and law with which nothing need be kept in reserve for a lead.
        answer_mps2: f64 = 2.5, "m/s²", 0.5..=6.0, "Chosen: as hard as the plant's own stop in lane. Where it is enough, there is time for an answer to a lead that begins to brake. A fifth less changes no total of 300 random drives; a fifth more: 1 avoidable collision instead of 0.";
        /// Braking that a lead may begin with while the ego's own answer is not enough.
        lead_may_brake_mps2: f64 = 4.0, "m/s²", 0.0..=9.0, "Chosen: a minimum risk manoeuvre (UN R157, 5.5.1); harder braking of a vehicle that just came in is rare. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Time until the braking of a lead is known.
        notices_s: f64 = 0.25, "s", 0.0..=2.0, "Found: the objects show hard braking within that time (objects/tests.rs). A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Distance beyond the margin at which the ego is clear without brakes.
        clear_m: f64 = 0.5, "m", 0.0..=5.0, "Chosen: five standard deviations of a range. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// A pass that leaves less than this behind it counts as a contact.
        pass_margin_m: f64 = 1.0, "m", 0.0..=5.0, "Chosen: as much as the end of a vehicle is uncertain. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Speed below which the ego or another vehicle stands.
        standstill_mps: f64 = 0.05, "m/s", 0.0..=0.5, "Chosen: half of the resolution of a wheel speed sensor. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Cost of any contact, as a closing speed.
        contact_cost_mps: f64 = 5.0, "m/s", 0.5..=20.0, "Chosen: a contact at this closing speed counts twice a touch. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Closing speed of a contact that is as bad as braking for nothing.
        false_cost_mps: f64 = 4.3, "m/s", 0.5..=20.0, "Chosen: with the cost of a contact it gives the probabilities 0.65, 0.35 and 0.2 at three closing speeds. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Largest share of the expected loss that is left for braking to be worth while.
        better_share: f64 = 0.6, "1", 0.1..=1.0, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Probability from which a contact is as good as certain: to make it milder is reason enough.
        certain: f64 = 0.9, "1", 0.5..=1.0, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Probability up to which a contact is not to be feared yet.
        remote: f64 = 0.05, "1", 0.001..=0.5, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Probability up to which the ego is clear of a contact.
        clear_probability: f64 = 0.1, "1", 0.001..=0.5, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Probability up to which an object is of no interest.
        of_no_interest: f64 = 0.01, "1", 0.0..=0.1, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Closing speed whose loss is twice that of the lightest contact.
        severe_mps: f64 = 60.0, "m/s", 5.0..=200.0, "Chosen: contacts count more than their speed. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Lateral speed below which a motion may be wandering within the lane.
        wandering_mps: f64 = 0.8, "m/s", 0.1..=3.0, "Chosen: three times the standard deviation of lane keeping. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Rate at which a lateral motion ceases at standstill.
        ceases_per_s: f64 = 0.6, "1/s", 0.0..=5.0, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Time before a contact from which an object on a row that crosses the way is braked for.
        steer_s: f64 = 1.0, "s", 0.0..=5.0, "Chosen: to move 2 m aside with 4 m/s² takes that long. A road that bends along the row would bend by then. A fifth more or less leaves the totals of 300 random drives unchanged.";
        /// Distance of its middle from the ego's axis from which something may be leaving.
        leaving_offset_m: f64 = 0.8, "m", 0.0..=3.0, "Chosen. A fifth more or less leaves the totals of 300 random drives unchanged.";
    }
}

impl Numbers {
    /// Least probability of a contact to brake for at a closing speed.
    #[must_use]
    pub fn likely(&self, closing_mps: f64) -> f64 {
        let for_nothing = self.contact_cost_mps + self.false_cost_mps;
        for_nothing / (for_nothing + self.contact_cost_mps + closing_mps.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_costs_of_both_mistakes_are_equal_at_the_limit() {
        let numbers = Numbers::DEFAULT;
        for closing_mps in [0.0, 4.3, 12.0, 30.0] {
            let p = numbers.likely(closing_mps);
            let (contact, braking) = (
                p * (numbers.contact_cost_mps + closing_mps),
                (1.0 - p) * (numbers.contact_cost_mps + numbers.false_cost_mps),
            );
            assert!((contact - braking).abs() < 1e-9, "{closing_mps}");
        }
        assert_eq!(numbers.likely(-5.0), numbers.likely(0.0));
    }
}
