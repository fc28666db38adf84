//! The program SUMO as a process, from its start to its end.

use std::fmt::Display;
use std::io::{self, Read};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::STEP_MS;

/// Time until the program has read its files and listens.
const START: Duration = Duration::from_secs(60);
/// Time between two attempts to reach it.
const ATTEMPT: Duration = Duration::from_millis(5);
/// Time to end after the connection is closed.
const END: Duration = Duration::from_secs(1);
/// Bytes of its errors that are kept.
const KEPT_BYTES: u64 = 8 << 10;

/// Options of all runs: quiet, repeatable, without a reaction to collisions.
const OPTIONS: &str = "--random false --collision.action none --no-step-log true --no-warnings true \
    --duration-log.disable true --xml-validation never --num-clients 1";

/// A failure of the program SUMO, before or during a run, in one line.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    #[error("SUMO: cannot start {0}: {1}")]
    Start(String, std::io::Error),
    #[error("SUMO: no answer {0} within {1} s")]
    Silent(&'static str, f64),
    #[error("SUMO: {0} was refused: {1}")]
    Refused(&'static str, String),
    #[error("SUMO: an answer that is not TraCI: {0}")]
    Nonsense(&'static str),
    #[error("SUMO: {0}")]
    Unfit(String),
}

impl ProgramError {
    pub(crate) fn start(program: impl Display) -> impl Fn(std::io::Error) -> Self {
        move |reason| Self::Start(program.to_string(), reason)
    }
}

/// How a process is started on this machine, and how it is reached.
pub trait Network {
    /// Prepares the command: what the process inherits, and when it dies.
    fn prepare(&mut self, command: &mut Command) -> io::Result<()>;

    /// Connects to a port; an error while the process does not listen there.
    fn connect(&mut self, port: u16) -> io::Result<TcpStream>;
}

/// Finds `sumo` in `$SUMO_HOME/bin` or on the `PATH`. The script of the Python package leads to the program itself.
fn find_program() -> Result<PathBuf, ProgramError> {
    let (home, path) = (std::env::var_os("SUMO_HOME"), std::env::var_os("PATH"));
    let home = home.map(|home| PathBuf::from(home).join("bin/sumo"));
    let path = path.unwrap_or_default();
    let on_path = std::env::split_paths(&path).map(|place| place.join("sumo"));
    let found = home.into_iter().chain(on_path).find(|file| file.is_file());
    found.map(|file| packaged(&file).unwrap_or(file)).ok_or_else(|| {
        let program = "there is no program `sumo` in $SUMO_HOME/bin or on the PATH";
        let expected = "SUMO 1.20 or later (pip install eclipse-sumo)";
        ProgramError::Unfit(format!("{program}, expected {expected}"))
    })
}

const PACKAGE: &str = "site-packages/sumo";

/// The program behind a script of the Python package: `../lib/python3.x/site-packages/sumo/bin/sumo`.
fn packaged(file: &Path) -> Option<PathBuf> {
    let mut begin = [0; 2];
    std::fs::File::open(file).ok()?.read_exact(&mut begin).ok()?;
    let libraries = file.parent()?.parent()?.join("lib");
    let versions = std::fs::read_dir(libraries).ok().filter(|_| begin == *b"#!")?;
    let programs = versions.flatten().map(|one| one.path().join(PACKAGE).join("bin/sumo"));
    programs.into_iter().find(|program| program.is_file())
}

#[derive(Debug)]
pub struct Process {
    child: Child,
    errors: Option<JoinHandle<Vec<String>>>,
}

impl Process {
    /// Finds and starts the program with a configuration and a seed; the port on which it will listen.
    pub fn start(
        (config, seed): (&Path, u64),
        prepare: impl FnOnce(&mut Command) -> io::Result<()>,
    ) -> Result<(Self, u16), ProgramError> {
        let program = find_program()?;
        let refuse = ProgramError::start(program.display());
        // Nothing uses this port at the moment.
        let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|free| free.local_addr());
        let port = free.map_err(&refuse)?.port();
        let mut command = Command::new(&program);
        command.arg("-c").arg(config).args(OPTIONS.split_whitespace());
        command.args(["--step-length", &(STEP_MS as f64 * 1e-3).to_string()]);
        command.args(["--seed", &(seed % (1 << 31)).to_string()]);
        command.args(["--remote-port", &port.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        if let Some(home) = program.ancestors().nth(2).filter(|home| home.ends_with(PACKAGE)) {
            command.env("SUMO_HOME", home);
        }
        prepare(&mut command).map_err(&refuse)?;
        let mut child = command.spawn().map_err(&refuse)?;
        let errors = child.stderr.take().map(|errors| std::thread::spawn(move || lines(errors)));
        Ok((Self { child, errors }, port))
    }

    /// Connects to a port as soon as the program listens there.
    pub fn connect(
        &mut self,
        port: u16,
        network: &mut dyn Network,
    ) -> Result<TcpStream, ProgramError> {
        let begun = Instant::now();
        loop {
            if let Ok(stream) = network.connect(port) {
                return Ok(stream);
            }
            if self.is_gone() {
                return Err(self.ended("at its start"));
            }
            if begun.elapsed() > START {
                return Err(ProgramError::Silent("at its start", START.as_secs_f64()));
            }
            std::thread::sleep(ATTEMPT);
        }
    }

    fn is_gone(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    /// The error of a connection that broke: the program's last words, or its status.
    pub fn ended(&mut self, when: &str) -> ProgramError {
        let status = self.end();
        let lines = self.errors.take().and_then(|errors| errors.join().ok()).unwrap_or_default();
        let fault = lines.iter().find_map(|line| line.strip_prefix("Error: "));
        let is_word = |line: &&String| !line.trim().is_empty() && !line.starts_with("Quitting");
        let last = || lines.iter().rev().find(is_word).map(String::as_str);
        let status = status.map_or_else(|error| error.to_string(), |status| status.to_string());
        let words = fault.or_else(last).unwrap_or(&status);
        ProgramError::Unfit(format!("ended {when}: {words}"))
    }

    pub fn kill(&mut self) {
        let _ = self.child.kill();
    }

    /// Waits for its end, which the closed connection brings, and kills it otherwise.
    pub fn end(&mut self) -> io::Result<ExitStatus> {
        let begun = Instant::now();
        while !self.is_gone() && begun.elapsed() < END {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.kill();
        self.child.wait()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
        let _ = self.child.wait();
    }
}

/// The first lines of a stream, which is read to its end.
fn lines(mut stream: impl Read) -> Vec<String> {
    let mut text = Vec::new();
    let _ = (&mut stream).take(KEPT_BYTES).read_to_end(&mut text);
    let _ = io::copy(&mut stream, &mut io::sink());
    let printable = |line: &str| line.chars().filter(|c| !c.is_control()).take(300).collect();
    String::from_utf8_lossy(&text).lines().map(printable).collect()
}
