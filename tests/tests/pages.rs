//! The pages of results in a real browser.

use serde_json::{Value, json};
use std::process::ExitCode;
use system_tests::browser::{Browser, chromium};
use system_tests::cases::{self, needing};
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Number of non-empty chart canvases of a completely drawn page.
const DRAWN: &str = "[...document.querySelectorAll('.chart canvas')].filter((canvas) =>
    canvas.width && canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data
        .some((channel) => channel > 0)).length";
/// Number of visible charts of the page.
const CHARTS: &str = "document.querySelectorAll('.chart').length";
/// Place of the first chart's axes in the window, and the values in its legend.
const FIRST: &str = "(() => { const box = document.querySelector('.u-over').getBoundingClientRect();
    return { left: box.left, top: box.top, width: box.width, height: box.height,
        values: [...document.querySelector('.u-legend').querySelectorAll('.u-value')].map((cell) => cell.textContent) }; })()";
/// Ranges of the horizontal axes of the charts over time.
const RANGES: &str =
    "[...timegap.drawn.values()].filter((plot) => plot.axes[0].label === 'time, s')
    .map((plot) => [plot.scales.x.min, plot.scales.x.max])";

/// Opens the page of a short run and waits until its charts are drawn.
fn open(corner: &Corner, number: usize) -> Browser {
    let page = corner.path().join("out/report.html");
    let mut browser = Browser::open(corner, number, &format!("file://{}", page.display()));
    assert!(
        browser.becomes(&format!("{CHARTS} > 5 && {DRAWN} === {CHARTS}")),
        "{:?}",
        browser.errors()
    );
    browser
}

fn run(corner: &Corner) {
    let arguments = ["run", "cut-in", "--mode", "lockstep", "--duration", "20", "--out", "out"];
    let output = corner.run(&arguments);
    assert!(output.status.success(), "{}", text(&output));
}

fn float(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn the_pointer_shows_values_and_a_zoom_is_linked() {
    let corner = Corner::new(PROGRAM);
    run(&corner);
    let mut browser = open(&corner, 0);
    browser.evaluate("document.querySelector('.u-over').scrollIntoView({ block: 'center' })");
    let first = browser.evaluate(FIRST);
    let [left, top, width, height] =
        ["left", "top", "width", "height"].map(|key| float(&first[key]));
    assert_eq!(first["values"][0], "–", "no pointer, no value: {first}");
    let at = |share: f64| (left + share * width, top + 0.5 * height);
    browser.mouse("mouseMoved", at(0.5));
    let speed = format!("Number({FIRST}.values[0]) > 1");
    assert!(browser.becomes(&speed), "{}", browser.evaluate(FIRST));
    browser.mouse("mousePressed", at(0.25));
    browser.mouse("mouseMoved", at(0.5));
    browser.mouse("mouseReleased", at(0.5));
    let zoomed = format!(
        "{RANGES}.every(([low, high]) => Math.abs(low - 5) < 0.5 && Math.abs(high - 10) < 0.5)"
    );
    assert!(browser.becomes(&zoomed), "{}", browser.evaluate(RANGES));
    assert!(browser.evaluate(RANGES).as_array().is_some_and(|ranges| ranges.len() > 5));
    browser.evaluate("document.querySelector('.whole').click()");
    let whole = format!("{RANGES}.every(([low, high]) => low === 0 && high === 20)");
    assert!(browser.becomes(&whole), "{}", browser.evaluate(RANGES));
    // A click on its name hides a series.
    browser.evaluate("document.querySelector('.u-series th').click()");
    assert!(browser.becomes("document.querySelectorAll('.u-off').length > 0"));
    assert_eq!(browser.errors(), [""; 0]);
    browser.close();
}

fn a_page_fits_a_telephone_and_the_dark() {
    let corner = Corner::new(PROGRAM);
    run(&corner);
    let mut browser = open(&corner, 0);
    let telephone = json!({ "width": 400, "height": 800, "deviceScaleFactor": 2, "mobile": true });
    browser.call("Emulation.setDeviceMetricsOverride", telephone);
    let narrow = "document.documentElement.scrollWidth <= 400 &&
        [...timegap.drawn.values()].every((plot) => plot.width < 400)";
    assert!(
        browser.becomes(narrow),
        "{}",
        browser.evaluate("document.documentElement.scrollWidth")
    );
    let ground = "getComputedStyle(document.body).backgroundColor";
    let axis = "timegap.drawn.values().next().value.axes[0].stroke()";
    let light = [browser.evaluate(ground), browser.evaluate(axis)];
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.call("Emulation.setEmulatedMedia", dark);
    let dark = [browser.evaluate(ground), browser.evaluate(axis)];
    assert!(light[0] != dark[0] && light[1] != dark[1], "{light:?} {dark:?}");
    assert!(browser.becomes(&format!("{DRAWN} === {CHARTS}")), "drawn again");
    assert_eq!(browser.errors(), [""; 0]);
    browser.close();
}

fn a_curved_road_is_drawn_from_above() {
    let corner = Corner::new(PROGRAM);
    let words =
        ["run", "curved-following", "--mode", "lockstep", "--duration", "30", "--out", "out"];
    let output = corner.run(&words);
    assert!(output.status.success(), "{}", text(&output));
    let mut browser = open(&corner, 0);
    // The whole way and the close-up, with ego and three others.
    let bodies = "document.querySelectorAll('.plane svg')[1]?.querySelectorAll('rect').length";
    assert!(browser.becomes(&format!("{bodies} === 4")), "{}", browser.evaluate(bodies));
    let said = "document.querySelector('.plane output').textContent";
    let worst = browser.evaluate(said);
    assert!(worst.as_str().is_some_and(|said| said.contains("the least")), "{worst}");
    let move_to_start = "(() => { const slider = document.querySelector('.plane .instant');
        slider.value = 0; slider.dispatchEvent(new Event('input')); })()";
    browser.evaluate(move_to_start);
    assert!(browser.becomes(&format!("{said}.startsWith('0.0')")), "{}", browser.evaluate(said));
    let telephone = json!({ "width": 400, "height": 800, "deviceScaleFactor": 2, "mobile": true });
    browser.call("Emulation.setDeviceMetricsOverride", telephone);
    let narrow = "document.documentElement.scrollWidth <= 400 &&
        [...document.querySelectorAll('.plane svg')].every((svg) => svg.getBoundingClientRect().width < 400)";
    assert!(
        browser.becomes(narrow),
        "{}",
        browser.evaluate("document.documentElement.scrollWidth")
    );
    assert_eq!(browser.errors(), [""; 0]);
    browser.close();
}

fn a_page_without_scripts_shows_verdict_and_tables() {
    let corner = Corner::new(PROGRAM);
    run(&corner);
    let mut browser = Browser::open(&corner, 0, "about:blank");
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    let page = format!("file://{}", corner.path().join("out/report.html").display());
    browser.call("Page.navigate", json!({ "url": page }));
    // The protocol evaluates also where the page may not.
    assert!(browser.becomes(
        "document.readyState === 'complete' && document.querySelector('.verdict') !== null"
    ));
    // The text of a page that is not laid out yet is empty. Browsers differ in the case of a styled first letter.
    for part in ["ompleted: 20.0 s", "charts need JavaScript", "topic"] {
        let shown = format!("document.body.innerText.includes({part:?})");
        let text = "document.body.innerText";
        assert!(browser.becomes(&shown), "{part} in {}", browser.evaluate(text));
    }
    assert_eq!(browser.evaluate("document.querySelectorAll('canvas').length"), 0);
    browser.close();
}

fn main() -> ExitCode {
    cases::run(&[
        needing(
            chromium,
            "the_pointer_shows_values_and_a_zoom_is_linked",
            the_pointer_shows_values_and_a_zoom_is_linked,
        ),
        needing(
            chromium,
            "a_page_fits_a_telephone_and_the_dark",
            a_page_fits_a_telephone_and_the_dark,
        ),
        needing(chromium, "a_curved_road_is_drawn_from_above", a_curved_road_is_drawn_from_above),
        needing(
            chromium,
            "a_page_without_scripts_shows_verdict_and_tables",
            a_page_without_scripts_shows_verdict_and_tables,
        ),
    ])
}
