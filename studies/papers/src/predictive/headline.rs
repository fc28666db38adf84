//! The headline: fuel and saving against a skilled driver, for each truck and planner.

use crate::row::{Row, Tolerance, paper, within};

/// Assumptions behind the rows, which the paper does not print.
const ROAD_AND_TRUCK: &str =
    "road and truck: the heights of the motorway near Qingdao and table 1 are not printed";
const DRIVER: &str =
    "the skilled driver: the paper's are statistics of real trips, ours a model of 2.5 km/h spread";

/// Fuel, L/100 km.
const WHOLE_LITRES: Tolerance = within(0.5, "\"about\", and printed in whole litres");
/// Saving on the paper's road, percent.
const ABOUT: Tolerance = within(
    1.1,
    "\"about\": the printed 20 and 22 L make 9.1 %, 1.1 points more than the printed 8 %",
);
/// Saving over all roads, percent.
const PRINTED_RANGE: Tolerance = within(1.0, "printed as the range 6 to 8 %");

/// The rows of one truck and planner: `litres` at constant speed, then changes of fuel against it at equal trip time
/// (percent).
pub fn rows(
    set: &str,
    litres: Option<f64>,
    planner_percent: Option<f64>,
    driver_percent: Option<f64>,
) -> [Row; 4] {
    let fuel = |percent: Option<f64>| Some(litres? * (1.0 + percent? / 100.0));
    let (ours, driver) = (fuel(planner_percent), fuel(driver_percent));
    let saving = ours.zip(driver).map(|(ours, driver)| 100.0 * (1.0 - ours / driver));
    let rows = [
        Row::near("headline.fuel_l_per_100km", "L", paper(20.0), ours, WHOLE_LITRES)
            .with_source("fuel per 100 km in this test is about 20 L")
            .depending_on(ROAD_AND_TRUCK),
        Row::near("headline.driver_l_per_100km", "L", paper(22.0), driver, WHOLE_LITRES)
            .with_source("a skilled driver's fuel on the same road (about 22 L)")
            .depending_on(DRIVER),
        Row::near("headline.saving", "%", paper(8.0), saving, ABOUT)
            .with_source("the predictive control saves about 8 %")
            .depending_on(DRIVER),
        Row::near("headline.saving_overall", "%", paper(7.0), saving, PRINTED_RANGE)
            .with_source("more than 1.3 million km; 6 to 8 % less than skilled drivers over all")
            .depending_on(DRIVER),
    ];
    rows.map(|row| row.in_set(set).with_note("at the trip time of constant speed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_saving_is_against_the_driver() {
        let rows = rows("truck", Some(20.0), Some(-4.0), Some(4.0));
        let ours = rows.map(|row| row.ours.expect("it is known"));
        let expected = [19.2, 20.8, 100.0 * (1.0 - 0.96 / 1.04), 100.0 * (1.0 - 0.96 / 1.04)];
        assert!(ours.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{ours:?}");
    }
}
