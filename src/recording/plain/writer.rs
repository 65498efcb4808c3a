//! A plain recording, being written.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::json;

use super::header::meta;
use super::{CHANGES, META, REPLICA, file_of, own_files, place, recognise};
use crate::files::{self, Draft, FileFault, Holding};
use crate::pulse::Pulse;
use crate::recording::columns::{Column, Rows, columns};
use crate::recording::fault::RecordingError;
use crate::recording::header::Header;
use crate::recording::unwritten::Unwritten;

/// Rows wait in memory until this many bytes are there.
const BUFFER_BYTES: usize = 1 << 20;

/// A folder of plain files.
#[derive(Debug)]
pub(crate) struct Writer {
    target: PathBuf,
    /// None when it has been handed on.
    draft: Option<Draft>,
    /// In the order of [`columns`]: the index last.
    files: Vec<ColumnFile>,
    changes: Option<Changes>,
    buffered_bytes: usize,
    row_bytes: usize,
}

/// The file of changes.
#[derive(Debug)]
struct Changes {
    unwritten: Unwritten,
    path: PathBuf,
    file: File,
}

#[derive(Debug)]
struct ColumnFile {
    column: Column,
    rows: Rows,
    file: File,
}

impl Writer {
    /// Makes the folder; nothing is left of it when that fails.
    pub(crate) fn create(path: &Path, force: bool, header: &Header) -> Result<Self, RecordingError> {
        header.check()?;
        files::preflight(path, force, &recognise)?;
        let list = columns(header);
        let mut draft = Draft::named(path);
        fs::create_dir(draft.path()).map_err(FileFault::io(path, "making the folder"))?;
        draft.made(Holding::Folder(own_files(list.iter().map(|column| column.path.as_str()))))?;
        let made = Self::fill(draft.path(), list, header).and_then(|made| {
            draft.lock();
            draft.place_early(force)?;
            Ok(made)
        });
        match made {
            Ok((files, changes)) => {
                let row_bytes = files.iter().map(|file| file.column.row_bytes()).sum();
                let target = path.to_owned();
                Ok(Self { target, draft: Some(draft), files, changes, buffered_bytes: 0, row_bytes })
            }
            Err(fault) => {
                draft.abandon();
                Err(fault.into())
            }
        }
    }

    fn fill(
        path: &Path,
        list: Vec<Column>,
        header: &Header,
    ) -> Result<(Vec<ColumnFile>, Option<Changes>), FileFault> {
        let write = |name: &str, bytes: &[u8]| {
            let file = path.join(name);
            fs::write(&file, bytes).map_err(FileFault::io(&file, "writing"))
        };
        write(REPLICA, bytemuck::cast_slice(&header.replica))?;
        write(META, format!("{:#}\n", meta(header, &list)).as_bytes())?;
        let make = |name: &str| {
            let file_path = path.join(name);
            if let Some(folder) = file_path.parent() {
                fs::create_dir_all(folder).map_err(FileFault::io(folder, "making the folder"))?;
            }
            let file = File::create_new(&file_path).map_err(FileFault::io(&file_path, "making the file"))?;
            Ok((file_path, file))
        };
        let row_bytes: usize = list.iter().map(Column::row_bytes).sum();
        let rows_kept = BUFFER_BYTES.div_ceil(row_bytes);
        let mut files = Vec::with_capacity(list.len());
        for column in list {
            let (_, file) = make(&file_of(&column.path))?;
            let rows = Rows::with_capacity(column.element, column.width() * rows_kept);
            files.push(ColumnFile { column, rows, file });
        }
        let changes = header.changes.as_ref().map(|log| {
            let (path, file) = make(CHANGES)?;
            Ok(Changes { unwritten: Unwritten::of(log), path, file })
        });
        Ok((files, changes.transpose()?))
    }

    /// Where it will be.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Bytes of a pulse over all columns.
    pub(crate) fn row_bytes(&self) -> usize {
        self.row_bytes
    }

    /// Whether as much waits in memory as may.
    pub(crate) fn is_full(&self) -> bool {
        self.buffered_bytes >= BUFFER_BYTES
    }

    /// Takes a pulse; it is in the files after the next flush.
    pub(crate) fn push(&mut self, pulse: &Pulse) -> Result<(), RecordingError> {
        for file in &self.files {
            file.column.check(pulse)?;
        }
        if let Some(Changes { unwritten, path, file }) = &mut self.changes {
            for entry in unwritten.up_to(pulse.index) {
                writeln!(file, "{}", json!(entry)).map_err(FileFault::io(path, "writing"))?;
            }
        }
        for file in &mut self.files {
            file.column.push(pulse, &mut file.rows);
        }
        self.buffered_bytes += self.row_bytes;
        Ok(())
    }

    /// Hands everything to the system, the index last.
    pub(crate) fn flush(&mut self) -> Result<(), FileFault> {
        for at in 0..self.files.len() {
            let ColumnFile { rows, file, .. } = &mut self.files[at];
            if let Err(source) = file.write_all(rows.as_bytes()) {
                // The folder may have got its name since the file was opened.
                let folder = self.draft.as_ref().map_or(self.target.as_path(), Draft::path);
                return Err(FileFault::io(&place(folder, &self.files[at].column), "writing")(source));
            }
            rows.clear();
        }
        self.buffered_bytes = 0;
        Ok(())
    }

    /// Flushes and hands all files to the disk; the folder is then still to be put in its place.
    pub(crate) fn close(&mut self) -> Result<Option<Draft>, FileFault> {
        self.flush()?;
        let folder = self.folder()?;
        let sync = |path: &Path, synced: io::Result<()>| synced.map_err(FileFault::io(path, "closing"));
        for ColumnFile { column, file, .. } in &self.files {
            sync(&place(&folder, column), file.sync_all())?;
        }
        self.is_all_there()?;
        for name in [META, REPLICA, CHANGES].map(|name| folder.join(name)).iter().filter(|name| name.exists())
        {
            sync(name, File::open(name).and_then(|file| file.sync_all()))?;
        }
        Ok(self.draft.take())
    }

    /// Where the recording is now: somebody may have moved it.
    fn folder(&self) -> Result<PathBuf, FileFault> {
        self.draft.as_ref().map_or_else(|| Ok(self.target.clone()), Draft::present)
    }

    /// Nobody has removed a file of it.
    fn is_all_there(&self) -> Result<(), FileFault> {
        let folder = self.folder()?;
        let mut places = self.files.iter().map(|file| (&file.file, place(&folder, &file.column)));
        match places.find(|(file, path)| !files::is_at(file, path)) {
            Some((_, path)) => Err(FileFault::Removed { path }),
            None => Ok(()),
        }
    }

    /// Pulses that a reader finds, after a failure.
    pub(crate) fn readable(&self) -> u64 {
        // A reader opens all of it or nothing.
        if self.is_all_there().is_err() {
            return 0;
        }
        // Rows beyond the last whole pulse are cut off; where that fails, the index still has the number of
        // those that are complete.
        let index = self.files.last().and_then(|index| index.file.metadata().ok());
        let pulses = index.map_or(0, |data| data.len() / size_of::<u64>() as u64);
        for file in self.files.iter().rev() {
            let _ = file.file.set_len(pulses * file.column.row_bytes() as u64);
        }
        pulses
    }

    /// Removes it.
    pub(crate) fn abandon(&mut self) {
        if let Some(draft) = self.draft.take() {
            draft.abandon();
        }
    }
}
