//! Limits of this process's control groups: processor time, real-time time, memory.

use super::finding::Finding;

/// A limit in a file of a control group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limit {
    pub path: String,
    pub text: String,
}

/// Limits of the process's own groups and of their parents.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// `cpu.max` (version 2).
    pub cpu_max: Vec<Limit>,
    /// `cpu.cfs_quota_us` (version 1), for the usual period of 100 ms.
    pub cpu_quota_us: Vec<Limit>,
    /// `cpu.rt_runtime_us` (version 1).
    pub rt_runtime_us: Vec<Limit>,
    /// `memory.max` (version 2) or `memory.limit_in_bytes` (version 1).
    pub memory: Vec<Limit>,
}

/// Directories of the process's group of `controller` and of its parents, innermost first, from
/// `/proc/self/cgroup` and `/proc/mounts`. An empty controller means version 2.
pub fn directories(cgroup: &str, mounts: &str, controller: &str) -> Vec<String> {
    let mount = mounts.lines().find_map(|line| {
        let mut fields = line.split(' ');
        let (_, path, kind, options) =
            (fields.next()?, fields.next()?, fields.next()?, fields.next()?);
        let wanted = match controller {
            "" => kind == "cgroup2",
            _ => kind == "cgroup" && options.split(',').any(|option| option == controller),
        };
        wanted.then_some(path)
    });
    let group = cgroup.lines().find_map(|line| {
        let mut fields = line.splitn(3, ':');
        let (_, controllers, path) = (fields.next()?, fields.next()?, fields.next()?);
        controllers.split(',').any(|name| name == controller).then_some(path)
    });
    let (Some(mount), Some(group)) = (mount, group) else { return Vec::new() };
    let mut directories = vec![mount.to_owned()];
    let mut path = mount.to_owned();
    for part in group.split('/').filter(|part| !part.is_empty() && *part != "..") {
        path = format!("{path}/{part}");
        directories.push(path.clone());
    }
    directories.reverse();
    directories
}

/// The share of the machine's processor time that the groups allow.
pub fn processor_time(limits: &Limits, cores: usize) -> Finding {
    const CHECK: &str = "processor quota";
    let version_2 = limits.cpu_max.iter().filter_map(|limit| {
        let mut words = limit.text.split_whitespace();
        let (quota, period) = (words.next()?.parse::<f64>().ok()?, words.next()?.parse().ok()?);
        Some((quota, period, limit, format!("max {period}")))
    });
    let version_1 = limits.cpu_quota_us.iter().filter_map(|limit| {
        let quota = limit.text.trim().parse::<f64>().ok().filter(|quota| *quota >= 0.0)?;
        Some((quota, 100_000.0, limit, "-1".to_owned()))
    });
    let tightest = version_2.chain(version_1).min_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let Some((quota_us, period_us, limit, open)) = tightest else {
        return Finding::ok(CHECK, "none");
    };
    let share: f64 = quota_us / period_us;
    let found = format!("{quota_us} µs of {cores} cores in each {period_us} µs ({})", limit.path);
    if share >= cores as f64 {
        return Finding::ok(CHECK, found);
    }
    let stop_us = (period_us - quota_us / cores as f64).max(0.0);
    let costs = format!("after it is used up, all services stop for up to {stop_us:.0} µs");
    Finding::warn(CHECK, found, costs, Some(format!("echo {open} | sudo tee {}", limit.path)))
}

/// True if the group may use real-time priorities.
pub fn real_time_time(limits: &Limits) -> Finding {
    const CHECK: &str = "real-time quota";
    let Some(own) = limits.rt_runtime_us.first() else { return Finding::ok(CHECK, "none") };
    match own.text.trim().parse::<i64>() {
        Ok(0) => Finding::bad(
            CHECK,
            format!("0 µs ({})", own.path),
            "SCHED_FIFO is refused, even to root",
            // The parent group must have time to give.
            Some(match limits.rt_runtime_us.iter().find(|limit| limit.text.trim() != "0") {
                Some(above) => {
                    let directory = above.path.trim_end_matches("cpu.rt_runtime_us");
                    format!("echo $$ | sudo tee {directory}cgroup.procs")
                }
                None => format!("echo 500000 | sudo tee {}", own.path),
            }),
        ),
        Ok(runtime) => Finding::ok(CHECK, format!("{runtime} µs ({})", own.path)),
        Err(_) => Finding::ok(CHECK, "none"),
    }
}

/// The memory that the group allows, compared with the need of one run.
pub fn memory(limits: &Limits, needed_bytes: u64) -> Finding {
    const CHECK: &str = "memory limit";
    let parsed = limits.memory.iter().filter_map(|limit| {
        // Version 1 writes a number near 2^63 for no limit.
        let bytes = limit.text.trim().parse::<u64>().ok().filter(|bytes| *bytes < 1 << 62)?;
        Some((bytes, limit))
    });
    let Some((bytes, limit)) = parsed.min_by_key(|(bytes, _)| *bytes) else {
        return Finding::ok(CHECK, "none");
    };
    let found = format!("{} MiB ({})", bytes >> 20, limit.path);
    if bytes >= needed_bytes {
        return Finding::ok(CHECK, found);
    }
    let needed = needed_bytes >> 20;
    let fix = format!("echo {needed_bytes} | sudo tee {}", limit.path);
    let costs = format!("a run may need {needed} MiB; with less the kernel kills it");
    Finding::bad(CHECK, found, costs, Some(fix))
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    fn limits(path: &str, texts: &[&str]) -> Vec<Limit> {
        texts.iter().map(|text| Limit { path: path.into(), text: text.to_string() }).collect()
    }

    #[test]
    fn a_desktop_with_version_2() {
        let cgroup = "0::/user.slice/user-1000.slice/session-2.scope\n";
        let mounts = "proc /proc proc rw 0 0\ncgroup2 /sys/fs/cgroup cgroup2 rw,nosuid 0 0\n";
        let found = directories(cgroup, mounts, "");
        assert_eq!(found[0], "/sys/fs/cgroup/user.slice/user-1000.slice/session-2.scope");
        assert_eq!(found.last().map(String::as_str), Some("/sys/fs/cgroup"));
        assert_eq!(found.len(), 4);
        assert!(directories(cgroup, mounts, "cpu").is_empty());
    }

    #[test]
    fn a_machine_with_version_1_beside_an_empty_version_2() {
        let cgroup = "4:memory:/process_api/04f7\n2:cpu,cpuacct:/\n0::/\n";
        let mounts = "cgroup /sys/fs/cgroup/cpu,cpuacct cgroup rw,cpu,cpuacct 0 0\n\
                      cgroup /sys/fs/cgroup/memory cgroup rw,memory 0 0\n\
                      cgroup2 /sys/fs/cgroup/unified cgroup2 rw 0 0\n";
        assert_eq!(directories(cgroup, mounts, "cpu"), ["/sys/fs/cgroup/cpu,cpuacct"]);
        assert_eq!(
            directories(cgroup, mounts, "memory")[0],
            "/sys/fs/cgroup/memory/process_api/04f7"
        );
        assert_eq!(directories(cgroup, mounts, ""), ["/sys/fs/cgroup/unified"]);
        assert!(directories("", "", "cpu").is_empty());
    }

    #[test]
    fn a_container_with_half_a_core() {
        let all = Limits {
            cpu_max: limits("/sys/fs/cgroup/cpu.max", &["50000 100000\n", "max 100000\n"]),
            ..Limits::default()
        };
        let found = processor_time(&all, 4);
        assert_eq!(found.verdict, Verdict::Warn);
        assert!(found.costs.is_some_and(|costs| costs.contains("87500 µs")));
        assert_eq!(found.fix.as_deref(), Some("echo max 100000 | sudo tee /sys/fs/cgroup/cpu.max"));
        let open = limits("cpu.cfs_quota_us", &["-1\n"]);
        let open = Limits { cpu_quota_us: open, ..Limits::default() };
        assert_eq!(processor_time(&open, 4).verdict, Verdict::Ok);
        let wide = limits("cpu.cfs_quota_us", &["400000"]);
        let wide = Limits { cpu_quota_us: wide, ..Limits::default() };
        assert_eq!(processor_time(&wide, 4).verdict, Verdict::Ok);
    }

    #[test]
    fn a_group_without_real_time_time() {
        let inner = Limit { path: "/c/docker/cpu.rt_runtime_us".into(), text: "0\n".into() };
        let outer = Limit { path: "/c/cpu.rt_runtime_us".into(), text: "950000\n".into() };
        let nothing = Limits { rt_runtime_us: vec![inner.clone(), outer], ..Limits::default() };
        let found = real_time_time(&nothing);
        assert_eq!(found.verdict, Verdict::Bad);
        assert_eq!(found.fix.as_deref(), Some("echo $$ | sudo tee /c/cgroup.procs"));
        let alone = Limits { rt_runtime_us: vec![inner], ..Limits::default() };
        assert!(real_time_time(&alone).fix.is_some_and(|fix| fix.contains("echo 500000")));
        assert_eq!(real_time_time(&Limits::default()).verdict, Verdict::Ok);
    }

    #[test]
    fn memory_by_the_tightest_limit() {
        let of = |texts: &[&str]| Limits { memory: limits("m", texts), ..Limits::default() };
        assert_eq!(memory(&of(&["max\n"]), 1 << 26).verdict, Verdict::Ok);
        assert_eq!(memory(&of(&["9223372036854771712\n"]), 1 << 26).verdict, Verdict::Ok);
        assert_eq!(memory(&of(&["max", "33554432"]), 1 << 26).verdict, Verdict::Bad);
        assert_eq!(memory(&of(&["1073741824", "max"]), 1 << 26).verdict, Verdict::Ok);
    }
}
