//! Outputs under way: one rule for every file and folder that the program makes.
//!
//! 1. An output is made under a name of this process beside its place: `.name.<process>.<number>.partial`,
//!    which must be free. It is locked (shared, as readers lock it) before it gets its own name.
//! 2. It gets its own name by [`Draft::place`], which never replaces what stands there.
//! 3. With force, what stands there is **exchanged** for the new output by [`Draft::finish`], in one step and
//!    only when the new one is complete; only what the caller recognises as an output of its kind, what can
//!    be removed as a whole, and only while nobody has locked it. What was taken out is looked at again
//!    before it is removed, and goes back if it is something else.
//! 4. Nothing else is removed: neither on success nor on failure does a process remove what it did not make.
//! 5. A complete output that cannot be put in its place stays under the name of this process, and the error
//!    names it ([`FileFault::Kept`]). One that another program has removed or moved meanwhile is an error,
//!    too, unless it is known where it is and nothing has taken its name.
//!
//! What is in place after [`Draft::finish`] has been handed to the disk, so it survives a power cut: first
//! the output (`fsync` of its files by their writer, here of the folders in it), then its folder, then the
//! old one is removed. What is still growing survives the end of its writer, a power cut only as far as the
//! system has written it.
//!
//! File systems without `renameat2` are served by links and by two renames; a crash between those two leaves
//! the old output under the name of the process.
//!
//! ```
//! use nereus::files::{Draft, FileFault, Holding};
//! let path = std::env::temp_dir().join(format!("nereus-files-{}.txt", std::process::id()));
//! let (draft, _file) = Draft::file(&path)?;
//! draft.finish(false, &|_| Err("text of mine"))?;
//! // The name is taken now; what is there is not replaced, and by force only where it is recognised.
//! let (mut second, _file) = Draft::file(&path)?;
//! assert!(matches!(second.place(), Err(FileFault::Exists { .. })));
//! let Err(FileFault::Kept { why, at, .. }) = second.finish(true, &|_| Err("text of mine")) else { panic!() };
//! assert!(matches!(*why, FileFault::Foreign { .. }) && at.exists());
//! let (third, _file) = Draft::file(&path)?;
//! third.finish(true, &|_| Ok(Holding::File))?;
//! # std::fs::remove_file(at).unwrap();
//! # std::fs::remove_file(path).unwrap();
//! # Ok::<(), FileFault>(())
//! ```

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

mod names;
mod old;
mod presence;

use old::{Old, lock_file, replaceable};
use presence::Place;

pub use old::remove_recognised;
pub use presence::is_at;

/// Why an output cannot be made or put in place.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// It is there already.
    #[error("{}: exists already; choose another name, or overwrite it with --force", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{}: not overwritten, because it is no {kind}", path.display())]
    Foreign {
        /// What is there.
        path: PathBuf,
        /// What may be overwritten.
        kind: &'static str,
    },
    /// Another run has put its output there since this one was begun.
    #[error(
        "{}: not overwritten, because another program has put this output there since the new one was begun",
        path.display()
    )]
    Overtaken {
        /// The output.
        path: PathBuf,
    },
    /// Another program has it open, or has just changed it.
    #[error("{}: not overwritten, because a run is writing it or another program reads it", path.display())]
    InUse {
        /// The output.
        path: PathBuf,
    },
    /// Another program has removed it.
    #[error("{}: removed by another program while it was written; what it held is lost", path.display())]
    Removed {
        /// Where it was.
        path: PathBuf,
    },
    /// Another program has moved it, and its name is taken, or nothing is known of its new place.
    #[error(
        "{}: no longer the output that was written here, which another program has moved{}",
        path.display(),
        now.as_ref().map_or_else(|| "; where to is not known".to_owned(), |now| format!(" to {}", now.display()))
    )]
    Moved {
        /// Where it was.
        path: PathBuf,
        /// Where it is, if that is known.
        now: Option<PathBuf>,
    },
    /// It is complete and cannot be put in its place.
    #[error(
        "{why}; the new output is complete and stays as {}: when {} is free, rename it (mv -n {0} {1})",
        at.display(),
        path.display()
    )]
    Kept {
        /// Why not.
        why: Box<FileFault>,
        /// Where it was to be.
        path: PathBuf,
        /// Where it is.
        at: PathBuf,
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
        /// What the system reported.
        source: io::Error,
    },
}

impl FileFault {
    /// What the system reported of a file.
    pub fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, action, source }
    }

    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Exists { .. } | Self::Foreign { .. } | Self::InUse { .. } | Self::NoFolder { .. } => true,
            Self::Removed { .. } | Self::Moved { .. } | Self::Overtaken { .. } | Self::Kept { .. } => false,
            Self::Io { source, .. } => matches!(
                source.kind(),
                io::ErrorKind::NotFound
                    | io::ErrorKind::NotADirectory
                    | io::ErrorKind::IsADirectory
                    | io::ErrorKind::PermissionDenied
            ),
        }
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

/// What stands in the place of an output holds; of what is no output of the kind, the name of the kind.
pub type Recognised = Result<Holding, &'static str>;

/// Looks at what stands in the place of an output.
pub type Recognise<'a> = &'a dyn Fn(&Path) -> Recognised;

/// Which file or folder, whatever its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Identity(u64, u64);

impl Identity {
    #[cfg(unix)]
    fn of_data(data: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self(data.dev(), data.ino())
    }

    #[cfg(not(unix))]
    fn of_data(data: &fs::Metadata) -> Self {
        let made = data.created().ok().and_then(|time| time.duration_since(std::time::UNIX_EPOCH).ok());
        Self(u64::from(data.is_dir()), made.map_or(0, |time| time.as_nanos() as u64))
    }

    fn of(path: &Path) -> io::Result<Self> {
        fs::symlink_metadata(path).map(|data| Self::of_data(&data))
    }
}

/// An output under way.
#[derive(Debug)]
pub struct Draft {
    target: PathBuf,
    /// What stood in its place when it was begun.
    stood: Option<Identity>,
    at: PathBuf,
    made: Option<(Identity, Holding)>,
    /// Knows it whatever its name.
    witness: Option<fs::File>,
    /// Keeps others from replacing it.
    mark: Option<fs::File>,
    is_handed_on: bool,
}

/// The folder of an output.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The folder in which an output is to be made must be there.
///
/// # Errors
/// It is missing, or no folder.
pub fn folder_exists(path: &Path) -> Result<(), FileFault> {
    let folder = folder(path);
    let data = fs::metadata(folder).map_err(FileFault::io(folder, "the folder of the output"))?;
    if data.is_dir() { Ok(()) } else { Err(FileFault::NoFolder { path: folder.to_owned() }) }
}

/// Whether an output may be made here; nothing is changed.
///
/// # Errors
/// What is there already and may not be replaced, and a folder that is missing.
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

/// The path of an output as it is always spelled: two that are one have the same. Links are followed.
pub fn spelling(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| {
        let folder = folder(path);
        let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        folder.join(path.file_name().unwrap_or_default())
    })
}

/// A link is followed, so that what it points to is replaced and not the link.
fn resolved(path: &Path) -> PathBuf {
    let is_link = fs::symlink_metadata(path).is_ok_and(|data| data.is_symlink());
    is_link.then(|| fs::canonicalize(path).ok()).flatten().unwrap_or_else(|| path.to_owned())
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
    /// An output that the caller makes at [`Self::path`], where nothing is yet, and reports by
    /// [`Self::made`].
    pub fn named(target: &Path) -> Self {
        let target = resolved(target);
        let (at, stood) = (private_name(&target), Identity::of(&target).ok());
        Self { at, target, stood, made: None, witness: None, mark: None, is_handed_on: false }
    }

    /// An empty file under the name of this process, and its handle.
    ///
    /// # Errors
    /// A folder that is missing, and what the system refuses.
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
    ///
    /// # Errors
    /// Nothing is there.
    pub fn made(&mut self, holding: Holding) -> Result<(), FileFault> {
        let identity = Identity::of(&self.at).map_err(FileFault::io(&self.at, "making the output"))?;
        self.made = Some((identity, holding));
        self.witness = fs::File::open(&self.at).ok();
        Ok(())
    }

    /// Locks it against being replaced. A system without locks goes without.
    pub fn lock(&mut self) {
        let Some((_, holding)) = &self.made else { return };
        self.mark = lock_file(&self.at, holding).ok().filter(|file| file.try_lock_shared().is_ok());
    }

    /// Gives it its own name, if nothing has that.
    ///
    /// # Errors
    /// Something has the name, and what the system refuses.
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

    /// The same at the start of an output that grows; with force it may also stay beside its place until it
    /// is complete.
    ///
    /// # Errors
    /// As [`Self::place`]; with force not that something has the name.
    pub fn place_early(&mut self, force: bool) -> Result<(), FileFault> {
        match self.place() {
            Err(FileFault::Exists { .. }) if force => Ok(()),
            done => done,
        }
    }

    /// Puts a complete output in its place and hands it to the disk, and returns where it is. With force it
    /// is exchanged for what stands there, which is then removed. When that fails, it stays where it is.
    ///
    /// `None` if it was handed on ([`Self::hand_on`]) and is no longer there.
    ///
    /// # Errors
    /// [`FileFault::Kept`] where it is complete and not in its place; it was removed or moved.
    pub fn finish(mut self, force: bool, recognise: Recognise) -> Result<Option<PathBuf>, FileFault> {
        self.finish_here(force, recognise).map_err(|why| self.kept(why))
    }

    /// Gives up the lock: it is closed, and others may have it.
    pub fn unlock(&mut self) {
        self.mark = None;
    }

    /// Lets others do with it what they like, such as move segments of a long run on.
    pub fn hand_on(&mut self) {
        self.unlock();
        self.witness = None;
        self.is_handed_on = true;
    }

    /// Whether a file that is open is this output.
    #[cfg(feature = "hdf5")]
    pub(crate) fn is(&self, file: &fs::File) -> bool {
        let found = file.metadata().ok().map(|data| Identity::of_data(&data));
        found.is_some() && found == self.made.as_ref().map(|(identity, _)| *identity)
    }

    /// Whether others may have it ([`Self::hand_on`]) and it is no longer where it was.
    pub fn is_gone(&self) -> bool {
        matches!(self.place_now(), Ok(Place::HandedOn))
    }

    /// Where it is now: another program may have moved it.
    ///
    /// # Errors
    /// It was removed, or it was moved and its name is taken or its new place not known.
    pub fn present(&self) -> Result<PathBuf, FileFault> {
        Ok(match self.place_now()? {
            Place::Here | Place::HandedOn => self.at.clone(),
            Place::Moved(now) => now,
        })
    }

    fn place_now(&self) -> Result<Place, FileFault> {
        let Some((identity, _)) = &self.made else { return Ok(Place::Here) };
        match presence::place_of(&self.at, *identity, self.witness.as_ref()) {
            Err(_) if self.is_handed_on => Ok(Place::HandedOn),
            place => place,
        }
    }

    /// Of a complete output that is not in its place: where it is.
    fn kept(&self, why: FileFault) -> FileFault {
        let is_ours = |made: &(Identity, Holding)| Identity::of(&self.at).is_ok_and(|found| found == made.0);
        if self.is_in_place() || !self.made.as_ref().is_some_and(is_ours) {
            return why;
        }
        FileFault::Kept { why: Box::new(why), path: self.target.clone(), at: self.at.clone() }
    }

    fn finish_here(&mut self, force: bool, recognise: Recognise) -> Result<Option<PathBuf>, FileFault> {
        match self.place_now()? {
            Place::Here => {}
            Place::HandedOn => return Ok(None),
            Place::Moved(now) if self.is_in_place() => {
                self.sync_as(&now)?;
                sync(folder(&now))?;
                return Ok(Some(now));
            }
            Place::Moved(now) => return Err(FileFault::Moved { path: self.at.clone(), now: Some(now) }),
        }
        self.sync_as(&self.at)?;
        let mut tries = 0;
        let replaced = loop {
            match self.place() {
                Err(FileFault::Exists { .. }) if force && tries < 3 => {
                    tries += 1;
                    if let Some(replaced) = self.exchange(recognise)? {
                        break Some(replaced);
                    }
                }
                done => {
                    done?;
                    break None;
                }
            }
        };
        // The old output goes when the new one would survive a power cut.
        let synced = sync(folder(&self.target));
        if let Some((old, at)) = replaced {
            if let Err(FileFault::Io { source, .. }) = synced {
                let action =
                    "the new output is in place, the old one stays here, because its folder was not written";
                return Err(FileFault::Io { path: at, action, source });
            }
            old.remove(&at).map_err(FileFault::io(
                &at,
                "the new output is in place, removing the old one, which is here",
            ))?;
        }
        synced.map(|()| Some(self.target.clone()))
    }

    /// Hands what is in it to the disk, where it is now. Its files are synced by who writes them, a single
    /// file here.
    fn sync_as(&self, at: &Path) -> Result<(), FileFault> {
        if let Some((_, holding)) = &self.made {
            for folder in old::folders_of(holding).iter().rev().map(|inside| at.join(inside)) {
                if folder.is_dir() {
                    sync(&folder)?;
                }
            }
        }
        sync(at)
    }

    /// Exchanges it for what stands in its place; returns that and where it is now. `None` if nothing stands
    /// there any more.
    fn exchange(&mut self, recognise: Recognise) -> Result<Option<(Old, PathBuf)>, FileFault> {
        let old = match replaceable(&self.target, recognise) {
            Err(FileFault::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(None);
            }
            old => old?,
        };
        // Two runs at once: what the other has finished meanwhile is not what was to be replaced.
        if self.stood.is_none_or(|stood| !old.is(stood)) {
            return Err(FileFault::Overtaken { path: self.target.clone() });
        }
        match names::exchange(&self.at, &self.target, || private_name(&self.target)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            done => done.map_err(FileFault::io(&self.target, "exchanging the old output for the new"))?,
        }
        // Somebody may have put something else there since it was looked at.
        if !old.is_at(&self.at) {
            names::exchange(&self.at, &self.target, || private_name(&self.target))
                .map_err(FileFault::io(&self.at, "putting back what another program has just put there"))?;
            return Err(FileFault::InUse { path: self.target.clone() });
        }
        let taken = std::mem::replace(&mut self.at, self.target.clone());
        Ok(Some((old, taken)))
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
            let _ = old::remove(&aside, &holding);
        } else {
            let _ = names::rename_new(&aside, &self.at);
        }
    }
}

/// A file that grows beyond the limit of the process (`ulimit -f`) is an error with a message, not the end of
/// the program: the signal for it is held back in every thread, and the write fails with its reason.
#[cfg(unix)]
pub(crate) fn report_large_files() {
    let mut signals = nix::sys::signal::SigSet::empty();
    signals.add(nix::sys::signal::Signal::SIGXFSZ);
    let _ = signals.thread_block();
}

#[cfg(not(unix))]
pub(crate) fn report_large_files() {}

/// A path as a report holds it: JSON is Unicode, and a report must not be lost because a path is not.
pub(crate) fn lossy_path<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// The same of several.
pub(crate) fn lossy_paths<S: serde::Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.to_string_lossy()))
}

#[cfg(test)]
mod tests;
