//! Records as people have them.

use super::*;
use crate::quantity::{Duration, TimeConstant, TimeShift};

fn keys(columns: &str) -> CsvFile {
    CsvFile { columns: Some(columns.into()), ..CsvFile::default() }
}

fn refusal(text: &str, keys: &CsvFile) -> String {
    let record = read_text("lead.csv", text, keys);
    let whole = record.and_then(|record| Ok(record.expect_whole()?));
    whole.expect_err("the record is wrong").to_string()
}

fn points(text: &str, keys: &CsvFile) -> Vec<(f64, f64)> {
    let record = read_text("lead.csv", text, keys).unwrap_or_else(|error| panic!("{error}"));
    record.profile().collect()
}

#[test]
fn columns_are_found_by_name() {
    let text = "# a drive\nnote, speed_mps ,time_s\nx, 1.5 ,0\n\ny,2,0.1\r\n";
    assert_eq!(points(text, &CsvFile::default()), [(0.0, 1.5), (0.1, 2.0)]);
}

#[test]
fn faults_are_shown_where_they_are() {
    let usual = CsvFile::default();
    for (text, expected) in [
        ("time_s,speed_mps\n0,1\n0.0,2\n", "lead.csv:3:1: times must increase"),
        ("time_s,speed_mps\n1,1\n0.5,2\n", "lead.csv:3:1: times must increase"),
        ("time_s,speed_mps\nNaN,1\n", "lead.csv:2:1: NaN is out of range"),
        ("time_s,speed_mps\n0,NaN\n", "lead.csv:2:3: NaN is out of range"),
        ("time_s,speed_mps\n0,-1\n", "lead.csv:2:3: -1 is out of range"),
        ("time_s,speed_mps\n0, fast\n", "lead.csv:2:4: `fast` is not a number"),
        ("time_s,speed_mps\n0\n", "lead.csv:2:1: no `speed_mps` in this line"),
        ("t,v\n0,1\n", "columns: lead.csv has no columns `time_s,speed_mps`, expected t=NAME"),
        ("time_s;speed_mps\n0,0;1.5.1\n", "lead.csv:2:5: `1.5.1` is not a number"),
        (
            "time_s,speed_mps\n1.7e9,1\n",
            "offset_s: the time of the first row: 1700000000 is out of range, expected 0",
        ),
        ("", "no values"),
        ("\n\n", "no values"),
        ("time_s,speed_mps\n", "no values"),
    ] {
        let shown = refusal(text, &usual);
        assert!(shown.contains(expected), "{text}: {shown}");
    }
}

#[test]
fn an_endless_table_is_refused() {
    let mut text = String::from("time_s,speed_mps\n");
    for i in 0..=MAX_ROWS {
        text.push_str(&format!("{}e-3,0\n", i + 1));
    }
    assert!(refusal(&text, &CsvFile::default()).contains("too many rows"));
}

#[test]
fn units_quotes_and_other_separators_are_read() {
    let text = "\"Zeit; ms\";\"v\"\n1000;\"36\"\n1500;54\n";
    assert_eq!(points(text, &keys("t=Zeit; ms:ms, v=v:km/h")), [(1.0, 10.0), (1.5, 15.0)]);
    let text = "t\tv\n0\t10\n1\t20\n";
    assert_eq!(points(text, &keys("t=t, v=v:mph")), [(0.0, 4.4704), (1.0, 8.9408)]);
}

#[test]
fn decimal_commas_dates_and_the_antimeridian_are_read() {
    let text = "Zeit;v\n0,0;15,2500\n0,5;15,5\n";
    assert_eq!(points(text, &keys("t=Zeit:s,v=v")), [(0.0, 15.25), (0.5, 15.5)]);
    for (from, to) in [
        ("2024-03-31T00:59:59.750Z", "2024-03-31T01:00:00.250Z"),
        ("2024-03-31T01:59:59.750+01:00", "2024-03-31T03:00:00.250+02:00"),
        ("2024-02-28 23:59:59.750", "2024-02-29 00:00:00.250"),
    ] {
        let found = points(&format!("t,v\n{from},5\n{to},6\n"), &keys("t=t,v=v"));
        assert_eq!(found[0], (0.0, 5.0), "{from}");
        assert!((found[1].0 - 0.5).abs() < 1e-6 && found[1].1 == 6.0, "{found:?}");
    }
    // 15 m/s to the east, over 180°.
    let degrees = |metres: f64| (metres / 6_378_137.0).to_degrees();
    let row = |k: i32| {
        let east = degrees(1.5 * f64::from(k - 5));
        format!("{},0,{:.9}\n", 0.1 * f64::from(k), east + if k < 5 { 180.0 } else { -180.0 })
    };
    let text = "t,lat,lon\n".to_owned() + &(0..10).map(row).collect::<String>();
    for (_, speed) in points(&text, &keys("t=t,lat=lat,lon=lon")) {
        assert!((speed - 15.0).abs() < 0.01, "{speed}");
    }
}

#[test]
fn rows_of_one_vehicle_are_chosen() {
    let text = "id,t,v\n1,0,5\n2,0,9\n1,1,6\n2,1,8\n";
    let of = |id: &str| CsvFile { rows: Some(format!("id={id}")), ..keys("t=t,v=v") };
    assert_eq!(points(text, &of("2")), [(0.0, 9.0), (1.0, 8.0)]);
    let shown = refusal(text, &of("3"));
    assert!(shown.contains("no row of lead.csv has id=3"), "{shown}");
    // All rows together are not a record of one vehicle.
    assert!(refusal(text, &keys("t=t,v=v")).contains("lead.csv:3:3: times must increase"));
}

#[test]
fn the_run_begins_within_the_record_or_before_it() {
    let text = "t,v\n1700000000,10\n1700000002,14\n1700000004,16\n";
    let at = |offset: f64| CsvFile { offset_s: Some(TimeShift::of(offset)), ..keys("t=t,v=v") };
    assert_eq!(points(text, &at(0.0)), [(0.0, 10.0), (2.0, 14.0), (4.0, 16.0)]);
    assert_eq!(points(text, &at(1.0)), [(0.0, 12.0), (1.0, 14.0), (3.0, 16.0)]);
    assert_eq!(points(text, &at(2.0)), [(0.0, 14.0), (2.0, 16.0)]);
    assert_eq!(points(text, &at(-5.0))[0], (5.0, 10.0));
    let shown = refusal(text, &at(10.0));
    assert!(shown.contains("the record ends 6.0 s before the run begins"), "{shown}");
}

#[test]
fn the_end_is_as_chosen() {
    let text = "t,v\n0,10\n5,8\n";
    let with = |after_end| CsvFile { after_end, ..keys("t=t,v=v") };
    assert_eq!(points(text, &with(AfterEnd::Stop)), [(0.0, 10.0), (5.0, 8.0), (9.0, 0.0)]);
    let record = read_text("lead.csv", text, &with(AfterEnd::Leave)).expect("right");
    assert_eq!(record.leaves_at_s, Some(Time::of(5.0)));
}

#[test]
fn a_gap_in_a_regular_record_is_refused_and_a_table_by_hand_has_no_gap() {
    let mut text = String::from("time_s,speed_mps\n");
    (0..50).for_each(|k| text.push_str(&format!("{},10\n", f64::from(k) * 0.1)));
    (50..60).for_each(|k| text.push_str(&format!("{},10\n", 2.0 + f64::from(k) * 0.1)));
    let shown = refusal(&text, &CsvFile::default());
    assert!(shown.contains("lead.csv:52:1: a gap of 2.10 s before this row"), "{shown}");
    assert!(shown.contains("max_gap_s"), "{shown}");
    let allowed = CsvFile { max_gap_s: Some(Duration::of(3.0)), ..CsvFile::default() };
    assert_eq!(points(&text, &allowed).len(), 60);
    assert_eq!(points("time_s,speed_mps\n0,10\n60,20\n61,0\n", &CsvFile::default()).len(), 3);
}

#[test]
fn noise_is_noted_and_goes_by_the_filter() {
    let mut text = String::from("time_s,speed_mps\n");
    for k in 0..200 {
        let jitter = if k % 2 == 0 { 0.4 } else { -0.4 };
        text.push_str(&format!("{:.1},{}\n", 0.1 * f64::from(k), 15.0 + jitter));
    }
    let notes = |keys: &CsvFile| read_text("lead.csv", &text, keys).expect("right").notes();
    let raw = notes(&CsvFile::default());
    assert!(raw[0].contains("it asks for") && raw[0].contains("8.0 m/s²"), "{raw:?}");
    let smooth = CsvFile { smooth_s: Some(TimeConstant::of(1.0)), ..CsvFile::default() };
    assert_eq!(notes(&smooth), [] as [&str; 0]);
}

#[test]
fn positions_become_speeds_and_do_not_reverse() {
    let text = "t,s\n0,0\n1,10\n2,20\n3,30\n";
    assert_eq!(points(text, &keys("t=t,s=s"))[2], (2.0, 10.0));
    let text = "t,s\n0,0\n1,10\n2,5\n3,1\n";
    let shown = refusal(text, &keys("t=t,s=s"));
    assert!(shown.contains("lead.csv:4:3: the distance decreases"), "{shown}");
    let text = "t,x,y\n0,0,0\n1,3,4\n2,6,8\n";
    assert_eq!(points(text, &keys("t=t,x=x,y=y"))[1], (1.0, 5.0));
}
