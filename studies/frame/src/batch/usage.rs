//! Resources of a run: what its processes take while it goes on, and what is left when it is over.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The name of the process that starts the services, among theirs.
const LAUNCHER: &str = "launcher";

/// Resources of one process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Resident set, KiB.
    pub memory_kib: u64,
    /// The part of it that belongs to no file, KiB. Pages of the program come and go with the kernel's page cache.
    pub own_kib: u64,
    pub descriptors: u64,
}

/// Resources of a run at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Resources of each service, by its name in `ps`.
    pub services: BTreeMap<String, Usage>,
    /// Shared memory of all runs of this launcher, KiB.
    pub shared_memory_kib: u64,
    pub shared_memory_objects: u64,
}

/// Growth of a run's resources: the median of its last quarter minus the median of its second quarter. The first
/// quarter is left out: loops touch their pages for the first time then.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Growth of the own memory of the service that grew most, KiB.
    pub memory_kib: f64,
    /// Name of that service in `ps`; empty if no service grew.
    #[serde(default)]
    pub memory_of: String,
    /// Descriptors of the service that gained most.
    pub descriptors: f64,
    pub shared_memory_kib: f64,
    pub shared_memory_objects: f64,
    /// Median of the last quarter: resident sets of all services, KiB.
    pub all_memory_kib: f64,
    /// The same of all services' descriptors.
    pub all_descriptors: f64,
    pub all_shared_memory_kib: f64,
}

impl Sample {
    /// The services that this process started, this process itself, and their shared memory.
    pub fn take() -> Self {
        let own = std::process::id().to_string();
        let mut sample = Self::default();
        for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
            if let Some((name, usage)) = service(&entry.path(), &own) {
                // A standby has its service's name.
                let both = sample.services.entry(name).or_default();
                both.memory_kib += usage.memory_kib;
                both.own_kib += usage.own_kib;
                both.descriptors += usage.descriptors;
            }
        }
        if !sample.services.is_empty()
            && let Some(usage) = usage(Path::new("/proc/self"))
        {
            sample.services.insert(LAUNCHER.into(), usage);
        }
        let prefix = format!("timegap_{:x}-", std::process::id());
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                use std::os::unix::fs::MetadataExt;
                let blocks = entry.metadata().map_or(0, |metadata| metadata.blocks());
                sample.shared_memory_kib += blocks / 2;
                sample.shared_memory_objects += 1;
            }
        }
        sample
    }

    fn sum(&self, figure: fn(&Usage) -> u64) -> u64 {
        self.services.values().map(figure).sum()
    }
}

/// The first word behind `name` in the status of a process.
fn field<'a>(status: &'a str, name: &str) -> Option<&'a str> {
    status.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()
}

/// Name and usage of the process at `path` if it is a service that `parent` started.
fn service(path: &Path, parent: &str) -> Option<(String, Usage)> {
    let status = std::fs::read_to_string(path.join("status")).ok()?;
    if field(&status, "PPid:")? != parent {
        return None;
    }
    let line = std::fs::read(path.join("cmdline")).ok()?;
    let name = String::from_utf8_lossy(line.split(|byte| *byte == 0).next()?).into_owned();
    name.starts_with("timegap-").then_some((name, usage(path)?))
}

/// Resources of the process at `path`.
fn usage(path: &Path) -> Option<Usage> {
    let status = std::fs::read_to_string(path.join("status")).ok()?;
    let kib = |name| field(&status, name)?.parse::<u64>().ok();
    let own_kib = kib("RssAnon:")? + kib("RssShmem:")?;
    let descriptors = std::fs::read_dir(path.join("fd")).ok()?.count() as u64;
    Some(Usage { memory_kib: kib("VmRSS:")?, own_kib, descriptors })
}

impl Growth {
    /// The growth over these samples; none if they are too few for quarters, or show no service.
    pub fn over(samples: &[Sample]) -> Option<Self> {
        let quarter = samples.len() / 4;
        let (early, late) = (&samples[quarter..2 * quarter], &samples[samples.len() - quarter..]);
        if late.iter().all(|sample| sample.services.is_empty()) {
            return None;
        }
        let grown = |figure: &dyn Fn(&Sample) -> Option<u64>| {
            Some(median(late, figure)? - median(early, figure)?)
        };
        let names: std::collections::BTreeSet<&String> =
            samples.iter().flat_map(|sample| sample.services.keys()).collect();
        let most = |figure: fn(&Usage) -> u64| {
            let of = |name: &&&String| grown(&|sample| sample.services.get(**name).map(figure));
            let grown = names.iter().filter_map(|name| Some((of(&name)?, name.as_str())));
            grown.fold((0.0, ""), |most, next| if next.0 > most.0 { next } else { most })
        };
        let (memory_kib, memory_of) = most(|usage| usage.own_kib);
        let (descriptors, _) = most(|usage| usage.descriptors);
        Some(Self {
            memory_kib,
            memory_of: memory_of.into(),
            descriptors,
            shared_memory_kib: grown(&|sample| Some(sample.shared_memory_kib))?,
            shared_memory_objects: grown(&|sample| Some(sample.shared_memory_objects))?,
            all_memory_kib: median(late, &|sample| Some(sample.sum(|usage| usage.memory_kib)))?,
            all_descriptors: median(late, &|sample| Some(sample.sum(|usage| usage.descriptors)))?,
            all_shared_memory_kib: median(late, &|sample| Some(sample.shared_memory_kib))?,
        })
    }
}

fn median(samples: &[Sample], figure: &dyn Fn(&Sample) -> Option<u64>) -> Option<f64> {
    let mut values: Vec<u64> = samples.iter().filter_map(figure).collect();
    values.sort_unstable();
    values.get(values.len() / 2).map(|value| *value as f64)
}

/// Processes, shared-memory objects and files of the run whose root was `root`.
pub fn leftovers(root: &Path) -> Vec<String> {
    let mut left = Vec::new();
    if root.exists() {
        left.push(format!("directory {}", root.display()));
    }
    let id = root.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!("timegap_{id}_");
    for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(&prefix) {
            left.push(format!("shared memory {name}"));
        }
    }
    let root = root.to_string_lossy();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.parse::<u32>().is_err() {
            continue;
        }
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line);
        if line.split('\0').any(|word| word == root) {
            left.push(format!("process {name} ({})", line.split('\0').next().unwrap_or_default()));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(memory_kib: u64, descriptors: u64, shared_memory_kib: u64) -> Sample {
        let usage = Usage { memory_kib, own_kib: memory_kib, descriptors };
        let other = Usage { memory_kib: 900, own_kib: 100, descriptors: 5 };
        let services = [("timegap-plant".into(), usage), ("timegap-controller".into(), other)];
        Sample { services: services.into(), shared_memory_kib, shared_memory_objects: 7 }
    }

    #[test]
    fn a_flat_run_does_not_grow_whatever_its_begin_and_its_spikes() {
        let mut samples: Vec<_> = (0..40).map(|_| sample(1000, 20, 300)).collect();
        samples[0] = sample(10, 3, 0);
        samples[35] = sample(500, 90, 300);
        let growth = Growth::over(&samples).expect("40 samples");
        let flat = Growth {
            memory_kib: 0.0,
            memory_of: String::new(),
            descriptors: 0.0,
            shared_memory_kib: 0.0,
            shared_memory_objects: 0.0,
            all_memory_kib: 1900.0,
            all_descriptors: 25.0,
            all_shared_memory_kib: 300.0,
        };
        assert_eq!(growth, flat);
    }

    #[test]
    fn a_leak_shows_by_its_service() {
        let samples: Vec<_> = (0..40).map(|k| sample(1000 + 8 * k, 20 + k, 300 + k)).collect();
        let growth = Growth::over(&samples).expect("40 samples");
        // Medians of samples 10 to 19 and 30 to 39 are 20 samples apart.
        assert_eq!((growth.memory_kib, growth.descriptors), (160.0, 20.0));
        assert_eq!(growth.memory_of, "timegap-plant");
        assert_eq!(growth.shared_memory_kib, 20.0);
    }

    #[test]
    fn pages_of_the_program_are_no_growth() {
        let mut samples: Vec<_> = (0..40).map(|_| sample(1000, 20, 300)).collect();
        for sample in &mut samples[20..] {
            sample.services.get_mut("timegap-controller").expect("it is there").memory_kib = 5000;
        }
        let growth = Growth::over(&samples).expect("40 samples");
        assert_eq!((growth.memory_kib, growth.all_memory_kib), (0.0, 6000.0));
    }

    #[test]
    fn three_samples_say_nothing() {
        assert_eq!(Growth::over(&[sample(1, 1, 1), sample(2, 2, 2), sample(3, 3, 3)]), None);
        assert_eq!(Growth::over(&vec![Sample::default(); 40]), None, "nor do any without services");
    }

    #[test]
    fn a_sample_of_a_process_without_services_is_empty() {
        assert_eq!(Sample::take().services, BTreeMap::new());
    }

    #[test]
    fn a_directory_an_object_and_a_process_are_found() {
        let id = format!("leftovers-{}", std::process::id());
        let root = std::env::temp_dir().join(&id);
        assert_eq!(leftovers(&root), [] as [String; 0]);
        std::fs::create_dir(&root).expect("the temporary directory is writable");
        let object = Path::new("/dev/shm").join(format!("timegap_{id}_segment"));
        std::fs::write(&object, "").expect("shared memory is writable");
        let mut process = std::process::Command::new("tail")
            .args(["-f", "/dev/null", "--"])
            .arg(&root)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("tail is everywhere");
        // A process that was just started may not show its arguments yet.
        let begun = std::time::Instant::now();
        let mut found = leftovers(&root);
        while found.len() < 3 && begun.elapsed().as_secs() < 10 {
            std::thread::yield_now();
            found = leftovers(&root);
        }
        process.kill().expect("our own child");
        process.wait().expect("our own child");
        std::fs::remove_file(&object).expect("ours");
        std::fs::remove_dir(&root).expect("ours");
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("directory") && found[1].starts_with("shared memory"));
        assert!(found[2].starts_with("process"), "{found:?}");
    }
}
