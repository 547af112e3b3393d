//! Memory that is free is given back to the system.
//!
//! The allocator of glibc keeps a page that is free as long as something above it in the same arena is not: after a burst
//! of large bodies a process stays as large as it was at its largest. A crate of its own, since nothing but a call of the
//! C library does it, and `unsafe` is forbidden in all others.

/// Gives back what is free, which takes some milliseconds where much is; others that allocate meanwhile wait. Returns
/// whether anything was given back; elsewhere than on Linux with glibc nothing is, nor has to be.
///
/// ```
/// let much: Vec<Vec<u8>> = (0..1000).map(|_| vec![1; 4096]).collect();
/// drop(much);
/// umwelt_memory::give_back();
/// ```
pub fn give_back() -> bool {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: it takes no pointer and touches nothing but what is free, under the allocator's own locks.
        #[expect(unsafe_code, reason = "a call of the C library")]
        let given_back = unsafe { libc::malloc_trim(0) };
        given_back == 1
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    false
}
