//! Use of the machine by a thread: the kernel's account of context switches and page faults.

#![allow(unsafe_code, reason = "no crate wraps getrusage for one thread")]

use std::mem::MaybeUninit;

/// Context switches and page faults of a thread, since its start or over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Times that it gave the processor up.
    pub voluntary_switches: u32,
    /// Times that the processor was taken from it.
    pub involuntary_switches: u32,
    /// Page faults served from memory.
    pub minor_faults: u32,
    /// Page faults that waited for a device.
    pub major_faults: u32,
}

impl Usage {
    /// The calling thread's, since its start; counts wrap.
    pub(crate) fn of_this_thread() -> Self {
        let mut usage = MaybeUninit::<libc::rusage>::zeroed();
        // SAFETY: the call writes a whole `rusage` or nothing; all zeros are a valid one.
        let usage = unsafe {
            libc::getrusage(libc::RUSAGE_THREAD, usage.as_mut_ptr());
            usage.assume_init()
        };
        let count = |count: libc::c_long| count as u32;
        Self {
            voluntary_switches: count(usage.ru_nvcsw),
            involuntary_switches: count(usage.ru_nivcsw),
            minor_faults: count(usage.ru_minflt),
            major_faults: count(usage.ru_majflt),
        }
    }

    pub fn since(&self, earlier: &Self) -> Self {
        let since = |now: u32, then: u32| now.wrapping_sub(then);
        Self {
            voluntary_switches: since(self.voluntary_switches, earlier.voluntary_switches),
            involuntary_switches: since(self.involuntary_switches, earlier.involuntary_switches),
            minor_faults: since(self.minor_faults, earlier.minor_faults),
            major_faults: since(self.major_faults, earlier.major_faults),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sleep_is_a_voluntary_switch_and_fresh_memory_faults() {
        let before = Usage::of_this_thread();
        std::thread::sleep(std::time::Duration::from_millis(1));
        let mut pages = vec![0_u8; 1 << 22];
        pages.iter_mut().step_by(4096).for_each(|byte| *byte = 1);
        std::hint::black_box(&pages);
        let used = Usage::of_this_thread().since(&before);
        assert!(used.voluntary_switches >= 1 && used.minor_faults >= 1, "{used:?}");
    }

    #[test]
    fn counts_that_wrapped_still_differ_rightly() {
        let before = Usage { minor_faults: u32::MAX, ..Usage::default() };
        let after = Usage { minor_faults: 2, ..Usage::default() };
        assert_eq!(after.since(&before).minor_faults, 3);
    }
}
