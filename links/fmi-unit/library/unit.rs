//! The library of an exported unit: FMI 2.0's functions around a process of `timegap`, which the unit's resources have.
//! Numbers go through two pipes.
//!
//! ```text
//! question: 1 to begin or 2 to step │ step, s │ 64 values by number         answer: 64 values
//! ```

#![allow(non_snake_case)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

type Text = *const c_char;
type Log = unsafe extern "C" fn(*mut c_void, Text, c_int, Text, Text, ...);

const VALUES: usize = 64;
const OK: c_int = 0;
const ERROR: c_int = 3;
const FATAL: c_int = 4;

/// Callbacks that the master lends: its log comes first, its own data last.
#[repr(C)]
pub struct Callbacks {
    log: Option<Log>,
    unused: [*mut c_void; 3],
    environment: *mut c_void,
}

/// An instance: its values, and its process.
pub struct Instance {
    name: CString,
    log: Option<(Log, *mut c_void)>,
    resources: PathBuf,
    values: [f64; VALUES],
    process: Option<Child>,
}

impl Instance {
    fn say(&self, text: &str) {
        if let (Some((log, environment)), Ok(text)) = (self.log, CString::new(text)) {
            // SAFETY: the master's own function, with texts that end with zero; `%s` takes one of them.
            unsafe {
                log(environment, self.name.as_ptr(), ERROR, c"error".as_ptr(), c"%s".as_ptr(), text.as_ptr());
            }
        }
    }

    /// Starts the process: the program in the unit's resources.
    fn start(&self) -> io::Result<Child> {
        let program = self.resources.join("timegap");
        // Masters that unpack a unit may forget that a file is a program.
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755))?;
        Command::new(program)
            .args(["service", "unit"])
            .arg(&self.resources)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
    }

    /// Asks the process: 1 begins, 2 steps.
    fn ask(&mut self, what: f64, step_s: f64) -> io::Result<()> {
        let mut process = match self.process.take() {
            Some(process) => process,
            None => self.start()?,
        };
        let question = [what, step_s].into_iter().chain(self.values);
        let question: Vec<u8> = question.flat_map(f64::to_ne_bytes).collect();
        let mut answer = [0; 8 * VALUES];
        let (Some(input), Some(output)) = (&mut process.stdin, &mut process.stdout) else {
            return Err(io::Error::other("no pipe"));
        };
        input.write_all(&question)?;
        output.read_exact(&mut answer)?;
        for (value, bytes) in self.values.iter_mut().zip(answer.chunks_exact(8)) {
            *value = f64::from_ne_bytes(bytes.try_into().map_err(io::Error::other)?);
        }
        self.process = Some(process);
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(mut process) = self.process.take() {
            // It ends with its input.
            drop(process.stdin.take());
            let _ = process.wait();
        }
    }
}

/// Calls into an instance. A panic must not reach the master.
fn with(instance: *mut Instance, act: impl FnOnce(&mut Instance) -> io::Result<()>) -> c_int {
    // SAFETY: the master hands over what `fmi2Instantiate` gave it, in one call at a time.
    let Some(instance) = (unsafe { instance.as_mut() }) else { return ERROR };
    match catch_unwind(AssertUnwindSafe(|| act(instance).map_err(|error| instance.say(&error.to_string())))) {
        Ok(Ok(())) => OK,
        Ok(Err(())) => ERROR,
        Err(_) => FATAL,
    }
}

/// Visits the values of variables, each with its place in the master's list of `count` numbers.
fn each(instance: *mut Instance, of: *const u32, count: usize, visit: impl Fn(&mut f64, usize)) -> c_int {
    with(instance, |own| {
        (0..count).try_for_each(|k| {
            // SAFETY: the list has `count` entries.
            let value = own.values.get_mut(unsafe { *of.add(k) } as usize);
            value.map(|value| visit(value, k)).ok_or_else(|| io::Error::other("no such variable"))
        })
    })
}

/// The path of a `file:` address.
fn path_of(address: &str) -> PathBuf {
    let rest = address.strip_prefix("file:").unwrap_or(address);
    let rest = rest.strip_prefix("//").unwrap_or(rest);
    let (mut bytes, mut left) = (Vec::new(), rest.as_bytes());
    while let Some((first, more)) = left.split_first() {
        let code = more.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()).filter(|_| *first == b'%') {
            Some(byte) => (bytes.push(byte), left = &more[2..]).0,
            None => (bytes.push(*first), left = more).0,
        }
    }
    PathBuf::from(String::from_utf8_lossy(&bytes).into_owned())
}

macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty $body:block)*) => {
        $(#[unsafe(no_mangle)] pub unsafe extern "C" fn $name($($argument: $type),*) -> $result $body)*
    };
}

functions! {
    fmi2GetTypesPlatform() -> Text { c"default".as_ptr() }
    fmi2GetVersion() -> Text { c"2.0".as_ptr() }
    fmi2Instantiate(name: Text, kind: c_int, _token: Text, resources: Text, callbacks: *const Callbacks, _visible: c_int, _logs: c_int) -> *mut Instance {
        // Kind 1 is co-simulation.
        if kind != 1 || name.is_null() || resources.is_null() {
            return std::ptr::null_mut();
        }
        // SAFETY: the standard asks the master for texts that end with zero, and for callbacks that outlive the instance.
        let (name, resources, callbacks) =
            unsafe { (CStr::from_ptr(name).to_owned(), CStr::from_ptr(resources), callbacks.as_ref()) };
        let instance = Instance {
            name,
            log: callbacks.and_then(|own| Some((own.log?, own.environment))),
            resources: path_of(&resources.to_string_lossy()),
            values: [f64::NAN; VALUES],
            process: None,
        };
        Box::into_raw(Box::new(instance))
    }
    fmi2FreeInstance(instance: *mut Instance) -> () {
        if !instance.is_null() {
            // SAFETY: it came from `Box::into_raw`, and the master does not use it again.
            drop(unsafe { Box::from_raw(instance) });
        }
    }
    fmi2ExitInitializationMode(instance: *mut Instance) -> c_int {
        with(instance, |own| own.ask(1.0, 0.0))
    }
    fmi2Reset(instance: *mut Instance) -> c_int {
        with(instance, |own| {
            // The process gives its start to each value that is not a number.
            own.values = [f64::NAN; VALUES];
            Ok(())
        })
    }
    fmi2SetReal(instance: *mut Instance, references: *const u32, count: usize, values: *const f64) -> c_int {
        // SAFETY: the list has `count` entries.
        each(instance, references, count, |own, k| *own = unsafe { *values.add(k) })
    }
    fmi2GetReal(instance: *mut Instance, references: *const u32, count: usize, values: *mut f64) -> c_int {
        // SAFETY: the list has `count` entries.
        each(instance, references, count, |own, k| unsafe { *values.add(k) = *own })
    }
    fmi2DoStep(instance: *mut Instance, _time: f64, step_s: f64, _new: c_int) -> c_int {
        with(instance, |own| own.ask(2.0, step_s))
    }
}

/// Functions for what the unit does not have: they accept nothing at all.
macro_rules! without {
    ($($name:ident)*) => {
        $(#[unsafe(no_mangle)] pub extern "C" fn $name(_i: *mut Instance, _r: *const u32, count: usize, _v: *const c_void) -> c_int {
            if count == 0 { OK } else { ERROR }
        })*
    };
}

without! {
    fmi2SetInteger fmi2SetBoolean fmi2SetString fmi2GetInteger fmi2GetBoolean fmi2GetString
}

/// Functions with one answer, whatever their arguments.
macro_rules! constant {
    ($($status:ident: $($name:ident)*;)*) => {
        $($(#[unsafe(no_mangle)] pub extern "C" fn $name() -> c_int { $status })*)*
    };
}

constant! {
    OK: fmi2SetDebugLogging fmi2SetupExperiment fmi2EnterInitializationMode fmi2Terminate;
    ERROR: fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate fmi2SerializedFMUstateSize fmi2SerializeFMUstate
    fmi2DeSerializeFMUstate fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives
    fmi2CancelStep fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus;
}
