//! The kernel's grants to a loop: policy, throttling, locked memory, timer slack.

use super::finding::Finding;
use runtime::scheduling::{Granted, LOCKED_MEMORY, TIMER_SLACK};
use std::path::Path;

/// The command that grants the needed capabilities to the program at `program` without root. A new build is a
/// new file without them.
fn capabilities(program: &Path) -> String {
    let program = runtime::command_line(&[program.display().to_string()]);
    format!("sudo setcap cap_sys_nice,cap_ipc_lock=ep {program} (again after each build)")
}

/// True if a thread of `program` gets the requested `SCHED_FIFO`.
pub fn policy(granted: &Granted, root: bool, program: &Path) -> Finding {
    const CHECK: &str = "real-time priority";
    if granted.granted == granted.requested {
        return Finding::ok(CHECK, format!("{} is granted", granted.granted));
    }
    let reason = granted.refusal(&granted.requested).unwrap_or("no reason given");
    Finding::bad(
        CHECK,
        format!("{} is refused ({reason}); the policy is {}", granted.requested, granted.granted),
        "any other program can delay a control cycle without a bound",
        Some(if root {
            // Root is refused by a cgroup without real-time time, or by a container without the capability.
            "run it outside the container, or start that with --cap-add=sys_nice \
             --ulimit rtprio=99"
                .into()
        } else {
            capabilities(program)
        }),
    )
}

/// Real-time throttling: `sched_rt_runtime_us` of each `sched_rt_period_us`.
pub fn throttling(runtime_us: Option<&str>, period_us: Option<&str>) -> Finding {
    const CHECK: &str = "real-time throttling";
    let number = |text: Option<&str>| text.and_then(|text| text.trim().parse::<i64>().ok());
    let (Some(runtime), Some(period)) = (number(runtime_us), number(period_us)) else {
        return Finding::ok(CHECK, "not in this kernel");
    };
    let fix = || Some("sudo sysctl kernel.sched_rt_runtime_us=950000".to_owned());
    match runtime {
        0 => Finding::bad(
            CHECK,
            "real-time loops get no time",
            "SCHED_FIFO cannot be granted",
            fix(),
        ),
        _ if runtime < 0 || runtime >= period => Finding::ok(CHECK, "off"),
        _ if 2 * runtime < period => Finding::warn(
            CHECK,
            format!("real-time loops get {runtime} µs of each {period} µs"),
            format!("a busy core stops the loops for {} µs in each period", period - runtime),
            fix(),
        ),
        _ => Finding::ok(
            CHECK,
            format!(
                "real-time loops get {runtime} µs of each {period} µs; loops that sleep need less"
            ),
        ),
    }
}

/// True if memory of `program` stays resident.
pub fn locked_memory(granted: &Granted, limits: &str, program: &Path) -> Finding {
    const CHECK: &str = "locked memory";
    if granted.memory_locked {
        return Finding::ok(CHECK, "granted");
    }
    let reason = granted.refusal(LOCKED_MEMORY).unwrap_or("no reason given");
    let limit = limit(limits, "Max locked memory").unwrap_or("unknown");
    Finding::bad(
        CHECK,
        format!("refused ({reason}); the limit is {limit} bytes"),
        "under memory pressure a control cycle waits for the disk",
        Some(capabilities(program)),
    )
}

/// True if a sleep can be exact without real-time priority.
pub fn timer_slack(granted: &Granted) -> Finding {
    const CHECK: &str = "timer slack";
    match granted.refusal(TIMER_SLACK) {
        None => Finding::ok(CHECK, "1 ns is granted"),
        Some(reason) => Finding::warn(
            CHECK,
            format!("1 ns is refused ({reason})"),
            "without real-time priority every sleep ends late by up to the slack, usually 50 µs",
            None,
        ),
    }
}

/// The soft limit with this name in `/proc/self/limits`.
fn limit<'a>(limits: &'a str, name: &str) -> Option<&'a str> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    const LIMITS: &str = "Limit                     Soft Limit           Hard Limit           Units
Max stack size            8388608              unlimited            bytes
Max locked memory         65536                65536                bytes
Max realtime priority     0                    0
";

    const NO_FIFO: &str = "fifo:80: Operation not permitted";
    const NO_LOCK: &str = "locked memory: Cannot allocate memory";

    fn path() -> &'static Path {
        Path::new("/my builds/timegap")
    }

    fn granted(policy: &str, refused: &[&str]) -> Granted {
        Granted {
            requested: "fifo:80".into(),
            granted: policy.into(),
            core: None,
            memory_locked: !refused.contains(&NO_LOCK),
            refused: refused.iter().map(ToString::to_string).collect(),
        }
    }

    #[test]
    fn all_granted() {
        let all = granted("fifo:80", &[]);
        let findings =
            [policy(&all, false, path()), locked_memory(&all, LIMITS, path()), timer_slack(&all)];
        assert!(findings.iter().all(|f| f.verdict == Verdict::Ok && f.fix.is_none()));
    }

    #[test]
    fn an_ordinary_user_sees_which_capabilities_help() {
        let none = granted("other", &[NO_LOCK, NO_FIFO]);
        let found = policy(&none, false, path());
        assert_eq!(found.verdict, Verdict::Bad);
        assert!(found.found.contains("Operation not permitted"), "{found:?}");
        let fix = found.fix.expect("a command");
        assert!(
            fix.contains("setcap cap_sys_nice") && fix.contains("'/my builds/timegap'"),
            "{fix}"
        );
        let found = locked_memory(&none, LIMITS, path());
        assert!(found.found.contains("Cannot allocate") && found.found.contains("65536 bytes"));
    }

    #[test]
    fn a_refused_root_is_in_a_container() {
        let found = policy(&granted("other", &[NO_FIFO]), true, path());
        assert!(found.fix.is_some_and(|fix| fix.contains("sys_nice") && !fix.contains("setcap")));
    }

    #[test]
    fn throttling_by_its_two_numbers() {
        let verdict = |runtime, period| throttling(Some(runtime), Some(period)).verdict;
        assert_eq!(verdict("950000\n", "1000000\n"), Verdict::Ok);
        assert_eq!(verdict("-1", "1000000"), Verdict::Ok);
        assert_eq!(verdict("100000", "1000000"), Verdict::Warn);
        assert_eq!(verdict("0", "1000000"), Verdict::Bad);
        assert_eq!(throttling(None, None).verdict, Verdict::Ok);
        let found = throttling(Some("100000"), Some("1000000"));
        assert!(found.costs.is_some_and(|costs| costs.contains("900000 µs")));
    }
}
