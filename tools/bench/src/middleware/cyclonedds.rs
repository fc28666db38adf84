//! The same message over CycloneDDS: a reliable topic on the loopback device, read after a wait set.
//!
//! All unsafe code here calls `cyclonedds.c`, which is built if the library is found.
#![allow(unsafe_code, reason = "the library is written in C")]

use super::{MiddlewareError, Receiving, Sending, failed, patiently};
use bytemuck::Zeroable;
use messages::RadarTracks;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::NonNull;
use std::time::Duration;

/// Loopback only, without multicast, which a loopback device may lack.
const CONFIGURATION: &CStr = c"<CycloneDDS><Domain Id=\"any\">\
    <General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>\
    <AllowMulticast>false</AllowMulticast></General>\
    <Discovery><ParticipantIndex>auto</ParticipantIndex>\
    <Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>\
    </Domain></CycloneDDS>";

/// Domains whose ports are below the kernel's ephemeral ports.
const DOMAINS: u32 = 100;

/// State of an end in C.
#[repr(C)]
struct Opaque([u8; 0]);

unsafe extern "C" {
    fn timegap_dds_open(
        domain: u32,
        configuration: *const c_char,
        bytes: u32,
        writes: c_int,
        opened: *mut Option<NonNull<Opaque>>,
    ) -> c_int;
    fn timegap_dds_readers(dds: NonNull<Opaque>) -> c_int;
    fn timegap_dds_write(dds: NonNull<Opaque>, sample: *const c_void) -> c_int;
    fn timegap_dds_wait(dds: NonNull<Opaque>, timeout_ns: i64) -> c_int;
    fn timegap_dds_take(dds: NonNull<Opaque>, sample: *mut c_void) -> c_int;
    fn timegap_dds_close(dds: NonNull<Opaque>);
}

/// An end of the topic.
struct End(NonNull<Opaque>);

impl End {
    fn open(writes: bool) -> Result<Self, MiddlewareError> {
        // Both ends are processes of one benchmark: a domain that no other benchmark is likely to use.
        let parent = rustix::process::getppid().map_or(0, |pid| pid.as_raw_nonzero().get());
        let domain = parent.cast_unsigned() % DOMAINS;
        let bytes = u32::try_from(size_of::<RadarTracks>()).expect("a small message");
        let mut opened = None;
        // SAFETY: the configuration ends with 0, and `opened` is written before this returns.
        let code = unsafe {
            let configuration = CONFIGURATION.as_ptr();
            timegap_dds_open(domain, configuration, bytes, writes.into(), &raw mut opened)
        };
        match opened {
            Some(dds) => Ok(Self(dds)),
            None => Err(returned("open the topic", code)),
        }
    }
}

impl Drop for End {
    fn drop(&mut self) {
        // SAFETY: opened, and not used afterwards.
        unsafe { timegap_dds_close(self.0) }
    }
}

fn returned(what: &'static str, code: c_int) -> MiddlewareError {
    MiddlewareError::CycloneDds { what, code }
}

/// The writing end.
pub struct Writer(End);

impl Writer {
    /// Opens the end and waits for its reader.
    pub fn open() -> Result<Self, MiddlewareError> {
        let end = End::open(true)?;
        patiently(|| {
            // SAFETY: opened by `open`.
            match unsafe { timegap_dds_readers(end.0) } {
                0 => Err(std::io::Error::other("no reader")),
                code if code < 0 => Err(std::io::Error::other(format!("code {code}"))),
                _ => Ok(()),
            }
        })
        .map_err(failed("CycloneDDS"))?;
        Ok(Self(end))
    }
}

impl Sending for Writer {
    fn send(&mut self, message: &RadarTracks) -> Result<(), MiddlewareError> {
        // SAFETY: opened by `open`; the sample has the size that the topic was opened with.
        let code = unsafe { timegap_dds_write(self.0.0, std::ptr::from_ref(message).cast()) };
        if code < 0 { Err(returned("write", code)) } else { Ok(()) }
    }
}

/// The reading end.
pub struct Reader(End);

impl Reader {
    /// Opens the end.
    pub fn open() -> Result<Self, MiddlewareError> {
        End::open(false).map(Self)
    }
}

impl Receiving for Reader {
    fn receive(
        &mut self,
        timeout: Duration,
        each: &mut dyn FnMut(i64),
    ) -> Result<(), MiddlewareError> {
        let timeout_ns = i64::try_from(timeout.as_nanos()).unwrap_or(i64::MAX);
        // SAFETY: opened by `open`.
        let code = unsafe { timegap_dds_wait(self.0.0, timeout_ns) };
        if code < 0 {
            return Err(returned("wait", code));
        }
        let mut message = RadarTracks::zeroed();
        loop {
            // SAFETY: opened by `open`; any bytes are a message, and the buffer has room for one.
            let code = unsafe { timegap_dds_take(self.0.0, (&raw mut message).cast()) };
            match code {
                0 => return Ok(()),
                code if code < 0 => return Err(returned("read", code)),
                _ => each(message.header.acquisition_ns),
            }
        }
    }
}
