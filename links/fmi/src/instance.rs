//! A running unit: its shared library, and the calls of FMI 2.0 and 3.0.
//!
//! `unsafe` is what the interface is made of: a foreign library is loaded and called through pointers. This is why a unit
//! runs in a process of its own. The prototypes are those of the standards' headers `fmi2FunctionTypes.h` and
//! `fmi3FunctionTypes.h`.

#![allow(unsafe_code)]

use crate::UnitError;
use crate::description::{Description, Variable, Version};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

type Text = *const c_char;
type Pointer = *mut c_void;
type LogThree = unsafe extern "C" fn(Pointer, c_int, Text, Text);

/// Last error that the unit wrote to its log.
static SAID: Mutex<String> = Mutex::new(String::new());
/// Statuses up to this one let a unit go on: OK and warning.
const WARNING: c_int = 1;
const STATUSES: [&str; 6] = ["OK", "a warning", "discard", "an error", "a fatal error", "pending"];
/// `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;

/// Functions that a unit of version 2 may call.
#[repr(C)]
struct Callbacks {
    log: unsafe extern "C" fn(Pointer, Text, c_int, Text, Text),
    allocate: unsafe extern "C" fn(usize, usize) -> Pointer,
    free: unsafe extern "C" fn(Pointer),
    /// The last two are null.
    finished: usize,
    environment: usize,
}

static CALLBACKS: Callbacks = Callbacks {
    log: log_two,
    allocate: libc::calloc,
    free: libc::free,
    finished: 0,
    environment: 0,
};

/// The function has more arguments, for the places in the message. They are not read.
unsafe extern "C" fn log_two(_: Pointer, _: Text, status: c_int, _: Text, message: Text) {
    // SAFETY: the standard asks the unit for a text that ends with zero.
    unsafe { keep(status, message) }
}

unsafe extern "C" fn log_three(_: Pointer, status: c_int, _: Text, message: Text) {
    // SAFETY: the standard asks the unit for a text that ends with zero.
    unsafe { keep(status, message) }
}

unsafe fn keep(status: c_int, message: Text) {
    if status > WARNING && !message.is_null() {
        // SAFETY: the caller vouches for the text.
        let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
        if let Ok(mut said) = SAID.lock() {
            *said = message.split_whitespace().collect::<Vec<_>>().join(" ");
        }
    }
}

/// Calls a function of the unit's library. The types must be the standard's prototype. The component lives, texts end
/// with zero, and places outlive the call.
macro_rules! call {
    ($unit:ident.$name:expr; $($value:expr => $type:ty),* ; $result:ty) => {{
        let function = $unit.function::<unsafe extern "C" fn($($type),*) -> $result>($name)?;
        // SAFETY: as the macro's contract says.
        unsafe { function($($value),*) }
    }};
}

/// A unit's library, and its instance once it has begun.
pub struct Instance {
    place: String,
    version: Version,
    library: Pointer,
    token: CString,
    resources: CString,
    component: Pointer,
    /// Time since the instance began, s.
    pub time_s: f64,
}

impl Instance {
    /// Loads the library of a unit that is unpacked in `directory`; `place` names the unit in errors.
    pub fn load(
        place: &str,
        description: &Description,
        library: &Path,
        directory: &Path,
    ) -> Result<Self, UnitError> {
        let library = load(library).map_err(|why| {
            UnitError::new(place, format!("its library cannot be loaded: {why}"), "one that can")
        })?;
        let resources = directory.join("resources");
        let resources = match description.version {
            Version::Two => format!("file://{}", resources.display()),
            Version::Three => format!("{}/", resources.display()),
        };
        let text = |text: &str| CString::new(text).expect("neither XML nor a path has zeros");
        Ok(Self {
            place: place.to_owned(),
            version: description.version,
            library,
            token: text(&description.token),
            resources: text(&resources),
            component: null_mut(),
            time_s: 0.0,
        })
    }

    fn refuse(&self, fault: impl Into<String>, expected: &str) -> UnitError {
        let mut fault = fault.into();
        let said = SAID.lock().map(|said| said.clone()).unwrap_or_default();
        if !said.is_empty() {
            fault = format!("{fault} and said `{said}`");
        }
        UnitError::new(&self.place, fault, expected)
    }

    /// A function of the library: `T` must be its prototype.
    fn function<T: Copy>(&self, name: &str) -> Result<T, UnitError> {
        const { assert!(size_of::<T>() == size_of::<Pointer>()) };
        let prefix = if self.version == Version::Two { "fmi2" } else { "fmi3" };
        let symbol = format!("{prefix}{name}\0");
        // SAFETY: the library stays loaded, and the name ends with zero.
        let found = unsafe { libc::dlsym(self.library, symbol.as_ptr().cast()) };
        if found.is_null() {
            let fault = format!("its library has no function `{}`", symbol.trim_end_matches('\0'));
            return Err(self.refuse(fault, "it"));
        }
        // SAFETY: `T` is a function's type by the contract of this function, and not null.
        Ok(unsafe { std::mem::transmute_copy(&found) })
    }

    fn check(&self, function: &str, status: c_int) -> Result<(), UnitError> {
        if status <= WARNING {
            return Ok(());
        }
        let name = STATUSES.get(status as usize).copied().unwrap_or("an unknown status");
        let fault = format!("{function} gave {name} at {:.3} s", self.time_s);
        Err(self.refuse(fault, "OK"))
    }

    fn call(&self, function: &str) -> Result<(), UnitError> {
        self.check(function, call!(self.function; self.component => Pointer; c_int))
    }

    /// Begins anew: a new instance with these starts, initialised at time 0.
    pub fn begin<'a>(
        &mut self,
        starts: impl Iterator<Item = (&'a Variable, f64)>,
    ) -> Result<(), UnitError> {
        self.end();
        (self.component, self.time_s) = (self.instantiate()?, 0.0);
        if self.component.is_null() {
            return Err(self.refuse("it cannot be instantiated", "an instance"));
        }
        for (variable, value) in starts {
            self.set(variable, value)?;
        }
        let (unit, enter) = (self.component, "EnterInitializationMode");
        match self.version {
            Version::Two => {
                let setup = "SetupExperiment";
                let status = call!(self.setup; unit => Pointer, 0 => c_int, 0.0 => f64, 0.0 => f64,
                    0 => c_int, 0.0 => f64; c_int);
                self.check(setup, status)?;
                self.call(enter)?;
            }
            Version::Three => {
                let status = call!(self.enter; unit => Pointer, false => bool, 0.0 => f64, 0.0 => f64,
                    false => bool, 0.0 => f64; c_int);
                self.check(enter, status)?;
            }
        }
        self.call("ExitInitializationMode")
    }

    fn instantiate(&self) -> Result<Pointer, UnitError> {
        let [name, token, resources] =
            [c"timegap", &*self.token, &*self.resources].map(CStr::as_ptr);
        Ok(match self.version {
            Version::Two => {
                let callbacks = &raw const CALLBACKS;
                call!(self."Instantiate"; name => Text, CO_SIMULATION => c_int, token => Text,
                    resources => Text, callbacks => *const Callbacks, 0 => c_int, 1 => c_int; Pointer)
            }
            // Without a window, with a log, without events and early returns.
            Version::Three => call!(self."InstantiateCoSimulation"; name => Text, token => Text,
                resources => Text, false => bool, true => bool, false => bool, false => bool,
                null() => *const u32, 0 => usize, null_mut() => Pointer, log_three => LogThree,
                null_mut() => Pointer; Pointer),
        })
    }

    /// Sets a variable to a number in the unit's own measure.
    pub fn set(&self, variable: &Variable, value: f64) -> Result<(), UnitError> {
        let mut bytes = (variable.kind.encode)(value);
        self.exchange("Set", variable, &mut bytes)
    }

    /// The number of a variable in the unit's own measure.
    pub fn get(&self, variable: &Variable) -> Result<f64, UnitError> {
        let mut bytes = [0; 8];
        self.exchange("Get", variable, &mut bytes)?;
        Ok((variable.kind.decode)(bytes))
    }

    /// Sets or gets one variable: room for one value of any type. The functions that set read it alone.
    fn exchange(&self, way: &str, of: &Variable, value: &mut [u8; 8]) -> Result<(), UnitError> {
        let (unit, reference, value) =
            (self.component, &raw const of.reference, value.as_mut_ptr().cast());
        let name = format!("{way}{}", of.kind.suffix);
        let status = match self.version {
            Version::Two => call!(self.&name; unit => Pointer, reference => *const u32, 1 => usize,
                value => Pointer; c_int),
            Version::Three => {
                call!(self.&name; unit => Pointer, reference => *const u32, 1 => usize,
                value => Pointer, 1 => usize; c_int)
            }
        };
        self.check(&format!("{name} of `{}`", of.name), status)
    }

    pub fn step(&mut self, step_s: f64) -> Result<(), UnitError> {
        let (unit, time_s) = (self.component, self.time_s);
        let (mut event, mut terminates, mut early) = (false, false, false);
        let mut reached_s = time_s + step_s;
        let status = match self.version {
            Version::Two => call!(self."DoStep"; unit => Pointer, time_s => f64, step_s => f64,
                1 => c_int; c_int),
            Version::Three => call!(self."DoStep"; unit => Pointer, time_s => f64, step_s => f64,
                true => bool, &raw mut event => *mut bool, &raw mut terminates => *mut bool,
                &raw mut early => *mut bool, &raw mut reached_s => *mut f64; c_int),
        };
        self.check("DoStep", status)?;
        if terminates {
            return Err(self.refuse("DoStep asked for the end of the simulation", "none"));
        }
        self.time_s += step_s;
        Ok(())
    }

    fn end(&mut self) {
        if self.component.is_null() {
            return;
        }
        let free = || -> Result<(), UnitError> {
            call!(self."FreeInstance"; self.component => Pointer; ());
            Ok(())
        };
        // A unit in an error state may refuse to terminate, and is freed all the same.
        let _ = self.call("Terminate");
        let _ = free();
        self.component = null_mut();
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.end();
    }
}

/// Loads a library. One that lacks Python's functions gets the library of `python3` first.
fn load(path: &Path) -> Result<Pointer, String> {
    let open = |path: &Path, flags: c_int| {
        let text = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|e| e.to_string())?;
        // SAFETY: the text ends with zero. What the library does when it is loaded is the user's.
        let library = unsafe { libc::dlopen(text.as_ptr(), flags) };
        if !library.is_null() {
            return Ok(library);
        }
        // SAFETY: after a failure the text is there, until the next call in this thread.
        let why = unsafe { CStr::from_ptr(libc::dlerror()) }.to_string_lossy().into_owned();
        Err(why)
    };
    let flags = libc::RTLD_NOW | libc::RTLD_LOCAL;
    match open(path, flags) {
        Err(why) if why.contains("Py") || why.contains("libpython") => {
            let Some((library, home)) = python() else { return Err(why) };
            open(Path::new(&library), libc::RTLD_NOW | libc::RTLD_GLOBAL)?;
            if std::env::var_os("PYTHONHOME").is_none() {
                // SAFETY: this process has one thread.
                unsafe { std::env::set_var("PYTHONHOME", home) };
            }
            open(path, flags)
        }
        opened => opened,
    }
}

/// The shared library of `python3`, and the directory of its own modules.
fn python() -> Option<(String, String)> {
    let script = "import sysconfig as c, sys\n\
                  print(c.get_config_var('LIBDIR') + '/' + c.get_config_var('INSTSONAME'))\n\
                  print(sys.base_prefix)";
    let output = std::process::Command::new("python3").args(["-c", script]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (library, home) = text.trim().split_once('\n')?;
    Some((library.to_owned(), home.to_owned()))
}
