//! The program SUMO as a process, from its start to its end.

use std::io::{self, BufRead, BufReader, Read};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::{ProgramError, STEP_MS};

/// Time until the program has read its files and listens.
const START: Duration = Duration::from_secs(60);
/// Time between two attempts to reach it.
const ATTEMPT: Duration = Duration::from_millis(5);
/// Time to end after the connection is closed.
const END: Duration = Duration::from_secs(1);
/// Lines of its errors that are kept.
const KEPT_LINES: usize = 40;

/// Options of all runs: quiet, repeatable, without a reaction to collisions.
const OPTIONS: &str = "--random false --collision.action none --no-step-log true --no-warnings true \
    --duration-log.disable true --xml-validation never --num-clients 1";

/// How a process is started on this machine, and how it is reached.
pub trait Network {
    /// Prepares the command: what the process inherits, and when it dies.
    fn prepare(&mut self, command: &mut Command) -> io::Result<()>;

    /// Connects to a port on which the process listens.
    ///
    /// # Errors
    /// While it does not listen yet.
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
        ProgramError(format!("{program}, expected {expected}"))
    })
}

/// Home of the Python package.
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

/// The running program.
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
        let port = free_port().map_err(&refuse)?;
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
            match network.connect(port) {
                Ok(stream) => return Ok(stream),
                Err(_) if begun.elapsed() > START => {
                    return Err(ProgramError::silent("at its start", START.as_secs_f64()));
                }
                Err(_) => std::thread::sleep(ATTEMPT),
            }
            if self.is_gone() {
                return Err(self.ended("at its start"));
            }
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
        let last = || lines.iter().rev().find(|line| !line.starts_with("Quitting"));
        let words = fault.or_else(|| last().map(String::as_str)).map(str::to_owned);
        let words = words.unwrap_or_else(|| match status {
            Ok(status) => status.to_string(),
            Err(error) => error.to_string(),
        });
        ProgramError(format!("ended {when}: {words}"))
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

/// A port that nothing uses at the moment.
fn free_port() -> io::Result<u16> {
    Ok(TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr()?.port())
}

/// The first lines of a stream, which is read to its end.
fn lines(stream: impl Read) -> Vec<String> {
    let mut kept = Vec::new();
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        if kept.len() < KEPT_LINES && !line.trim().is_empty() {
            let printable = line.chars().filter(|c| !c.is_control()).take(300);
            kept.push(printable.collect());
        }
    }
    kept
}
