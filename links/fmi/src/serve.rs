//! The process of a unit: it reads questions from its standard input and writes answers to its standard output, as a
//! law's program does.
//!
//! The unit is unpacked below the directory for temporary files, which a companion process removes whatever ends this one.
//! Text that the unit prints goes to standard error.

use crate::UnitError;
use crate::instance::Instance;
use crate::quantity::{Flow, Request};
use crate::unit::{Part, Unit};
use bytemuck::Pod;
use messages::LawInput;
use std::fs::{self, DirBuilder, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};

/// Most steps of a unit for one question: one that was late catches up.
const MOST_STEPS: u32 = 1000;

/// Runs the process `timegap service fmu WHAT ...`: `law UNIT WORDS` or `vehicle UNIT WORDS`.
pub fn run(arguments: &[String]) -> ExitCode {
    let served = match arguments {
        [what, unit, words @ ..] if what == "law" => serve::<_, LawInput>(Path::new(unit), words),
        [what, unit, words @ ..] if what == "vehicle" => {
            serve::<_, Request>(Path::new(unit), words)
        }
        _ => Err(UnitError::new("timegap service fmu", "other words", "law or vehicle")),
    };
    ended(served.map_err(|error| format!("{}{error}", crate::LAST_WORD)))
}

/// Status of a unit's process; a reason for status 2 goes to standard error.
pub fn ended(served: Result<(), String>) -> ExitCode {
    let Err(reason) = served else { return ExitCode::SUCCESS };
    let _ = writeln!(io::stderr(), "{reason}");
    ExitCode::from(2)
}

/// A directory for a unit's files, with the process that removes it.
struct Unpacked {
    path: PathBuf,
    companion: Child,
}

impl Unpacked {
    fn create() -> io::Result<Self> {
        let path = std::env::temp_dir().join(format!("timegap-fmu-{}", std::process::id()));
        // The remains of another process that had this number.
        let _ = fs::remove_dir_all(&path);
        DirBuilder::new().mode(0o700).create(&path)?;
        // It reads until this process is gone.
        let companion = Command::new("sh")
            .args(["-c", "cat; rm -rf -- \"$0\""])
            .arg(&path)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            // A hanging unit is killed with its group.
            .process_group(0)
            .spawn()?;
        Ok(Self { path, companion })
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        drop(self.companion.stdin.take());
        let _ = self.companion.wait();
    }
}

fn serve<A: Pod, Q: Part<A> + Pod>(path: &Path, words: &[String]) -> Result<(), UnitError> {
    let system = |error: io::Error| {
        UnitError::new(path.display(), error.to_string(), "a machine that lets it run")
    };
    let unit = Unit::<Q, A>::read(path, words)?;
    let (mut questions, mut answers) = own_streams().map_err(system)?;
    let unused = unit.wiring.unused.join(", ");
    if !unused.is_empty() {
        eprintln!("{}: inputs that keep their start: {unused}", path.display());
    }
    let directory = Unpacked::create().map_err(system)?;
    let platform = unit.library.rsplit_once('/').map_or("binaries/", |(folder, _)| folder);
    unit.archive.unpack(&[platform, "resources/"], &directory.path)?;
    fs::create_dir_all(directory.path.join("resources")).map_err(system)?;
    let library = directory.path.join(&unit.library);
    let instance = Instance::load(&unit.name, &unit.description, &library, &directory.path)?;
    let mut running = Running { unit: &unit, instance, question_s: 0.0, is_fresh: false };
    let mut question = Q::zeroed();
    let mut is_first = true;
    // The host closes its pipes when the process is to go: that is no error.
    while questions.read_exact(bytemuck::bytes_of_mut(&mut question)).is_ok() {
        let answer = running.answer(&question)?;
        if answers.write_all(bytemuck::bytes_of(&answer)).is_err() {
            break;
        }
        if std::mem::take(&mut is_first) && !unit.begins_as_given() {
            // The first question only proves the unit: the second one finds a new instance.
            running.begin(&question)?;
        }
    }
    Ok(())
}

struct Running<'a, Q: 'static, A: 'static> {
    unit: &'a Unit<Q, A>,
    instance: Instance,
    /// Time of the question at which the instance began, s.
    question_s: f64,
    /// It has not made a step.
    is_fresh: bool,
}

impl<A: Pod, Q: Part<A> + Pod> Running<'_, Q, A> {
    fn begin(&mut self, question: &Q) -> Result<(), UnitError> {
        let wiring = &self.unit.wiring;
        let given = wiring.starts.iter().map(|(variable, value)| (variable, *value));
        let own = wiring.wires.iter().filter_map(|(quantity, variable, measure)| {
            let Flow::Start(value) = quantity.flow else { return None };
            Some((variable, measure.of_si(value(question))))
        });
        self.instance.begin(given.chain(own))?;
        self.is_fresh = true;
        Ok(())
    }

    fn answer(&mut self, question: &Q) -> Result<A, UnitError> {
        let (sequence, reset, time_s, period_s) = question.head();
        if reset != 0 && (!self.is_fresh || self.unit.begins_as_given()) {
            self.begin(question)?;
        }
        if self.is_fresh {
            self.question_s = time_s;
        }
        for (quantity, variable, measure) in &self.unit.wiring.wires {
            if let Flow::Input(value) = quantity.flow {
                self.instance.set(variable, measure.of_si(value(question)))?;
            }
        }
        let what = &self.unit.description;
        let proposed_s = what.proposed_s.filter(|step_s| *step_s < period_s);
        let step_s = what.step_s.or(proposed_s).unwrap_or(period_s);
        let target_s = time_s - self.question_s + period_s;
        self.is_fresh = false;
        for _ in 0..MOST_STEPS {
            if self.instance.time_s + 0.5 * step_s > target_s {
                break;
            }
            self.instance.step(step_s)?;
        }
        let mut answer = A::zeroed();
        bytemuck::bytes_of_mut(&mut answer)[..8].copy_from_slice(bytemuck::bytes_of(&sequence));
        for (quantity, variable, measure) in &self.unit.wiring.wires {
            if let Flow::Output(keep) = quantity.flow {
                keep(&mut answer, measure.to_si(self.instance.get(variable)?));
            }
        }
        match question.fault(&answer).filter(|_| reset != 0) {
            Some((fault, expected)) => Err(UnitError::new(&self.unit.name, fault, expected)),
            None => Ok(answer),
        }
    }
}

/// Streams for questions and answers alone: the unit reads nothing, and prints to standard error.
fn own_streams() -> io::Result<(File, File)> {
    let own = (rustix::io::dup(io::stdin())?.into(), rustix::io::dup(io::stdout())?.into());
    rustix::stdio::dup2_stdin(File::open("/dev/null")?)?;
    rustix::stdio::dup2_stdout(io::stderr())?;
    Ok(own)
}
