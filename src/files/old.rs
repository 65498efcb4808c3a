//! What stands in the place of an output: whether it may be replaced, and its removal.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{FileFault, Holding, Identity, Recognise, names, private_name};

/// What stands in a place and may be replaced.
#[derive(Debug)]
pub(super) struct Old {
    identity: Identity,
    holding: Holding,
    /// Held until it is removed; none where the system has no locks.
    _lock: Option<fs::File>,
}

impl Old {
    /// Whether it is what is here.
    pub fn is_at(&self, path: &Path) -> bool {
        Identity::of(path).ok() == Some(self.identity)
    }

    /// Whether it is a certain file or folder.
    pub fn is(&self, identity: Identity) -> bool {
        self.identity == identity
    }

    /// Removes it from here.
    pub fn remove(self, at: &Path) -> io::Result<()> {
        remove(at, &self.holding)
    }
}

/// The file of an output that is locked.
pub(super) fn lock_file(path: &Path, holding: &Holding) -> io::Result<fs::File> {
    match holding {
        Holding::File => fs::File::open(path),
        Holding::Folder(files) => fs::File::open(files.first().map_or(path.to_owned(), |f| path.join(f))),
    }
}

/// The folders within an output, each after the one that it is in.
pub(super) fn folders_of(holding: &Holding) -> BTreeSet<&Path> {
    let files = match holding {
        Holding::File => &[][..],
        Holding::Folder(files) => files,
    };
    let above = files.iter().flat_map(|file| file.ancestors().skip(1));
    above.filter(|folder| !folder.as_os_str().is_empty()).collect()
}

/// What stands here, if it may be replaced.
pub(super) fn replaceable(path: &Path, recognise: Recognise) -> Result<Old, FileFault> {
    let data = fs::symlink_metadata(path).map_err(FileFault::io(path, "looking at what is there"))?;
    let foreign = |kind| FileFault::Foreign { path: path.to_owned(), kind };
    // A pipe or a device is not even opened.
    if !(data.is_file() || data.is_dir()) {
        return Err(foreign("regular file or folder"));
    }
    let identity = Identity::of(path).map_err(FileFault::io(path, "looking at what is there"))?;
    let locked = |file: &fs::File| matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock));
    // Not held while the caller looks: its library may lock the file itself.
    if data.is_file() && fs::File::open(path).is_ok_and(|file| locked(&file)) {
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    let holding = recognise(path).map_err(foreign)?;
    let lock = lock_file(path, &holding).ok();
    if lock.as_ref().is_some_and(locked) {
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    if let Holding::Folder(_) = holding {
        // Half of a recording would be gone when the rest is refused.
        let inside = folders_of(&holding).into_iter().map(|folder| path.join(folder));
        for folder in [path.to_owned()].into_iter().chain(inside).filter(|folder| folder.is_dir()) {
            can_be_emptied(&folder)
                .map_err(FileFault::io(&folder, "not overwritten, because nothing in it can be removed"))?;
        }
    }
    Ok(Old { identity, holding, _lock: lock })
}

/// Whether files of a folder may be removed.
#[cfg(unix)]
fn can_be_emptied(folder: &Path) -> io::Result<()> {
    use nix::unistd::{AccessFlags, access};
    Ok(access(folder, AccessFlags::W_OK | AccessFlags::X_OK)?)
}

#[cfg(not(unix))]
fn can_be_emptied(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Removes an output: its own files, then the folders that are empty then.
pub(super) fn remove(path: &Path, holding: &Holding) -> io::Result<()> {
    let Holding::Folder(files) = holding else { return fs::remove_file(path) };
    let missing = |done: io::Result<()>| match done {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        done => done,
    };
    for file in files {
        missing(fs::remove_file(path.join(file)))?;
    }
    for folder in folders_of(holding).iter().rev() {
        missing(fs::remove_dir(path.join(folder)))?;
    }
    fs::remove_dir(path)
}

/// Removes an older output that the new one replaces without one of its own in the same place.
///
/// # Errors
/// What is not recognised, in use, or cannot be removed.
pub fn remove_recognised(path: &Path, recognise: Recognise) -> Result<(), FileFault> {
    if fs::symlink_metadata(path).is_err() {
        return Ok(());
    }
    let old = replaceable(path, recognise)?;
    let aside: PathBuf = private_name(path);
    names::rename_new(path, &aside).map_err(FileFault::io(path, "removing the old output"))?;
    if !old.is_at(&aside) {
        names::rename_new(&aside, path)
            .map_err(FileFault::io(&aside, "putting back what another program has just put there"))?;
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    old.remove(&aside).map_err(FileFault::io(&aside, "removing the old output"))
}
