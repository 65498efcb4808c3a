//! Where an output is: another program may move or remove it while it is written.

use std::fs;
use std::path::{Path, PathBuf};

use super::{FileFault, Identity};

/// Where an output is.
#[derive(Debug)]
pub(super) enum Place {
    /// Where it was made.
    Here,
    /// Here, and nothing has its name.
    Moved(PathBuf),
    /// Others may have moved it on.
    HandedOn,
}

/// Where an output is that was made at a path; the witness is a handle to it.
pub(super) fn place_of(
    path: &Path,
    identity: Identity,
    witness: Option<&fs::File>,
) -> Result<Place, FileFault> {
    let found = Identity::of(path).ok();
    if found == Some(identity) {
        return Ok(Place::Here);
    }
    if witness.is_some_and(is_removed) {
        return Err(FileFault::Removed { path: path.to_owned() });
    }
    match (witness.and_then(name_of).filter(|now| Identity::of(now).ok() == Some(identity)), found) {
        (Some(now), None) => Ok(Place::Moved(now)),
        (now, _) => Err(FileFault::Moved { path: path.to_owned(), now }),
    }
}

/// Whether a file that is open is the one that has this name.
pub fn is_at(file: &fs::File, path: &Path) -> bool {
    let identity = file.metadata().map(|data| Identity::of_data(&data));
    identity.ok().is_some_and(|identity| Identity::of(path).ok() == Some(identity))
}

/// Whether no name is left.
#[cfg(unix)]
fn is_removed(file: &fs::File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|data| data.nlink() == 0)
}

#[cfg(not(unix))]
fn is_removed(_: &fs::File) -> bool {
    false
}

/// The name of what is open, where the system reports it.
#[cfg(target_os = "linux")]
fn name_of(file: &fs::File) -> Option<PathBuf> {
    use std::os::fd::AsRawFd;
    fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd())).ok()
}

#[cfg(not(target_os = "linux"))]
fn name_of(_: &fs::File) -> Option<PathBuf> {
    None
}
