//! Tables and roads from files.

use super::*;

#[test]
fn a_speed_table_in_a_file_becomes_part_of_the_effective_scenario() {
    let directory = std::env::temp_dir().join(format!("timegap-scenario-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("the temporary directory is writable");
    let write = |name: &str, text: &str| {
        std::fs::write(directory.join(name), text).expect("the temporary directory is writable");
    };
    write("lead.csv", "time_s,speed_mps\n0,10\n5,12.5\n");
    write(
        "drive.toml",
        &format!(
            "{SHORT}[[actors]]\nname = \"lead\"\ngap_m = 9\nprofile.csv.file = \"lead.csv\"\n"
        ),
    );
    let path = directory.join("drive.toml").display().to_string();
    let opened = Scenario::open(&path, &Overrides::new(), &|_| Ok(Default::default()));
    write("lead.csv", "time_s,speed_mps\n0,10\n0,12.5\n");
    let refused = Scenario::open(&path, &Overrides::new(), &|_| Ok(Default::default()));
    std::fs::remove_file(directory.join("lead.csv")).expect("it was written above");
    let missing = Scenario::open(&path, &Overrides::new(), &|_| Ok(Default::default()));
    std::fs::remove_dir_all(&directory).expect("it was made above");

    let scenario = opened.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.actors[0].profile.points().map(<[_]>::len), Some(2));
    let again = Scenario::parse("effective.toml", &scenario.to_toml()).expect("it reads back");
    assert_eq!(scenario, again);
    let shown = refused.expect_err("time stands still").to_string();
    assert!(shown.contains("lead.csv:3:1: times must increase"), "{shown}");
    let shown = missing.expect_err("the table is gone").to_string();
    assert!(shown.contains("drive.toml:6:20: ") && shown.contains("lead.csv cannot be opened"));
}

#[test]
fn a_road_from_a_file_is_embedded_and_its_faults_are_shown_in_it() {
    let directory = std::env::temp_dir().join(format!("timegap-road-{}", std::process::id()));
    std::fs::create_dir_all(&directory).expect("a directory");
    let scenario = format!("{SHORT}plant.vehicle = \"jh6-25t\"\nroad.csv = \"hills.csv\"\n");
    let place = directory.join("hilly.toml");
    std::fs::write(&place, scenario).expect("our own");
    let open = || {
        let path = place.to_string_lossy();
        Scenario::open(&path, &Overrides::new(), &|_| Ok(Default::default()))
            .map_err(|error| error.to_string())
    };
    let missing = open().expect_err("no road yet");
    assert!(missing.contains("hilly.toml:4:12") && missing.contains("hills.csv"), "{missing}");

    let road = directory.join("hills.csv");
    let marked = "\u{feff}distance_m,height_m\n0,10\n50,11\n100,9.5\n";
    std::fs::write(&road, marked).expect("our own");
    let opened = open().expect("a right road");
    let again = Scenario::parse("effective.toml", &opened.to_toml()).expect("what took effect");
    assert_eq!(again.road.profile(), opened.road.profile());
    assert_eq!(again.road.profile().map(|road| road.grade(60.0)), Ok(-0.03));

    std::fs::write(&road, "distance_m,height_m\n0,10\n50,nan\n").expect("our own");
    let wrong = open().expect_err("no height");
    assert!(wrong.contains("hills.csv:3:4: NaN is out of range"), "{wrong}");
    std::fs::remove_dir_all(&directory).expect("our own");
}

#[test]
fn roads_that_cannot_be_are_refused() {
    const TRUCK: &str = "plant.vehicle = \"jh6-49t\"\n";
    let cases = [
        (
            "road.builtin = \"hills-60km\"\nplant.integrator = \"paper-euler\"\n\
             plant.integration_step_ms = 10",
            "the paper's Euler step has no grade",
        ),
        ("plant.mass_factor = 1.2", "a car has no mass here"),
        ("road.csv = \"x.csv\"", "the file has not been read"),
        ("road.points = [[0, 0], [50, 1], [50, 2]]", "distances must increase"),
        ("road.points = [[0, 0], [50, 20]]", "a grade of 40.0 %"),
        (
            "road = { builtin = \"hills-60km\", points = [[0, 0], [1, 0]] }",
            "the road is given twice",
        ),
        ("road.generated = { seed = 1, length_km = 0.1 }", "0.1 is out of range"),
        (
            "plant.integrator = \"paper-euler\"\nplant.integration_step_ms = 10",
            "a truck has no paper's Euler step",
        ),
    ];
    for (index, (rest, expected)) in cases.into_iter().enumerate() {
        let head = if index < 3 { "" } else { TRUCK };
        let shown = refusal(&format!("{head}{rest}"));
        assert!(shown.contains(expected), "{rest}\n{shown}");
    }
}
