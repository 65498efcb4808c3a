//! Whether there is shared memory for a run, before it is used: a page that the system cannot give when it is
//! written to ends the process.

use crate::sinks::fault::SinkError;

/// Where Linux keeps shared memory.
#[cfg(target_os = "linux")]
const FOLDER: &str = "/dev/shm";

/// Fails where so many bytes are not free. They are taken once and given back, since a file system may
/// promise more than it has.
#[cfg(target_os = "linux")]
pub(super) fn check(service: &str, needed: u64) -> Result<(), SinkError> {
    use std::os::fd::AsFd;

    let short = |free: u64| SinkError::NoSharedMemory {
        service: service.to_owned(),
        needed_mib: needed.div_ceil(1 << 20),
        free_mib: free >> 20,
    };
    let Ok(status) = nix::sys::statvfs::statvfs(FOLDER) else { return Ok(()) };
    #[allow(clippy::useless_conversion)] // other widths elsewhere
    let free = u64::from(status.blocks_available()) * u64::from(status.fragment_size());
    if needed > free {
        return Err(short(free));
    }
    let path = std::path::Path::new(FOLDER).join(format!("nereus-{}-{service}", std::process::id()));
    // Somebody else's is not touched, and a folder that refuses files is reported when the memory is made.
    let Ok(file) = std::fs::File::create_new(&path) else { return Ok(()) };
    let _ = std::fs::remove_file(&path);
    let length = i64::try_from(needed).map_err(|_| short(free))?;
    match nix::fcntl::posix_fallocate(file.as_fd(), 0, length) {
        Err(nix::errno::Errno::ENOSPC | nix::errno::Errno::ENOMEM | nix::errno::Errno::EFBIG) => {
            Err(short(free))
        }
        _ => Ok(()),
    }
}

/// Elsewhere there is no folder to ask.
#[cfg(not(target_os = "linux"))]
pub(super) fn check(_: &str, _: u64) -> Result<(), SinkError> {
    Ok(())
}
