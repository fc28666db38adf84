//! Differences between this machine and the one that the goals are meant for.

use super::setup::Scheduling;

/// The caveats of every verdict: fewer than two cores, a processor quota, time-sharing.
pub fn caveats(cores: usize, reference: Scheduling, quota: Option<f64>) -> Vec<String> {
    let mut caveats = Vec::new();
    if cores < 2 {
        caveats.push("one core".to_owned());
    }
    if let Some(share) = quota.filter(|share| *share < cores as f64) {
        caveats.push(format!("processor quota of {share:.2} cores"));
    }
    if reference == Scheduling::Other {
        caveats.push("without SCHED_FIFO".to_owned());
    }
    caveats
}

/// Tightest processor quota of this process's control group (version 2) and its parents, in cores; `None`
/// without a quota.
pub fn quota() -> Option<f64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = groups.lines().find_map(|line| line.strip_prefix("0::"))?.trim_matches('/');
    let parts: Vec<&str> = group.split('/').filter(|part| !part.is_empty()).collect();
    let tightest = (0..=parts.len()).filter_map(|depth| {
        let path = format!("/sys/fs/cgroup/{}/cpu.max", parts[..depth].join("/"));
        quota_in(&std::fs::read_to_string(path).ok()?)
    });
    tightest.min_by(f64::total_cmp)
}

/// Cores that a `cpu.max` allows: quota over period; `None` for `max`.
fn quota_in(text: &str) -> Option<f64> {
    let mut words = text.split_whitespace();
    let (quota, period) = (words.next()?.parse::<f64>().ok()?, words.next()?.parse::<f64>().ok()?);
    (period > 0.0).then(|| quota / period)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quota_is_read_in_cores() {
        assert_eq!(quota_in("max 100000\n"), None);
        assert_eq!(quota_in("50000 100000\n"), Some(0.5));
        assert_eq!(quota_in(""), None);
    }

    #[test]
    fn the_machines_lacks_are_named() {
        assert!(caveats(2, Scheduling::Fifo, None).is_empty());
        assert!(caveats(2, Scheduling::Fifo, Some(4.0)).is_empty(), "more than the machine has");
        let all = caveats(1, Scheduling::Other, Some(0.5));
        assert_eq!(all, ["one core", "processor quota of 0.50 cores", "without SCHED_FIFO"]);
    }
}
