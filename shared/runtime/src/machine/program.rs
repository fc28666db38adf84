//! A program of the user's that takes part in a run: its command, and the digest of what it runs.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Name of the file that was written for the purpose, without its directory and its ending.
    pub name: String,
    /// Its command, as a shell reads it.
    pub command: String,
    /// The file whose bytes the digest is of: the script that an interpreter runs, or the program.
    pub file: PathBuf,
    /// SHA-256 of that file, in hexadecimal digits.
    pub sha256: String,
}

/// Reason why a command names no program.
#[derive(Debug, thiserror::Error)]
#[error("{message}, expected {expected}")]
pub struct ProgramError {
    pub message: String,
    pub expected: &'static str,
}

impl ProgramError {
    fn new(message: impl Into<String>, expected: &'static str) -> Self {
        Self { message: message.into(), expected }
    }

    fn missing(name: &str) -> Self {
        let expected = "the path of a program or its name on the PATH";
        Self::new(format!("there is no program `{name}`"), expected)
    }
}

impl Program {
    /// The program of `command`, whose relative paths start at `directory`.
    pub fn of(command: &[String], directory: &Path) -> Result<Self, ProgramError> {
        let executable = executable(command, directory)?;
        let file = script(command, directory).unwrap_or(executable);
        let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        Ok(Self {
            name: stem.unwrap_or_default(),
            command: command_line(command),
            sha256: digest(&file)?,
            file,
        })
    }

    /// The first digits of the digest, for a line that is short.
    pub fn short_digest(&self) -> &str {
        self.sha256.get(..12).unwrap_or(&self.sha256)
    }
}

/// The file that runs when `command` is started in `directory`.
pub fn executable(command: &[String], directory: &Path) -> Result<PathBuf, ProgramError> {
    let name = command.first().filter(|name| !name.is_empty()).ok_or_else(|| {
        ProgramError::new("no program", "its name and its arguments, a text each")
    })?;
    // A unit of the Functional Mock-up Interface is run by a process of timegap's own.
    let is_unit = fmi::is_unit(name);
    if is_unit || name.contains('/') {
        let path = directory.join(name);
        return match path.metadata() {
            Err(_) => Err(ProgramError::missing(name)),
            Ok(_) if is_unit || fmi::is_executable(&path) => Ok(path),
            Ok(_) => Err(ProgramError::new(
                format!("`{name}` is not an executable file"),
                "one (a script needs a `#!` line and the permission to execute)",
            )),
        };
    }
    fmi::on_path(name).ok_or_else(|| ProgramError::missing(name))
}

/// The first argument that is a file: what an interpreter runs.
fn script(command: &[String], directory: &Path) -> Option<PathBuf> {
    let arguments = command.iter().skip(1).filter(|word| !word.starts_with('-'));
    arguments.map(|word| directory.join(word)).find(|path| path.is_file())
}

/// SHA-256 of a file.
fn digest(path: &Path) -> Result<String, ProgramError> {
    let error = |reason: std::io::Error| {
        let what = format!("cannot read {}: {reason}", path.display());
        ProgramError::new(what, "a file that can be read")
    };
    let mut file = File::open(path).map_err(error)?;
    let (mut hash, mut part) = (Sha256::new(), vec![0; 64 << 10]);
    loop {
        match file.read(&mut part).map_err(error)? {
            0 => break,
            count => hash.update(&part[..count]),
        }
    }
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Words as a shell reads them, quoted where they must be.
///
/// ```
/// assert_eq!(runtime::command_line(&["python3", "my law.py", ""]), "python3 'my law.py' ''");
/// ```
///
/// # Panics
/// Never: the quoter refuses zero bytes alone, and they are allowed here.
pub fn command_line<S: AsRef<str>>(words: &[S]) -> String {
    let quoter = shlex::Quoter::new().allow_nul(true);
    quoter.join(words.iter().map(AsRef::as_ref)).expect("zero bytes are allowed")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        line.split(' ').map(str::to_owned).collect()
    }

    #[test]
    fn the_script_counts_and_else_the_program() {
        let here = std::env::temp_dir().join(format!("timegap-program-{}", std::process::id()));
        std::fs::create_dir_all(&here).expect("the temporary directory is writable");
        std::fs::write(here.join("law.py"), "abc").expect("ours");
        let program = Program::of(&words("sh -u law.py 2"), &here).expect("sh is everywhere");
        assert_eq!((program.name.as_str(), program.command.as_str()), ("law", "sh -u law.py 2"));
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(program.sha256, abc);
        let shell = Program::of(&["sh".into(), "-c".into(), "echo 'a b'".into()], &here);
        let shell = shell.expect("sh is everywhere");
        assert_eq!((shell.name.as_str(), shell.sha256.len()), ("sh", 64));
        assert_eq!(shell.command, "sh -c \"echo 'a b'\"");
        let refused = |line: &str| {
            let error = Program::of(&words(line), &here).expect_err("it is none");
            error.to_string()
        };
        assert!(refused("./law.py").contains("not an executable file"));
        assert!(refused("./no-such").contains("no program `./no-such`"));
        assert!(refused("no-such-program-anywhere").contains("PATH"));
        assert!(refused("").contains("expected its name"));
        std::fs::remove_dir_all(&here).expect("ours");
    }
}
