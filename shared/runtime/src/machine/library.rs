//! A control law in a shared library: four C functions, called in this process.
//!
//! ```c
//! const char *timegap_law_layout_version(void);
//! void *timegap_law_create(void);
//! void timegap_law_step(void *law, const TimegapLawInput *question, TimegapLawAnswer *answer);
//! void timegap_law_destroy(void *law);
//! ```
//!
//! Nothing here can protect this process from such code. The user of a library accepts that.

#![allow(unsafe_code, reason = "foreign functions are unsafe by their nature")]

use messages::{LAYOUT_VERSION, LawAnswer, LawInput};
use std::ffi::{CStr, CString, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::ptr::NonNull;

type Version = unsafe extern "C" fn() -> *const c_char;
type Create = unsafe extern "C" fn() -> *mut c_void;
type Step = unsafe extern "C" fn(*mut c_void, *const LawInput, *mut LawAnswer);
type Destroy = unsafe extern "C" fn(*mut c_void);

/// Reasons why a file is not a law.
#[derive(Debug, thiserror::Error)]
#[error("{}, expected {}", self.message(), self.expected())]
pub enum LibraryError {
    /// The linker does not load it.
    NotLoaded {
        /// The file.
        path: PathBuf,
        /// The linker's words.
        reason: String,
    },
    /// A function is missing.
    NoFunction {
        /// The file.
        path: PathBuf,
        /// The function.
        function: &'static str,
    },
    /// Its records are of another layout.
    OtherLayout {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: String,
    },
    /// It made no law.
    NoLaw {
        /// The file.
        path: PathBuf,
    },
}

impl LibraryError {
    /// The fault.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            Self::NotLoaded { path, reason } => format!("cannot load {}: {reason}", path.display()),
            Self::NoFunction { path, function } => {
                format!("{} has no function {function}", path.display())
            }
            Self::OtherLayout { path, found } => {
                format!("{} has records of layout version {found}", path.display())
            }
            Self::NoLaw { path } => {
                format!("timegap_law_create of {} returned a null pointer", path.display())
            }
        }
    }

    /// The right form.
    #[must_use]
    pub fn expected(&self) -> String {
        match self {
            Self::NotLoaded { .. } => "a shared library".to_owned(),
            Self::NoFunction { .. } => "those of `timegap print layouts --law --c`".to_owned(),
            Self::OtherLayout { .. } => {
                format!("{LAYOUT_VERSION} (`timegap print layouts --law --c`)")
            }
            Self::NoLaw { .. } => "a law".to_owned(),
        }
    }
}

/// A law that a shared library computes. The library stays loaded until the process ends.
#[derive(Debug)]
pub struct LawLibrary {
    law: NonNull<c_void>,
    step: Step,
    destroy: Destroy,
}

impl LawLibrary {
    /// Loads a library and makes a law of it.
    ///
    /// # Errors
    /// [`LibraryError`].
    pub fn open(path: &Path) -> Result<Self, LibraryError> {
        let owned = || path.to_owned();
        let not_loaded = |reason: String| LibraryError::NotLoaded { path: owned(), reason };
        let name = CString::new(path.as_os_str().as_bytes())
            .map_err(|_| not_loaded("a zero byte in its name".to_owned()))?;
        // SAFETY: the name is a C string. The library's own initialisers are the user's to answer for.
        let handle = unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
        let handle = NonNull::new(handle).ok_or_else(|| not_loaded(last_error()))?;
        let function = |name: &'static CStr| {
            // SAFETY: the handle is open, the name is a C string.
            let address = unsafe { libc::dlsym(handle.as_ptr(), name.as_ptr()) };
            let function = name.to_str().expect("ASCII");
            NonNull::new(address).ok_or(LibraryError::NoFunction { path: owned(), function })
        };
        let version = function(c"timegap_law_layout_version")?;
        let create = function(c"timegap_law_create")?;
        let step = function(c"timegap_law_step")?;
        let destroy = function(c"timegap_law_destroy")?;
        // SAFETY: functions of these names have these signatures by the header that describes them.
        let (version, create, step, destroy) = unsafe {
            (
                std::mem::transmute::<*mut c_void, Version>(version.as_ptr()),
                std::mem::transmute::<*mut c_void, Create>(create.as_ptr()),
                std::mem::transmute::<*mut c_void, Step>(step.as_ptr()),
                std::mem::transmute::<*mut c_void, Destroy>(destroy.as_ptr()),
            )
        };
        // SAFETY: it returns a C string that lives as long as the library, or null.
        let found = unsafe {
            NonNull::new(version().cast_mut())
                .map(|text| CStr::from_ptr(text.as_ptr()).to_string_lossy().into_owned())
        };
        let found = found.unwrap_or_default();
        if found != LAYOUT_VERSION {
            return Err(LibraryError::OtherLayout { path: owned(), found });
        }
        // SAFETY: it takes nothing and returns a law or null.
        let law = NonNull::new(unsafe { create() });
        let law = law.ok_or(LibraryError::NoLaw { path: owned() })?;
        Ok(Self { law, step, destroy })
    }

    /// One step of the law.
    pub fn step(&mut self, question: &LawInput, answer: &mut LawAnswer) {
        // SAFETY: the library made this law, both records live through the call, and each bit pattern is an
        // answer.
        unsafe { (self.step)(self.law.as_ptr(), question, answer) }
    }
}

impl Drop for LawLibrary {
    fn drop(&mut self) {
        // SAFETY: the law was made by this library and is not used any more.
        unsafe { (self.destroy)(self.law.as_ptr()) }
    }
}

/// The linker's words on its last failure.
fn last_error() -> String {
    // SAFETY: the text is copied before another call can change it; its state belongs to this thread.
    unsafe {
        NonNull::new(libc::dlerror()).map_or_else(String::new, |text| {
            CStr::from_ptr(text.as_ptr()).to_string_lossy().into_owned()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_argument_that_is_not_a_law_is_refused_with_what_was_expected() {
        let refused =
            |path: &str| LawLibrary::open(Path::new(path)).expect_err("no law").to_string();
        assert!(refused("/no/such.so").contains("expected a shared library"));
        let said = refused("libc.so.6");
        assert!(said.contains("has no function timegap_law_layout_version"), "{said}");
    }
}
