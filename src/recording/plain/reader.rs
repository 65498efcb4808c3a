//! A plain recording that is read.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::header::{described, values};
use super::{META, MOST_BYTES, REPLICA, file_of, place};
use crate::files::FileFault;
use crate::inputs;
use crate::recording::columns::{Column, Element, INDEX, Rows};
use crate::recording::fault::{READING, RecordingError};
use crate::recording::header::Header;
use crate::recording::rows::rows_of;

/// A file of a recording and its length.
fn regular(path: &Path) -> Result<(File, u64), FileFault> {
    let fault = || FileFault::io(path, READING);
    let file = inputs::open(path).map_err(fault())?;
    let data = file.metadata().map_err(fault())?;
    if !data.is_file() {
        return Err(fault()(ErrorKind::IsADirectory.into()));
    }
    Ok((file, data.len()))
}

/// A folder that is read.
pub(crate) struct Reader {
    folder: PathBuf,
    pub header: Header,
    pub pulses: usize,
    /// Columns that `meta.json` lists.
    listed: Vec<String>,
}

impl Reader {
    pub fn open(folder: &Path) -> Result<Self, RecordingError> {
        let read = |name: &str| {
            let path = folder.join(name);
            let (file, length) = regular(&path)?;
            if length > MOST_BYTES {
                let detail = format!("{name} has {length} bytes; allowed: at most {MOST_BYTES}");
                return Err(RecordingError::Foreign { path: folder.to_owned(), detail });
            }
            let mut bytes = Vec::new();
            let read = file.take(length).read_to_end(&mut bytes);
            read.map_err(FileFault::io(&path, READING))?;
            Ok(bytes)
        };
        let (header, listed) = described(folder, &read(META)?, &read(REPLICA)?)?;
        let index = folder.join(file_of(INDEX));
        let (_, length) = regular(&index)?;
        Ok(Self { folder: folder.to_owned(), header, pulses: (length / 8) as usize, listed })
    }

    pub fn has(&self, column: &Column) -> bool {
        self.listed.contains(&column.path)
    }

    /// Whole rows of a column, and bytes beyond them.
    pub fn length(&self, column: &Column) -> Result<(u64, u64), RecordingError> {
        let path = place(&self.folder, column);
        let held = fs::metadata(&path).map_err(FileFault::io(&path, READING))?.len();
        let row = column.row_bytes().max(1) as u64;
        Ok((held / row, held % row))
    }

    pub fn rows(&self, path: &Path, column: &Column, rows: Range<usize>) -> Result<Rows, RecordingError> {
        let bytes = self.bytes(column, &rows)?;
        let wanted = column.row_bytes().saturating_mul(rows.len());
        if bytes.len() < wanted {
            let detail = format!("{}.bin ends before pulse {}", column.path, rows.end);
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        Ok(rows_of!(column.element, values(&bytes)))
    }

    /// Whether a column is long enough for these rows.
    pub fn holds(&self, path: &Path, column: &Column, rows: &Range<usize>) -> Result<(), RecordingError> {
        let (_, length) = regular(&place(&self.folder, column))?;
        let needed = (column.row_bytes() as u64).checked_mul(rows.end as u64);
        if needed.is_none_or(|needed| needed > length) {
            let detail = format!("{}.bin ends before pulse {}", column.path, rows.end);
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        Ok(())
    }

    fn bytes(&self, column: &Column, rows: &Range<usize>) -> Result<Vec<u8>, FileFault> {
        let path = place(&self.folder, column);
        let fault = |action| FileFault::io(&path, action);
        let (mut file, _) = regular(&path)?;
        // What cannot be counted lies behind the end of every file.
        let bytes_of =
            |rows: usize| (column.row_bytes() as u64).saturating_mul(rows as u64).min(i64::MAX as u64);
        file.seek(SeekFrom::Start(bytes_of(rows.start))).map_err(fault(READING))?;
        let mut bytes = Vec::new();
        let wanted = bytes_of(rows.len());
        file.take(wanted).read_to_end(&mut bytes).map_err(fault(READING))?;
        Ok(bytes)
    }
}
