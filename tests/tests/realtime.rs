//! A realtime run: nothing lost, every chain counted. No test asserts a speed.

use serde_json::Value;
use system_tests::{Corner, status_of, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

#[test]
fn a_realtime_run_is_measured_whole() {
    let corner = Corner::new(PROGRAM);
    let summary = corner.json(&["run", "--duration", "3", "--out", "out"]);
    assert_eq!(summary["outcome"], "completed");
    assert_eq!(summary["mode"], "realtime");
    for (topic, counts) in summary["messages"].as_object().expect("topics") {
        assert_eq!(counts["lost"].as_u64().unwrap_or(0), 0, "{topic}: {counts}");
    }

    let timing = &summary["timing"];
    let cycles = timing["cycles"].as_u64().expect("counted");
    let misses = timing["deadline_misses"].as_u64().expect("counted");
    assert!(cycles > 0 && cycles <= 31 && misses <= 31, "{timing}");
    let reaction = &timing["reaction_time_us"];
    let count = reaction["count"].as_u64().expect("counted");
    assert!(count > 0 && count <= cycles);
    for hop in ["radar_to_controller", "controller_compute", "controller_to_plant"] {
        assert_eq!(timing["hops_us"][hop]["count"].as_u64(), Some(count), "every chain has {hop}");
    }
    for (figure, percentiles) in timing["hops_us"].as_object().expect("hops").iter().chain([
        (&"designed".to_owned(), &timing["designed_wait_us"]),
        (&"net".to_owned(), &timing["net_reaction_us"]),
    ]) {
        assert_eq!(percentiles["count"].as_u64(), Some(count), "every chain has {figure}");
    }
    worst_chains_are_whole(timing);
    let log = std::fs::read_to_string(corner.path().join("out/histograms.hlog")).expect("written");
    for name in ["reaction_time", "data_age", "net_reaction", "radar_transport", "actuate"] {
        let tag = format!("Tag={name},");
        assert_eq!(log.lines().filter(|line| line.starts_with(&tag)).count(), 1, "{name}");
    }
    // The plant acts ten times per command.
    assert!(timing["data_age_us"]["count"].as_u64() > Some(count));
    for figure in ["reaction_time_us", "data_age_us", "solve_us", "release_jitter_us"] {
        let order =
            ["p50", "p90", "p99", "p999", "p9999", "max"].map(|p| number(&timing[figure][p]));
        assert!(order.windows(2).all(|pair| pair[0] <= pair[1] * 1.01), "{figure}: {order:?}");
    }

    for service in summary["services"].as_array().expect("services") {
        assert_eq!(service["exit"], "ok", "{service}");
        assert!(service["peak_rss_kib"].as_u64() > Some(0), "{service}");
        let scheduling = &service["scheduling"];
        // The grant is the kernel's answer, and refusals are named.
        let granted = scheduling["granted"].as_str().expect("read back");
        if granted != scheduling["requested"].as_str().expect("asked") {
            assert!(!scheduling["refused"].as_array().expect("a list").is_empty(), "{service}");
        }
    }
}

/// The longest chains come first, and each is the sum of its parts by its stamps.
fn worst_chains_are_whole(timing: &Value) {
    let chains = timing["worst_chains"].as_array().expect("a list");
    let count = timing["reaction_time_us"]["count"].as_u64().expect("counted");
    assert_eq!(chains.len() as u64, count.min(10));
    let reaction = |chain: &Value| number(&chain["reaction_time_us"]);
    assert!(chains.windows(2).all(|pair| reaction(&pair[0]) >= reaction(&pair[1])));
    for chain in chains {
        let sum: f64 = chain["hops_us"].as_object().expect("parts").values().map(number).sum();
        assert!((sum - reaction(chain)).abs() < 1e-3, "{chain}");
        let designed = number(&chain["designed_wait_us"]);
        assert!((0.0..=reaction(chain)).contains(&designed), "{chain}");
        assert!(number(&chain["radar_age_us"]) <= reaction(chain), "{chain}");
        assert!(chain["voluntary_switches"].is_u64() && chain["minor_faults"].is_u64());
    }
    // The longest is the histogram's maximum, to two digits.
    let max = number(&timing["reaction_time_us"]["max"]);
    assert!((reaction(&chains[0]) - max).abs() <= max * 0.02, "{max} {}", chains[0]);
}

/// Memory of process `pid` without pages of files, KiB. The kernel decides how much of the program's file it maps.
fn own_memory_kib(pid: i32) -> Option<u64> {
    Some(status_of(pid, "RssAnon")? + status_of(pid, "RssShmem")?)
}

#[test]
fn a_service_has_a_few_megabytes_of_its_own() {
    let corner = Corner::new(PROGRAM);
    let mut run = corner.start(&["run", "--duration", "3"]);
    let services = ["plant", "perception-sim", "v2x-sim", "controller"]
        .map(|name| corner.wait_for_process(&format!("timegap-{name}")));
    let mut peaks = [0; 4];
    let ended = wait_for(|| {
        for (peak, pid) in peaks.iter_mut().zip(services) {
            *peak = (*peak).max(own_memory_kib(pid).unwrap_or(0));
        }
        run.try_wait().expect("a child").is_some()
    });
    assert!(ended, "the run takes 3 s");
    // With the radar's detections of 48 KiB each in flight.
    assert!(peaks.iter().all(|peak| (64..8 * 1024).contains(peak)), "KiB: {peaks:?}");
}

#[test]
fn the_timer_releases_as_well_as_the_radar() {
    let corner = Corner::new(PROGRAM);
    let timer = ["run", "--duration", "2", "--set", "controller.release=timer"];
    let summary = corner.json(&timer);
    assert_eq!(summary["outcome"], "completed");
    let cycles = summary["timing"]["cycles"].as_u64().expect("counted");
    assert!((1..=21).contains(&cycles), "{cycles}");
    // In simulated time both are equal: the sample of the step is always present.
    let drive = |release: &str| {
        let key = format!("controller.release={release}");
        corner.json(&["run", "--mode", "lockstep", "--set", &key])["control"].clone()
    };
    assert_eq!(drive("timer"), drive("radar"));
}

/// Loops and message transport allocate nothing. iceoryx2's reference counts come from a pool, which is filled after
/// the first message of each port. Encoding and decoding of frames allocates outside the control loop.
#[test]
fn the_loops_allocate_nothing() {
    /// Blocks of the pool that a loop may be the first to need. It needs one for each message that it writes at a time.
    const FIRST: u64 = 2;
    let corner = Corner::new(PROGRAM);
    for mode in ["realtime", "lockstep"] {
        for controller in ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"] {
            let summary = corner.json(&[
                "run",
                "corridor",
                "--mode",
                mode,
                "--duration",
                "1",
                "--controller",
                controller,
            ]);
            let services = summary["services"].as_array().expect("services").iter();
            let is_of_frames = |service: &Value| {
                ["v2x-sim", "obu"].contains(&service["name"].as_str().unwrap_or(""))
            };
            for service in services.filter(|service| !is_of_frames(service)) {
                let allocations = service["allocations_in_loop"].as_u64().expect("counted");
                assert!(allocations <= FIRST, "{mode} {controller} {service}: {allocations}");
            }
        }
    }
}
