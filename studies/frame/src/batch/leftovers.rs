//! Leftovers of a run that is over. There should be none.

use std::path::Path;

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
