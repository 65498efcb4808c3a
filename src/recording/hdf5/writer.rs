//! An HDF5 recording, being written.
//!
//! Every per-pulse dataset is chunked along the pulse axis, at least [`CHUNK_PULSES`] pulses a chunk,
//! and unlimited there. `/pulse/index` is written last at every flush, after all others have been
//! handed to the system, so its length is the number of complete pulses whatever happened to the
//! writer.

use std::path::Path;

use ::hdf5::file::LibraryVersion;
use ::hdf5::{Dataset, Extent, File, Group, H5Type};
use ndarray::{ArrayViewD, IxDyn};

use super::changes::ChangeTable;
use super::fault::Fault;
use super::file::{shape, slab};
use super::header::{self, Segment};
use crate::files::{Draft, FileFault, Holding};
use crate::recording::columns::{Column, Element, Rows, columns};
use crate::recording::header::Header;
use crate::recording::rows::with_values;

/// Fewest pulses in a chunk of any dataset.
pub const CHUNK_PULSES: usize = 16;

/// A chunk is not made larger than this where the layout allows.
const CHUNK_BYTES: usize = 1 << 20;

/// A recording that is being written.
#[derive(Debug)]
pub(crate) struct Writer {
    // Dropped in this order: datasets before their file.
    datasets: Vec<Dataset>,
    changes: Option<ChangeTable>,
    file: File,
    draft: Draft,
    columns: Vec<Column>,
    /// Rows of all columns but the last.
    rows: usize,
    /// Indices of the rows after the last flush.
    pending: Vec<u64>,
}

/// A file that is open, its datasets, and its table of changes.
type Made = (File, Vec<Dataset>, Option<ChangeTable>);

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
        // Every chunk bears its checksum: a damaged sample is an error of reading.
        .fletcher32()
        .chunk(chunk)
        .chunk_cache(across * 4 + 1, bytes.max(1 << 16), 1.0)
        .shape(extents)
        .create(column.path.as_str())?)
}

impl Writer {
    /// Makes the file under the name of this process; readers may open it from now on.
    ///
    /// It may get its own name then, complete up to its pulses: a kill meanwhile leaves no file of that name
    /// that nothing can open.
    pub(crate) fn create(mut draft: Draft, header: &Header, segment: Segment) -> Result<Self, Fault> {
        let file = File::with_options()
            .with_fapl(|fapl| fapl.libver_bounds(LibraryVersion::V110, LibraryVersion::V110))
            .create_excl(draft.path());
        let file = match file {
            Ok(file) => file,
            Err(error) => {
                // What the library has left of it.
                if draft.made(Holding::File).is_ok() {
                    draft.abandon();
                }
                return Err(error.into());
            }
        };
        draft.made(Holding::File).map_err(|fault| Fault::Text(fault.to_string()))?;
        match Self::fill(file, header, segment) {
            Ok((file, datasets, changes)) => {
                draft.lock();
                let pending = Vec::with_capacity(4096);
                Ok(Self { datasets, changes, file, draft, columns: columns(header), rows: 0, pending })
            }
            Err(fault) => {
                draft.abandon();
                Err(fault)
            }
        }
    }

    fn fill(file: File, header: &Header, segment: Segment) -> Result<Made, Fault> {
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
            header::write(&file, iq, header, segment)?;
        }
        let changes = header.changes.as_ref().map(|log| ChangeTable::create(&file, log)).transpose()?;
        header::describe(&file, list.iter().zip(&datasets), header)?;
        file.flush()?;
        // Also gives up the library's lock on the file, which a forked child would keep.
        file.start_swmr()?;
        Ok((file, datasets, changes))
    }

    /// Where it is now.
    pub(crate) fn path(&self) -> &Path {
        self.draft.path()
    }

    /// Gives it its own name; with force, an older recording keeps that until this one is complete.
    pub(crate) fn place_early(&mut self, force: bool) -> Result<(), FileFault> {
        self.draft.place_early(force)
    }

    /// Closes what can be closed.
    pub(crate) fn give_up(self) -> Draft {
        let Self { datasets, changes, file, draft, .. } = self;
        drop((datasets, changes));
        drop(file);
        draft
    }

    /// Closes and removes it.
    pub(crate) fn abandon(self) {
        self.give_up().abandon();
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

    /// Flushes and closes; the file is then an ordinary one, which is still to be put in its place.
    pub(crate) fn close(mut self) -> Result<Draft, Box<(Fault, Draft)>> {
        let flushed = self.flush();
        let Self { datasets, changes, file, draft, .. } = self;
        drop((datasets, changes));
        match flushed.and_then(|()| Ok(file.close()?)) {
            Ok(()) => Ok(draft),
            Err(fault) => Err(Box::new((fault, draft))),
        }
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
    with_values!(rows, values => put(dataset, column, at, values))
}
