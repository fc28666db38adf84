//! One function for each reader of bytes from outside. They may not panic on any input, and each reports the fault in
//! one error. The targets in `fuzz/` call them with libFuzzer, a test calls them with mutated examples.

use crate::storyboards;
use messages::e2e::{Channel, Outcomes, profile7};
use openscenario::variation::Variation;
use openscenario::{Source, World};
use recorder::Recording;
use runtime::{FromService, Group, ToService};
use scenario::Scenario;
use scenario::faults::Fault;
use scenario::quantity::TimeConstant;
use scenario::recorded::{CsvFile, read_text};
use std::path::{Path, PathBuf};

/// A reader of bytes from outside.
pub struct Target {
    /// Its name, and of its file in `fuzz/fuzz_targets`.
    pub name: &'static str,
    /// The reader.
    pub read: fn(&[u8]),
}

/// All readers.
pub const TARGETS: [Target; 15] = [
    Target { name: "scenario", read: scenario },
    Target { name: "speed_table", read: speed_table },
    Target { name: "bag", read: bag },
    Target { name: "road", read: road },
    Target { name: "design", read: design },
    Target { name: "recording", read: recording },
    Target { name: "link", read: link },
    Target { name: "end_to_end", read: end_to_end },
    Target { name: "openscenario", read: openscenario },
    Target { name: "capture", read: capture },
    Target { name: "frame", read: frame },
    Target { name: "storyboard", read: storyboard },
    Target { name: "opendrive", read: opendrive },
    Target { name: "plan", read: plan },
    Target { name: "unit", read: unit },
];

/// Scenario files. An accepted one can be written and read again, and its law can be built.
pub fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(scenario) = Scenario::parse("fuzz.toml", text) {
        let again = Scenario::parse("again.toml", &scenario.to_toml()).expect("it was written");
        // As text: a law's table may hold a NaN, which the law refuses.
        assert_eq!(scenario.to_toml(), again.to_toml());
        let _ = controller::laws::build(&scenario);
    }
}

/// Tables of a vehicle's speed.
pub fn speed_table(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let usual = CsvFile::default();
    let smooth_s = Some(TimeConstant::of(1.0));
    let smooth =
        CsvFile { columns: Some("t=t:ms, lat=a, lon=b".into()), smooth_s, ..usual.clone() };
    for keys in [usual, smooth] {
        if let Ok(record) = read_text("fuzz.csv", text, &keys) {
            assert!(record.points.windows(2).all(|pair| pair[0].0 < pair[1].0));
        }
    }
}

/// Units of FMI: as an archive, and as the model description in one.
pub fn unit(bytes: &[u8]) {
    let path = std::env::temp_dir().join(format!("timegap-fuzz-{}.fmu", std::process::id()));
    let library = format!("binaries/{}-linux/unit.so", std::env::consts::ARCH);
    let library = library.replace("x86_64-linux", "linux64");
    let packed = fmi::pack(&[("modelDescription.xml", bytes), (&library, b"")]).expect("short");
    for unit in [bytes, &packed] {
        std::fs::write(&path, unit).expect("a temporary file");
        let _ = fmi::check_law(&path, &["gap_m=v".to_owned(), "--v=1".to_owned()]);
        let _ = fmi::check_vehicle(&path, &[]);
    }
    std::fs::remove_file(&path).expect("it was written");
}

/// Bags of other programs.
pub fn bag(bytes: &[u8]) {
    let fields = ["header.stamp", "twist.linear.x"].map(String::from);
    let _ = bags::series_from(&mut std::io::Cursor::new(bytes), "/gps/velocity", &fields);
}

/// Tables of a road's height or grade. An accepted one has a slope everywhere.
pub fn road(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(profile) = scenario::road::parse_csv("fuzz.csv", text) {
        for k in 0..10 {
            assert!(profile.grade(f64::from(k) * profile.end_m() / 9.0).is_finite());
        }
    }
}

/// Designs of the quadratic-bounded law. An accepted one keeps its bounds.
pub fn design(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = controller::laws::quadratic_bounded::Design::load(text);
}

/// Recordings.
pub fn recording(bytes: &[u8]) {
    if let Ok(recording) = Recording::of_bytes("fuzz.mcap".into(), bytes) {
        let survey = recording.survey();
        assert!(survey.tally.messages() <= (64 << 20) * (1 + bytes.len() as u64));
        let _ = (recording.statistics(), recording.takes());
    }
}

/// Captures of radio frames. An accepted one plays at most its frames.
pub fn capture(bytes: &[u8]) {
    if let Ok(mut capture) = radio::Capture::read(bytes) {
        let played = std::iter::from_fn(|| capture.receive(i64::MAX)).count();
        assert!(played <= capture.frames());
    }
}

/// Messages between launcher, services and clients.
pub fn link(bytes: &[u8]) {
    let _ = serde_json::from_slice::<FromService>(bytes);
    let _ = serde_json::from_slice::<ToService>(bytes);
    let _ = serde_json::from_slice::<Group>(bytes);
    if let Ok(fault) = serde_json::from_slice::<Fault>(bytes) {
        let text = serde_json::to_string(&fault).expect("plain data");
        assert_eq!(serde_json::from_str::<Fault>(&text).expect("it was written"), fault);
    }
}

/// The end-to-end check: accepted messages were protected.
pub fn end_to_end(bytes: &[u8]) {
    let (mut channel, mut outcomes) = (Channel::default(), Outcomes::default());
    if channel.accept(bytes, 7, 0, &mut outcomes) {
        let mut again = bytes.to_vec();
        let counter = u32::from_be_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]);
        profile7::protect(&mut again, 7, counter);
        assert_eq!(again, bytes);
    }
}

/// OpenSCENARIO files: scenarios and variations. An accepted scenario moves and stays finite.
pub fn openscenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let path = Path::new("fuzz.xosc");
    let files = OneFile(text);
    if let Ok(variation) = Variation::open(path, &files) {
        assert!(!variation.is_empty() && !variation.get(variation.len() - 1).is_empty());
    }
    drive(&files);
}

/// OpenDRIVE files. Every lane of an accepted road has a finite middle, and the axis along it finite poses.
pub fn opendrive(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(document) = openscenario::xml::parse("fuzz.xodr", text) else { return };
    let Ok(found) = openscenario::road::read(&document, None) else { return };
    let road = found.road;
    assert!(road.lanes.is_sound());
    let part = &road.parts[0];
    for k in 0..8 {
        let s_m = road.lanes.length_m * f64::from(k) / 7.0;
        assert!(road.heights.at(s_m).is_finite());
        for strip in road.lanes.strips(s_m).collect::<Vec<_>>() {
            assert!(strip.center_m.is_finite());
            assert!(road.drift(0.0, strip.center_m, s_m).is_finite());
            let file = Path::new("fuzz.xodr");
            let lane = openscenario::road::driven_lane(file, text, &part.id, strip.id, s_m);
            if let Ok(lane) = lane {
                let (axis, _) = lane.line.axis().expect("it was read");
                assert!(axis.pose(0.5 * axis.length_m()).x_m.is_finite());
                let _ = lane.road.heights_along(&lane.line);
                let lines = lane.road.lane_lines(&lane.line).expect("its axis was read");
                let edges_m = lines.edges_m(0.3 * axis.length_m());
                assert!(lines.is_sound() && edges_m.is_none_or(|edges_m| edges_m[0] <= edges_m[1]));
            }
        }
    }
}

/// Plans of a road, the keys of `[road.plan]`. The axis of an accepted one has finite poses.
pub fn plan(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let head = "schema_version = 1\nname = \"fuzz\"\n[[actors]]\nname = \"lead\"\ngap_m = 40\n\
                initial_speed_mps = 20\n[road.plan]\n";
    if let Ok(scenario) = Scenario::parse("fuzz.toml", &format!("{head}{text}"))
        && let Some(plan) = scenario.road.plan()
    {
        let axis = plan.axis();
        for k in 0..20 {
            let p_m = axis.length_m() * (f64::from(k) - 2.0) / 16.0;
            let at = axis.point(p_m, 3.5);
            let (back_m, left_m) = axis.project(at.x_m, at.y_m, p_m);
            assert!((back_m - p_m).abs() < 1e-3 && (left_m - 3.5).abs() < 1e-3, "{p_m}");
        }
    }
}

/// Storyboards that the bytes choose. A drive of 20 s stays finite, and goes on the same way from a
/// checkpoint.
pub fn storyboard(bytes: &[u8]) {
    drive(&OneFile(&storyboards::file(bytes)));
}

/// Drives an accepted scenario beside an ego that keeps its speed. False when it was refused.
fn drive(files: &OneFile<'_>) -> bool {
    let Ok(read) = openscenario::read::scenario(Path::new("fuzz.xosc"), files, &Default::default())
    else {
        return false;
    };
    let (ego, entities) = (read.script.ego, read.script.entities.len());
    let Ok(mut world) = World::new(read.script.clone()) else { return false };
    let mut other = World::new(read.script).expect("the same script");
    let mut motion = world.motion(ego);
    for step in 0..200_u64 {
        let time_ns = step * 100_000_000;
        if step == 100 {
            other.restore(world.state().clone());
        }
        for world in [&mut world, &mut other] {
            world.observe(ego, motion);
            world.step(time_ns);
        }
        motion.s_m += 0.1 * motion.speed_mps;
        for entity in 0..entities {
            let it = world.motion(entity);
            let figures = [
                it.s_m,
                it.t_m,
                it.heading_rad,
                it.speed_mps,
                it.lateral_mps,
                it.acceleration_mps2,
            ];
            assert!(figures.iter().all(|figure| figure.is_finite()), "step {step}: {it:?}");
            assert!(it.speed_mps >= 0.0, "step {step}: {it:?}");
            assert!(step < 100 || other.motion(entity) == it, "step {step}: {it:?}");
        }
    }
    true
}

/// A file that every path of a scenario names.
struct OneFile<'a>(&'a str);

impl Source for OneFile<'_> {
    fn read(&self, _: &Path) -> std::io::Result<String> {
        Ok(self.0.to_owned())
    }

    fn list(&self, directory: &Path) -> std::io::Result<Vec<PathBuf>> {
        Ok(vec![directory.join("fuzz.xosc")])
    }
}

/// Radio frames. The on-board unit counts each frame once.
pub fn frame(bytes: &[u8]) {
    let start_ns = scenario::radio::SIMULATED_START_NS;
    let moment = obu::clock::Moment { now_ns: 0, utc_start_ns: start_ns, ahead_ns: 0 };
    let mut receiver =
        obu::receiver::Receiver::new(1, 500, obu::lanes::road_plane(&Default::default()));
    let verdict = receiver.take(bytes, &moment);
    assert_eq!(receiver.verdicts.of(verdict), 1);
    let mut map = bytemuck::Zeroable::zeroed();
    let mut spat = bytemuck::Zeroable::zeroed();
    receiver.write(0, 0.0, &mut map, &mut spat);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Most random storyboards must reach the moving world: otherwise the target tests the reader alone.
    #[test]
    fn most_random_storyboards_are_driven() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut driven = 0;
        for _ in 0..400 {
            let bytes: Vec<u8> = (0..200).map(|_| (random.next_u32() >> 24) as u8).collect();
            driven += u32::from(drive(&OneFile(&storyboards::file(&bytes))));
        }
        assert!(driven > 100, "{driven} of 400");
    }
}
