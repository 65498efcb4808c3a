//! One HDF5 recording, being written or read.
//!
//! Every per-pulse dataset is chunked along the pulse axis, at least [`CHUNK_PULSES`] pulses a chunk,
//! and unlimited there. `/pulse/index` is written last at every flush, after all others have been
//! handed to the system, so its length says how many pulses are complete whatever happened to the
//! writer.

use std::fs;
use std::path::{Path, PathBuf};

use ::hdf5::file::LibraryVersion;
use ::hdf5::{Dataset, Extent, File, Group, H5Type, Hyperslab, OpenMode, SliceOrIndex};
use ndarray::{ArrayViewD, IxDyn};
use thiserror::Error;

use crate::sinks::columns::{Column, Element, Rows, columns};
use crate::sinks::sink::{Header, SinkError};

use super::changes::ChangeTable;
use super::header;

/// Fewest pulses in a chunk of any dataset.
pub const CHUNK_PULSES: usize = 16;

/// A chunk is not made larger than this where the layout allows.
const CHUNK_BYTES: usize = 1 << 20;

/// What the library said; becomes an error that names the file.
#[derive(Debug, Error)]
pub(crate) enum Fault {
    /// A text that says it all.
    #[error("{0}")]
    Text(String),
    /// The library's error stack.
    #[error("{}", one_line(.0))]
    Library(#[from] ::hdf5::Error),
}

/// One line: what was tried and, where the system said why (`No space left on device`), that.
fn one_line(error: &::hdf5::Error) -> String {
    let text = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    let reason = text.split_once("error message = '").and_then(|(_, rest)| rest.split('\'').next());
    match (reason, text.split(": time = ").next()) {
        (Some(reason), Some(tried)) => format!("{tried}: {reason}"),
        _ => text,
    }
}

impl Fault {
    pub(crate) fn at(path: &Path, action: &'static str) -> impl FnOnce(Self) -> SinkError {
        let path = path.to_owned();
        move |fault| SinkError::Hdf5 { path, action, detail: fault.to_string() }
    }
}

/// A recording that is being written.
#[derive(Debug)]
pub(crate) struct Recording {
    // Dropped in this order: datasets before their file.
    datasets: Vec<Dataset>,
    changes: Option<ChangeTable>,
    file: File,
    path: PathBuf,
    columns: Vec<Column>,
    /// Rows of all columns but the last.
    rows: usize,
    /// Indices of the rows after the last flush.
    pending: Vec<u64>,
    /// Tells other runs that the file is being written.
    _mark: Option<fs::File>,
}

/// Pulses per chunk of the samples.
pub(crate) fn chunk_pulses(header: &Header) -> usize {
    columns(header).first().map_or(CHUNK_PULSES, |iq| chunk(iq)[0])
}

fn chunk(column: &Column) -> Vec<usize> {
    let row = column.row_bytes().max(1);
    // 64 pulses of samples at most, so that a block is written often; single values in long chunks.
    let most = if column.shape.len() > 1 { 64 } else { 1024 };
    let pulses = (CHUNK_BYTES / row / CHUNK_PULSES * CHUNK_PULSES).clamp(CHUNK_PULSES, most);
    let mut chunk = vec![pulses];
    chunk.extend(&column.shape);
    // A long window is cut along the samples, and by channel.
    if pulses * row > 4 * CHUNK_BYTES
        && let [_, channels, samples] = chunk.as_mut_slice()
    {
        *channels = 1;
        *samples = (*samples).min(4 * CHUNK_BYTES / (pulses * column.element.bytes()));
    }
    chunk
}

fn create_dataset<T: H5Type>(file: &File, column: &Column) -> Result<Dataset, Fault> {
    let mut extents = vec![Extent::resizable(0)];
    extents.extend(column.shape.iter().map(|&n| Extent::fixed(n)));
    let chunk = chunk(column);
    // The cache holds every chunk of one row of chunks, so a chunk is written once when it is full.
    let across: usize = column.shape.iter().zip(&chunk[1..]).map(|(n, c)| n.div_ceil(*c)).product();
    let bytes = chunk.iter().product::<usize>() * column.element.bytes() * across;
    Ok(file
        .new_dataset::<T>()
        .chunk(chunk)
        .chunk_cache(across * 4 + 1, bytes.max(1 << 16), 1.0)
        .shape(extents)
        .create(column.path.as_str())?)
}

impl Recording {
    /// Makes the file (which must not exist); readers may open it from now on. `after` is the last pulse of the
    /// segment before it.
    ///
    /// The file gets its name only when it is complete up to its pulses: a kill meanwhile leaves no file that nothing
    /// can open.
    pub(crate) fn create(path: &Path, header: &Header, after: Option<u64>) -> Result<Self, Fault> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let partial = path.with_file_name(format!(".{name}.making"));
        let _ = fs::remove_file(&partial);
        let made = Self::make(&partial, path, header, after);
        if made.is_err() {
            let _ = fs::remove_file(&partial);
        }
        made
    }

    fn make(partial: &Path, path: &Path, header: &Header, after: Option<u64>) -> Result<Self, Fault> {
        let file = File::with_options()
            .with_fapl(|fapl| fapl.libver_bounds(LibraryVersion::V110, LibraryVersion::V110))
            .create_excl(partial)?;
        let list = columns(header);
        let mut datasets = Vec::with_capacity(list.len());
        for column in &list {
            groups_above(&file, &column.path)?;
            datasets.push(match column.element {
                Element::U8 => create_dataset::<u8>(&file, column),
                Element::U32 => create_dataset::<u32>(&file, column),
                Element::U64 => create_dataset::<u64>(&file, column),
                Element::I64 => create_dataset::<i64>(&file, column),
                Element::F64 => create_dataset::<f64>(&file, column),
                Element::Cf32 => create_dataset::<num_complex::Complex32>(&file, column),
                Element::Ci16 => create_dataset::<num_complex::Complex<i16>>(&file, column),
            }?);
        }
        if let Some(iq) = datasets.first() {
            header::write(&file, iq, header, after)?;
        }
        let changes = header.changes.as_ref().map(|log| ChangeTable::create(&file, log)).transpose()?;
        file.flush()?;
        // Also gives up the library's lock on the file, which a forked child would keep.
        file.start_swmr()?;
        if fs::symlink_metadata(path).is_ok() {
            return Err(Fault::Text("there is a file of that name already".to_owned()));
        }
        fs::rename(partial, path).map_err(|error| Fault::Text(error.to_string()))?;
        // Shared, as readers lock it: it only keeps another run from overwriting the file. A system without locks
        // goes without.
        let mark = fs::File::open(path).ok().filter(|file| file.try_lock_shared().is_ok());
        let pending = Vec::with_capacity(4096);
        Ok(Self {
            datasets,
            changes,
            file,
            path: path.to_owned(),
            columns: list,
            rows: 0,
            pending,
            _mark: mark,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Pulses taken, flushed or not.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Appends rows, given in the order of the columns. Visible after the next flush.
    pub(crate) fn append(&mut self, block: &[Rows]) -> Result<(), Fault> {
        let Some((Rows::U64(index), rest)) = block.split_last() else {
            return Err(Fault::Text("a block without its index column".to_owned()));
        };
        if let (Some(changes), Some(last)) = (&mut self.changes, index.last()) {
            changes.append_up_to(*last)?;
        }
        for ((column, dataset), rows) in self.columns.iter().zip(&self.datasets).zip(rest) {
            append_rows(dataset, column, self.rows, rows)?;
        }
        self.pending.extend_from_slice(index);
        self.rows += index.len();
        Ok(())
    }

    /// Hands everything to the system, the index last.
    pub(crate) fn flush(&mut self) -> Result<(), Fault> {
        if self.pending.is_empty() {
            return Ok(());
        }
        self.file.flush()?;
        if let (Some(column), Some(dataset)) = (self.columns.last(), self.datasets.last()) {
            let at = self.rows - self.pending.len();
            // Lent to the writer and taken back with its room.
            let index = Rows::U64(std::mem::take(&mut self.pending));
            let written = append_rows(dataset, column, at, &index);
            if let Rows::U64(mut index) = index {
                index.clear();
                self.pending = index;
            }
            written?;
        }
        self.file.flush()?;
        Ok(())
    }

    /// Flushes and closes; the file is then an ordinary one.
    pub(crate) fn close(mut self) -> Result<PathBuf, Fault> {
        self.flush()?;
        let Self { datasets, changes, file, path, .. } = self;
        drop((datasets, changes));
        file.close()?;
        Ok(path)
    }
}

fn groups_above(file: &File, path: &str) -> Result<(), Fault> {
    let mut parts: Vec<&str> = path.split('/').collect();
    parts.pop();
    let mut here: Option<Group> = None;
    for part in parts {
        let parent: &Group = here.as_ref().unwrap_or(file);
        let next = if parent.link_exists(part) { parent.group(part)? } else { parent.create_group(part)? };
        here = Some(next);
    }
    Ok(())
}

fn slab(column: &Column, from: usize, to: usize) -> Hyperslab {
    let mut slab: Vec<SliceOrIndex> = vec![(from..to).into()];
    slab.extend(column.shape.iter().map(|&n| SliceOrIndex::from(0..n)));
    Hyperslab::from(slab)
}

fn shape(column: &Column, rows: usize) -> Vec<usize> {
    let mut shape = vec![rows];
    shape.extend(&column.shape);
    shape
}

fn append_rows(dataset: &Dataset, column: &Column, at: usize, rows: &Rows) -> Result<(), Fault> {
    fn put<T: H5Type>(dataset: &Dataset, column: &Column, at: usize, data: &[T]) -> Result<(), Fault> {
        let rows = data.len() / column.width().max(1);
        if rows == 0 {
            return Ok(());
        }
        dataset.resize(shape(column, at + rows))?;
        let view = ArrayViewD::from_shape(IxDyn(&shape(column, rows)), data)
            .map_err(|e| Fault::Text(e.to_string()))?;
        Ok(dataset.write_slice(view, slab(column, at, at + rows))?)
    }
    match rows {
        Rows::U8(v) => put(dataset, column, at, v),
        Rows::U32(v) => put(dataset, column, at, v),
        Rows::U64(v) => put(dataset, column, at, v),
        Rows::I64(v) => put(dataset, column, at, v),
        Rows::F64(v) => put(dataset, column, at, v),
        Rows::Cf32(v) => put(dataset, column, at, v),
        Rows::Ci16(v) => put(dataset, column, at, v),
    }
}

/// A recording that is read: finished, growing, or left by a killed run.
#[derive(Debug)]
pub(crate) struct Recorded {
    file: File,
    columns: Vec<Column>,
    /// Paths of those that are there.
    held: Vec<String>,
    /// What holds for the whole recording.
    pub(crate) header: Header,
    /// Complete pulses.
    pub(crate) pulses: usize,
}

/// Whether a file has a column, asked group by group: what has no parent has no children.
fn is_there(file: &File, column: &Column) -> bool {
    let ends = column.path.match_indices('/').map(|(at, _)| at).chain([column.path.len()]);
    ends.into_iter().all(|end| file.link_exists(&column.path[..end]))
}

impl Recorded {
    pub(crate) fn open(path: &Path) -> Result<Self, Fault> {
        // A run that was killed leaves the mark of an open writer; reading as SWMR accepts it.
        let file = match File::open(path) {
            Ok(file) => file,
            Err(plain) => File::open_as(path, OpenMode::ReadSWMR).map_err(|_| plain)?,
        };
        let header = header::read(&file)?;
        header.check().map_err(|e| Fault::Text(e.to_string()))?;
        let columns = columns(&header);
        let there = |column: &&Column| !column.may_be_missing() || is_there(&file, column);
        let held: Vec<&Column> = columns.iter().filter(there).collect();
        let mut pulses = 0;
        for column in &held {
            let dataset = file.dataset(&column.path)?;
            let found = dataset.shape();
            if found.get(1..) != Some(column.shape.as_slice()) {
                return Err(Fault::Text(format!("/{} has the shape {found:?}", column.path)));
            }
            pulses = found[0];
        }
        for column in &held {
            let rows = file.dataset(&column.path)?.shape()[0];
            if rows < pulses {
                return Err(Fault::Text(format!("/{} has {rows} rows of {pulses}", column.path)));
            }
        }
        let held = held.into_iter().map(|column| column.path.clone()).collect();
        Ok(Self { file, columns, held, header, pulses })
    }

    /// Index of one pulse.
    /// Last pulse of the segment before this file.
    pub(crate) fn after_pulse(&self) -> Option<u64> {
        self.file.attr("after_pulse").ok()?.read_scalar::<u64>().ok()
    }

    pub(crate) fn index(&self, row: usize) -> Result<u64, Fault> {
        let index = self.file.dataset(crate::sinks::columns::INDEX)?;
        let value = index.read_slice_1d::<u64, _>(row..row + 1)?;
        value.first().copied().ok_or_else(|| Fault::Text(format!("no row {row}")))
    }

    /// Flags of one pulse.
    pub(crate) fn flags(&self, row: usize) -> Result<u32, Fault> {
        let value = self.file.dataset("pulse/flags")?.read_slice_1d::<u32, _>(row..row + 1)?;
        value.first().copied().ok_or_else(|| Fault::Text(format!("no row {row}")))
    }

    /// Rows `from..to` of all columns, in their order.
    pub(crate) fn rows(&self, from: usize, to: usize) -> Result<Vec<Rows>, Fault> {
        self.columns.iter().map(|column| self.column(column, from, to)).collect()
    }

    /// Whether a column is there.
    pub(crate) fn has(&self, column: &Column) -> bool {
        self.held.contains(&column.path)
    }

    /// Rows `from..to` of one column.
    pub(crate) fn column(&self, column: &Column, from: usize, to: usize) -> Result<Rows, Fault> {
        fn get<T: H5Type + Clone>(
            file: &File,
            column: &Column,
            from: usize,
            to: usize,
        ) -> Result<Vec<T>, Fault> {
            let array = file.dataset(&column.path)?.read_slice::<T, _, IxDyn>(slab(column, from, to))?;
            Ok(array.into_raw_vec_and_offset().0)
        }
        let file = &self.file;
        Ok(match column.element {
            Element::U8 => Rows::U8(get(file, column, from, to)?),
            Element::U32 => Rows::U32(get(file, column, from, to)?),
            Element::U64 => Rows::U64(get(file, column, from, to)?),
            Element::I64 => Rows::I64(get(file, column, from, to)?),
            Element::F64 => Rows::F64(get(file, column, from, to)?),
            Element::Cf32 => Rows::Cf32(get(file, column, from, to)?),
            Element::Ci16 => Rows::Ci16(get(file, column, from, to)?),
        })
    }

    /// Bytes of a pulse over all columns.
    pub(crate) fn row_bytes(&self) -> usize {
        self.columns.iter().map(Column::row_bytes).sum()
    }
}
