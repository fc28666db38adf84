//! The processors: number, time to wake up, other load, and the clock.

use super::finding::Finding;

/// Exit latency from which an idle state matters, µs: the length of a wake-up.
const DEEP_US: u64 = 20;

/// An idle state of a core, as in `cpuidle/state*`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdleState {
    pub number: usize,
    pub name: String,
    /// Time to leave it, µs.
    pub latency_us: u64,
    /// True if it is never entered.
    pub disabled: bool,
}

/// The usable cores among the online ones (`/sys/devices/system/cpu/online`).
pub fn affinity(usable: &[usize], online: &str) -> Finding {
    const CHECK: &str = "cores";
    let there = list(online).len();
    let found = format!("{} of {there} may be used", usable.len());
    if usable.len() > 1 {
        return Finding::ok(CHECK, found);
    }
    let fix = (there > 1).then(|| format!("taskset --cpu-list --pid {} $$", online.trim()));
    let costs = "all services share one core: the controller waits for the plant and the radar";
    Finding::warn(CHECK, found, costs, fix)
}

/// The cores of a list in the kernel's form: `0-3,8`.
pub fn list(text: &str) -> Vec<usize> {
    let ranges = text.trim().split(',').filter_map(|range| {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        Some(first.parse::<usize>().ok()?..=last.parse().ok()?)
    });
    ranges.flatten().collect()
}

/// Frequency governors of the usable cores.
pub fn governor(governors: &[(usize, String)]) -> Finding {
    const CHECK: &str = "frequency governor";
    let slow = governors.iter().find(|(_, governor)| governor.trim() != "performance");
    match (governors.first(), slow) {
        (None, _) => Finding::ok(CHECK, "none: this system does not set the frequency"),
        (Some(_), None) => Finding::ok(CHECK, "performance"),
        (Some(_), Some((core, governor))) => Finding::warn(
            CHECK,
            format!("{} on core {core}", governor.trim()),
            "after a sleep the core is slow: a short cycle ends before the frequency rises",
            Some("sudo cpupower frequency-set -g performance".into()),
        ),
    }
}

/// Command that disables the idle states while it runs: its open file asks for a latency of 0 µs.
const HOLD_IDLE_STATES_OFF: &str = "sudo sh -c 'exec 3>/dev/cpu_dma_latency; printf \"\\0\\0\\0\\0\" >&3; \
                                    exec sleep infinity' &";

/// The deepest idle state that a core may enter.
///
/// A halted virtual core returns to the host. Its state's latency is the time to leave the state, without the
/// wait for the host.
pub fn idle_states(states: &[IdleState]) -> Finding {
    const CHECK: &str = "idle states";
    let enabled = states.iter().filter(|state| !state.disabled);
    let Some(deepest) = enabled.max_by_key(|state| state.latency_us) else {
        return Finding::ok(CHECK, "none: this system does not choose them");
    };
    let found = format!("down to {}, left in {} µs", deepest.name, deepest.latency_us);
    if deepest.name.starts_with("haltpoll") {
        let costs = "an idle core returns to the host, and a wake-up on it waits for the host";
        return Finding::warn(CHECK, found, costs, Some(HOLD_IDLE_STATES_OFF.into()));
    }
    if deepest.latency_us < DEEP_US {
        return Finding::ok(CHECK, found);
    }
    let costs = format!("up to {} µs on every wake-up after a long sleep", deepest.latency_us);
    let fix = format!("sudo cpupower idle-set --disable-by-latency {DEEP_US}");
    Finding::warn(CHECK, found, costs, Some(fix))
}

/// True if the scheduler keeps other programs off the controller's core, the last usable one.
pub fn isolation(usable: &[usize], isolated: Option<&str>) -> Finding {
    const CHECK: &str = "isolated cores";
    let isolated = list(isolated.unwrap_or_default());
    let Some(&core) = usable.last() else { return Finding::ok(CHECK, "no core is known") };
    if isolated.contains(&core) {
        return Finding::ok(CHECK, format!("core {core} (the controller's) is isolated"));
    }
    let found = format!("core {core} (the controller's) is not isolated");
    let costs = "interrupts and kernel threads of the whole system share it";
    if usable.len() < 2 {
        return Finding::ok(CHECK, "the only core cannot be isolated");
    }
    let fix = format!(
        "add isolcpus=managed_irq,domain,{core} nohz_full={core} rcu_nocbs={core} to \
         GRUB_CMDLINE_LINUX in /etc/default/grub, then: sudo update-grub && sudo reboot"
    );
    Finding::warn(CHECK, found, costs, Some(fix))
}

/// The clock behind every stamp.
pub fn clock_source(current: Option<&str>, available: Option<&str>) -> Finding {
    const CHECK: &str = "clock source";
    /// Sources that are read without a system call.
    const FAST: [&str; 4] = ["tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter"];
    let Some(current) = current.map(str::trim) else {
        return Finding::ok(CHECK, "not reported by this system");
    };
    if FAST.contains(&current) {
        return Finding::ok(CHECK, current);
    }
    let available = available.unwrap_or_default().split_whitespace();
    let better = available.into_iter().find(|source| FAST.contains(source));
    let fix = better.map(|source| {
        format!(
            "echo {source} | sudo tee \
             /sys/devices/system/clocksource/clocksource0/current_clocksource"
        )
    });
    Finding::warn(CHECK, current, "every stamp is a system call and a slow read", fix)
}

/// Time that the host withheld from this machine between two readings of `/proc/stat`, and since its start.
pub fn steal(before: &str, after: &str) -> Finding {
    const CHECK: &str = "stolen time";
    let (Some(before), Some(after)) = (times(before), times(after)) else {
        return Finding::ok(CHECK, "not reported by this system");
    };
    let share = |stolen: u64, all: u64| 100.0 * stolen as f64 / all.max(1) as f64;
    let ever = share(after.0, after.1);
    let now = share(after.0.saturating_sub(before.0), after.1.saturating_sub(before.1));
    let found = format!("{ever:.2} % since the start, {now:.1} % during this check");
    if ever < 0.1 && now < 0.1 {
        return Finding::ok(CHECK, found);
    }
    let costs = "the host ran others on these cores: cycles are late and no setting here helps; \
                 ask for cores of your own";
    Finding::warn(CHECK, found, costs, None)
}

/// Stolen and all time of all cores, in ticks.
fn times(stat: &str) -> Option<(u64, u64)> {
    let line = stat.lines().find_map(|line| line.strip_prefix("cpu "))?;
    let ticks: Vec<u64> = line.split_whitespace().map_while(|tick| tick.parse().ok()).collect();
    // user nice system idle iowait irq softirq steal; the rest is part of user and nice.
    Some((*ticks.get(7)?, ticks[..8].iter().sum()))
}

pub fn kernel(release: &str, realtime: bool) -> Finding {
    const CHECK: &str = "kernel";
    if realtime {
        return Finding::ok(CHECK, format!("Linux {release}, fully preemptible"));
    }
    Finding::warn(
        CHECK,
        format!("Linux {release}, not fully preemptible"),
        "a driver or a long system call can hold a FIFO loop up",
        Some("sudo apt install linux-image-rt-amd64 && sudo reboot".into()),
    )
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    fn state(number: usize, name: &str, latency_us: u64, disabled: bool) -> IdleState {
        IdleState { number, name: name.into(), latency_us, disabled }
    }

    #[test]
    fn core_lists_as_the_kernel_writes_them() {
        assert_eq!(list("0-3,8\n"), [0, 1, 2, 3, 8]);
        assert_eq!(list("\n"), [] as [usize; 0]);
        assert_eq!(list("5"), [5]);
    }

    #[test]
    fn one_core_of_four_is_too_few() {
        assert_eq!(affinity(&[0, 1], "0-1").verdict, Verdict::Ok);
        let found = affinity(&[2], "0-3\n");
        assert_eq!(found.verdict, Verdict::Warn);
        assert_eq!(found.fix.as_deref(), Some("taskset --cpu-list --pid 0-3 $$"));
        assert_eq!(affinity(&[0], "0").fix, None, "no other core exists");
    }

    #[test]
    fn a_laptop_that_saves_power() {
        let governors = [(0, "performance\n".to_owned()), (1, "powersave\n".to_owned())];
        let found = governor(&governors);
        assert!(found.verdict == Verdict::Warn && found.found.contains("core 1"), "{found:?}");
        let states = [state(0, "POLL", 0, false), state(3, "C10", 890, false)];
        let found = idle_states(&states);
        assert!(found.costs.is_some_and(|costs| costs.contains("890 µs")));
        assert!(isolation(&[0, 1, 2, 3], Some("")).verdict == Verdict::Warn);
    }

    #[test]
    fn a_tuned_machine() {
        assert_eq!(governor(&[(3, "performance".into())]).verdict, Verdict::Ok);
        let states = [state(1, "C1", 2, false), state(3, "C10", 890, true)];
        assert_eq!(idle_states(&states).verdict, Verdict::Ok);
        assert_eq!(isolation(&[0, 1, 2, 3], Some("2-3\n")).verdict, Verdict::Ok);
        assert_eq!(kernel("6.12-rt", true).verdict, Verdict::Ok);
    }

    #[test]
    fn a_virtual_core_that_halts() {
        let states = [state(0, "POLL", 0, false), state(1, "haltpoll idle", 1, false)];
        let fix = idle_states(&states).fix.expect("a way to hold it off");
        assert!(fix.contains(r#"printf "\0\0\0\0" >&3"#), "{fix}");
        let states = [state(0, "POLL", 0, false), state(1, "haltpoll idle", 1, true)];
        assert_eq!(idle_states(&states).verdict, Verdict::Ok);
    }

    #[test]
    fn a_virtual_machine_without_any_of_these() {
        assert_eq!(governor(&[]).verdict, Verdict::Ok);
        assert_eq!(idle_states(&[]).verdict, Verdict::Ok);
        assert_eq!(clock_source(Some("kvm-clock\n"), Some("kvm-clock")).verdict, Verdict::Ok);
        let found = clock_source(Some("hpet"), Some("tsc hpet acpi_pm"));
        assert!(found.fix.is_some_and(|fix| fix.starts_with("echo tsc |")));
        assert_eq!(clock_source(Some("acpi_pm"), Some("acpi_pm")).fix, None);
        assert_eq!(clock_source(None, None).verdict, Verdict::Ok);
    }

    #[test]
    fn stolen_time_now_and_ever() {
        let stat = |steal: u64, idle: u64| {
            format!("cpu  100 0 100 {idle} 0 0 0 {steal} 0 0\ncpu0 1 2 3\nintr 5\n")
        };
        assert_eq!(steal(&stat(0, 800), &stat(0, 900)).verdict, Verdict::Ok);
        let found = steal(&stat(0, 99_800), &stat(10, 99_890));
        assert!(found.verdict == Verdict::Warn && found.found.contains("10.0 %"), "{found:?}");
        assert_eq!(steal("", "").verdict, Verdict::Ok);
    }
}
