//! Outputs under way: one rule for every file and folder that the program makes.
//!
//! 1. An output is made under a name of this process beside its place: `.name.<process>.<number>.partial`, which
//!    must be free. It is locked (shared, as readers lock it) before it gets its own name.
//! 2. It gets its own name by [`Draft::place`], which never replaces what stands there.
//! 3. With force, what stands there is **exchanged** for the new output by [`Draft::finish`], in one step and only when
//!    the new one is complete; only what the caller recognises as an output of its kind, and only while nobody has
//!    locked it. What was taken out is looked at again before it is removed, and goes back if it is something else.
//! 4. Nothing else is removed: neither on success nor on failure does a process remove what it did not make.
//!
//! What is in place after [`Draft::finish`] has been handed to the disk (`fsync` of the file and of its folder), so it
//! survives a power cut. What is still growing survives the end of its writer, a power cut only as far as the system has
//! written it.
//!
//! File systems without `renameat2` are served by links and by two renames; a crash between those two leaves the old
//! output under the name of the process.
//!
//! ```
//! use nereus::files::{Draft, FileFault, Holding};
//! let path = std::env::temp_dir().join(format!("nereus-files-{}.txt", std::process::id()));
//! let (draft, _file) = Draft::file(&path)?;
//! draft.finish(false, &|_| None)?;
//! // The name is taken now; what is there is not replaced, and by force only where it is recognised.
//! let (mut second, _file) = Draft::file(&path)?;
//! assert!(matches!(second.place(), Err(FileFault::Exists { .. })));
//! assert!(matches!(second.finish(true, &|_| None), Err(FileFault::Foreign { .. })));
//! let (third, _file) = Draft::file(&path)?;
//! third.finish(true, &|_| Some(Holding::File))?;
//! # std::fs::remove_file(path).unwrap();
//! # Ok::<(), FileFault>(())
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

mod names;

/// Why an output cannot be made or put in place.
#[derive(Debug, thiserror::Error)]
pub enum FileFault {
    /// It is there already.
    #[error("{}: exists already; choose another name, or overwrite it with --force", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{}: not overwritten, because it is no output of this kind", path.display())]
    Foreign {
        /// What is there.
        path: PathBuf,
    },
    /// Another program has it open, or has just changed it.
    #[error("{}: not overwritten, because another program uses it", path.display())]
    InUse {
        /// The output.
        path: PathBuf,
    },
    /// The output is to be made in something that is no folder.
    #[error("{}: is no folder; outputs are made in folders that exist", path.display())]
    NoFolder {
        /// What is there.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

impl FileFault {
    /// What the system said of a file.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, action, source }
    }
}

/// What an output consists of; nothing more is removed with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Holding {
    /// A file.
    File,
    /// A folder with these files, relative to it.
    Folder(Vec<PathBuf>),
}

/// Looks at what stands in the place of an output: what it holds if it is one of the same kind.
pub type Recognise<'a> = &'a dyn Fn(&Path) -> Option<Holding>;

/// Which file or folder, whatever its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Identity(u64, u64);

impl Identity {
    #[cfg(unix)]
    fn of(path: &Path) -> io::Result<Self> {
        use std::os::unix::fs::MetadataExt;
        fs::symlink_metadata(path).map(|data| Self(data.dev(), data.ino()))
    }

    #[cfg(not(unix))]
    fn of(path: &Path) -> io::Result<Self> {
        fs::symlink_metadata(path).map(|data| Self(data.len(), 0))
    }
}

/// An output under way.
#[derive(Debug)]
pub struct Draft {
    target: PathBuf,
    at: PathBuf,
    made: Option<(Identity, Holding)>,
    /// Keeps others from replacing it.
    mark: Option<fs::File>,
}

/// What stands in a place and may be replaced.
struct Old {
    identity: Identity,
    holding: Holding,
    /// Held until it is removed; none where the system has no locks.
    _lock: Option<fs::File>,
}

/// The folder of an output.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The folder in which an output is to be made must be there.
pub fn folder_exists(path: &Path) -> Result<(), FileFault> {
    let folder = folder(path);
    let data = fs::metadata(folder).map_err(FileFault::io(folder, "the folder of the output"))?;
    if data.is_dir() { Ok(()) } else { Err(FileFault::NoFolder { path: folder.to_owned() }) }
}

/// Whether an output may be made here; nothing is changed.
pub fn preflight(path: &Path, force: bool, recognise: Recognise) -> Result<(), FileFault> {
    let path = &resolved(path);
    if fs::symlink_metadata(path).is_err() {
        return folder_exists(path);
    }
    if !force {
        return Err(FileFault::Exists { path: path.clone() });
    }
    replaceable(path, recognise).map(|_| ())
}

/// A link is followed, so that what it points to is replaced and not the link.
fn resolved(path: &Path) -> PathBuf {
    let is_link = fs::symlink_metadata(path).is_ok_and(|data| data.is_symlink());
    is_link.then(|| fs::canonicalize(path).ok()).flatten().unwrap_or_else(|| path.to_owned())
}

/// The file of an output that is locked.
fn lock_file(path: &Path, holding: &Holding) -> io::Result<fs::File> {
    match holding {
        Holding::File => fs::File::open(path),
        Holding::Folder(files) => fs::File::open(files.first().map_or(path.to_owned(), |f| path.join(f))),
    }
}

/// What stands here, if it may be replaced.
fn replaceable(path: &Path, recognise: Recognise) -> Result<Old, FileFault> {
    let data = fs::symlink_metadata(path).map_err(FileFault::io(path, "looking at what is there"))?;
    let foreign = || FileFault::Foreign { path: path.to_owned() };
    // A pipe or a device is not even opened.
    if !(data.is_file() || data.is_dir()) {
        return Err(foreign());
    }
    let identity = Identity::of(path).map_err(FileFault::io(path, "looking at what is there"))?;
    let locked = |file: &fs::File| matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock));
    // Not held while the caller looks: its library may lock the file itself.
    if data.is_file() && fs::File::open(path).is_ok_and(|file| locked(&file)) {
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    let holding = recognise(path).ok_or_else(foreign)?;
    let lock = lock_file(path, &holding).ok();
    if lock.as_ref().is_some_and(locked) {
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    Ok(Old { identity, holding, _lock: lock })
}

/// Removes an output: its own files, then the folders that are empty then.
fn remove(path: &Path, holding: &Holding) -> io::Result<()> {
    let Holding::Folder(files) = holding else { return fs::remove_file(path) };
    let missing = |done: io::Result<()>| match done {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        done => done,
    };
    let mut folders = BTreeSet::new();
    for file in files {
        missing(fs::remove_file(path.join(file)))?;
        folders.extend(file.ancestors().skip(1).filter(|f| !f.as_os_str().is_empty()).map(Path::to_owned));
    }
    for folder in folders.iter().rev() {
        missing(fs::remove_dir(path.join(folder)))?;
    }
    fs::remove_dir(path)
}

/// A name beside the place of an output that is free and bears the number of this process.
fn private_name(target: &Path) -> PathBuf {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    // A name of 255 bytes is the longest that file systems take.
    let end = (0..=name.len().min(200)).rev().find(|at| name.is_char_boundary(*at)).unwrap_or(0);
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let partial = format!(".{}.{}.{number}.partial", &name[..end], std::process::id());
        let path = target.with_file_name(partial);
        if fs::symlink_metadata(&path).is_err() {
            return path;
        }
    }
}

/// Hands a file or a folder to the disk. Systems that cannot do so for a folder are excused.
fn sync(path: &Path) -> Result<(), FileFault> {
    let file = fs::File::open(path).map_err(FileFault::io(path, "handing it to the disk"))?;
    match file.sync_all() {
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            Ok(())
        }
        done => done.map_err(FileFault::io(path, "handing it to the disk")),
    }
}

impl Draft {
    /// An output that the caller makes at [`Self::path`], where nothing is yet, and tells by [`Self::made`].
    pub fn named(target: &Path) -> Self {
        let target = resolved(target);
        Self { at: private_name(&target), target, made: None, mark: None }
    }

    /// An empty file under the name of this process, and its handle.
    pub fn file(target: &Path) -> Result<(Self, fs::File), FileFault> {
        folder_exists(target)?;
        let mut draft = Self::named(target);
        let file = fs::File::create_new(&draft.at).map_err(FileFault::io(target, "making the file"))?;
        draft.made(Holding::File)?;
        Ok((draft, file))
    }

    /// Where it is now: beside its place or in it.
    pub fn path(&self) -> &Path {
        &self.at
    }

    /// Where it will be.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Whether it has its own name.
    pub fn is_in_place(&self) -> bool {
        self.at == self.target
    }

    /// Notes that what is at [`Self::path`] was made by this process.
    pub fn made(&mut self, holding: Holding) -> Result<(), FileFault> {
        let identity = Identity::of(&self.at).map_err(FileFault::io(&self.at, "making the output"))?;
        self.made = Some((identity, holding));
        Ok(())
    }

    /// Locks it against being replaced. A system without locks goes without.
    pub fn lock(&mut self) {
        let Some((_, holding)) = &self.made else { return };
        self.mark = lock_file(&self.at, holding).ok().filter(|file| file.try_lock_shared().is_ok());
    }

    /// Gives it its own name, if nothing has that.
    pub fn place(&mut self) -> Result<(), FileFault> {
        if self.is_in_place() {
            return Ok(());
        }
        match names::rename_new(&self.at, &self.target) {
            Ok(()) => {
                self.at.clone_from(&self.target);
                Ok(())
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                Err(FileFault::Exists { path: self.target.clone() })
            }
            Err(error) => Err(FileFault::io(&self.target, "putting the output in place")(error)),
        }
    }

    /// The same at the start of an output that grows; with force it may also stay beside its place until it is complete.
    pub fn place_early(&mut self, force: bool) -> Result<(), FileFault> {
        match self.place() {
            Err(FileFault::Exists { .. }) if force => Ok(()),
            done => done,
        }
    }

    /// Puts a complete output in its place and hands it to the disk. With force it is exchanged for what stands there.
    pub fn finish(mut self, force: bool, recognise: Recognise) -> Result<PathBuf, FileFault> {
        match self.finish_here(force, recognise) {
            Ok(()) => Ok(self.target),
            Err(fault) => {
                self.discard();
                Err(fault)
            }
        }
    }

    /// The same, but when that fails the output stays where it is.
    pub fn finish_or_keep(mut self, force: bool, recognise: Recognise) -> Result<PathBuf, FileFault> {
        self.finish_here(force, recognise).map(|()| self.target)
    }

    /// Gives up the lock: it is closed, and others may have it.
    pub fn unlock(&mut self) {
        self.mark = None;
    }

    fn finish_here(&mut self, force: bool, recognise: Recognise) -> Result<(), FileFault> {
        let is_ours = |made: &(Identity, Holding)| Identity::of(&self.at).is_ok_and(|found| found == made.0);
        if self.is_in_place() && !self.made.as_ref().is_some_and(is_ours) {
            // Somebody has moved it on, as one does with segments of a long run.
            return Ok(());
        }
        sync(&self.at)?;
        let mut tries = 0;
        loop {
            match self.place() {
                Err(FileFault::Exists { .. }) if force && tries < 3 => {
                    tries += 1;
                    if self.exchange(recognise)? {
                        break;
                    }
                }
                done => {
                    done?;
                    break;
                }
            }
        }
        sync(folder(&self.target))
    }

    /// Exchanges it for what stands in its place, which is removed; false if nothing stands there any more.
    fn exchange(&mut self, recognise: Recognise) -> Result<bool, FileFault> {
        let old = match replaceable(&self.target, recognise) {
            Err(FileFault::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(false);
            }
            old => old?,
        };
        match names::exchange(&self.at, &self.target, || private_name(&self.target)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
            done => done.map_err(FileFault::io(&self.target, "exchanging the old output for the new"))?,
        }
        // Somebody may have put something else there since it was looked at.
        if Identity::of(&self.at).ok() != Some(old.identity) {
            names::exchange(&self.at, &self.target, || private_name(&self.target))
                .map_err(FileFault::io(&self.at, "putting back what another program has just put there"))?;
            return Err(FileFault::InUse { path: self.target.clone() });
        }
        let taken = std::mem::replace(&mut self.at, self.target.clone());
        remove(&taken, &old.holding).map_err(FileFault::io(&taken, "removing the old output"))?;
        Ok(true)
    }

    /// Removes it, wherever it is, if it is still what this process made.
    pub fn abandon(mut self) {
        self.discard();
    }

    fn discard(&mut self) {
        let Some((identity, holding)) = self.made.take() else { return };
        // Moved aside first: what is looked at is then what is removed.
        let aside = private_name(&self.target);
        if names::rename_new(&self.at, &aside).is_err() {
            return;
        }
        if Identity::of(&aside).ok() == Some(identity) {
            let _ = remove(&aside, &holding);
        } else {
            let _ = names::rename_new(&aside, &self.at);
        }
    }
}

/// Removes an older output that the new one replaces without one of its own in the same place.
pub fn remove_recognised(path: &Path, recognise: Recognise) -> Result<(), FileFault> {
    if fs::symlink_metadata(path).is_err() {
        return Ok(());
    }
    let old = replaceable(path, recognise)?;
    let aside = private_name(path);
    names::rename_new(path, &aside).map_err(FileFault::io(path, "removing the old output"))?;
    if Identity::of(&aside).ok() != Some(old.identity) {
        names::rename_new(&aside, path)
            .map_err(FileFault::io(&aside, "putting back what another program has just put there"))?;
        return Err(FileFault::InUse { path: path.to_owned() });
    }
    remove(&aside, &old.holding).map_err(FileFault::io(&aside, "removing the old output"))
}

#[cfg(test)]
mod tests;
