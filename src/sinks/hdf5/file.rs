//! One HDF5 recording, being written or read.
//!
//! Every per-pulse dataset is chunked along the pulse axis, at least [`CHUNK_PULSES`] pulses a chunk,
//! and unlimited there. `/pulse/index` is written last at every flush, after all others have been
//! handed to the system, so its length says how many pulses are complete whatever happened to the
//! writer.

use super::fault::Fault;
use std::fs;
use std::io::Read;
use std::path::Path;

use ::hdf5::file::LibraryVersion;
use ::hdf5::filters::Filter;
use ::hdf5::types::VarLenUnicode;
use ::hdf5::{Dataset, Extent, File, Group, H5Type, Hyperslab, LinkType, OpenMode, SliceOrIndex};
use ndarray::{ArrayViewD, IxDyn};

use crate::files::{Draft, FileFault, Holding};
use crate::sinks::columns::{Column, Element, INDEX, Rows, columns};
use crate::sinks::sink::Header;

use super::changes::ChangeTable;
use super::{header, sizes, superblock};

/// Fewest pulses in a chunk of any dataset.
pub const CHUNK_PULSES: usize = 16;

/// A chunk is not made larger than this where the layout allows.
const CHUNK_BYTES: usize = 1 << 20;

/// A recording that is being written.
#[derive(Debug)]
pub(crate) struct Recording {
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

/// A file that is finished, growing, or left by a killed run.
fn open(path: &Path) -> Result<File, Fault> {
    regular(path)?;
    match File::open(path) {
        Ok(file) => Ok(file),
        // A run that goes on or was killed leaves the open-for-write flag; reading as SWMR accepts it.
        // Nothing else is tried twice.
        Err(plain) if is_marked(&plain) => File::with_options()
            .with_fapl(|fapl| fapl.metadata_read_attempts(READ_ATTEMPTS))
            .open_as(path, OpenMode::ReadSWMR)
            .map_err(|_| plain.into()),
        Err(plain) => Err(plain.into()),
    }
}

/// The attribute `format` of an HDF5 file.
pub(crate) fn format_of(path: &Path) -> Option<Vec<u8>> {
    format_in(&opened(path)?)
}

fn format_in(file: &File) -> Option<Vec<u8>> {
    let format = file.attr("format").ok()?.read_scalar::<VarLenUnicode>().ok()?;
    Some(format.as_bytes().to_owned())
}

/// A file that begins as HDF5 does.
fn opened(path: &Path) -> Option<File> {
    const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
    let mut start = [0; 8];
    regular(path).ok()?;
    fs::File::open(path).and_then(|mut file| file.read_exact(&mut start)).ok()?;
    if start != SIGNATURE {
        return None;
    }
    open(path).ok()
}

/// A file of this program.
fn own(path: &Path) -> Option<File> {
    opened(path).filter(|file| format_in(file).is_some_and(|format| format == b"nereus"))
}

/// Last pulse of the segment before a file.
fn after_pulse(file: &File) -> Option<u64> {
    file.attr("after_pulse").ok()?.read_scalar::<u64>().ok()
}

/// Whether a file was written as a segment after another.
pub(super) fn is_later_segment(path: &Path) -> bool {
    own(path).is_some_and(|file| after_pulse(&file).is_some())
}

/// Whether a recording was received over the wire.
pub(super) fn is_received(path: &Path) -> bool {
    let truth = |file: File| file.attr("truth").ok()?.read_scalar::<u8>().ok();
    own(path).and_then(truth) == Some(0)
}

/// Whether a file is a recording of this program, or empty.
pub(super) fn is_recording(path: &Path) -> bool {
    let data = fs::symlink_metadata(path);
    data.is_ok_and(|data| data.is_file() && data.len() == 0)
        || format_of(path).is_some_and(|f| f == b"nereus")
}

/// Pulses of a recording that a reader finds, after a failure: where it is now, if that is known.
pub(super) fn readable(draft: &Draft) -> u64 {
    let Ok(path) = draft.present() else { return 0 };
    // Where that fails too, what cannot be opened is counted as lost.
    let _ = superblock::enter_end(&path, |file| draft.is(file));
    Recorded::open(&path).map_or(0, |recorded| recorded.pulses as u64)
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
        // Every chunk bears its checksum: a damaged sample is an error of reading.
        .fletcher32()
        .chunk(chunk)
        .chunk_cache(across * 4 + 1, bytes.max(1 << 16), 1.0)
        .shape(extents)
        .create(column.path.as_str())?)
}

impl Recording {
    /// Makes the file under the name of this process; readers may open it from now on. `after` is the last
    /// pulse of the segment before it.
    ///
    /// It may get its own name then, complete up to its pulses: a kill meanwhile leaves no file of that name
    /// that nothing can open.
    pub(crate) fn create(mut draft: Draft, header: &Header, after: Option<u64>) -> Result<Self, Fault> {
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
        match Self::fill(file, header, after) {
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

    fn fill(file: File, header: &Header, after: Option<u64>) -> Result<Made, Fault> {
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
    pub(super) fn place_early(&mut self, force: bool) -> Result<(), FileFault> {
        self.draft.place_early(force)
    }

    /// Closes what can be closed.
    pub(super) fn give_up(self) -> Draft {
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

/// Times that metadata of a growing file is read again before it counts as damaged. The library waits 2^n ns
/// after the n-th attempt: its own 100 would be for ever.
const READ_ATTEMPTS: u32 = 20;

/// Length of a file that is one: reading a pipe or a device may never end.
fn regular(path: &Path) -> Result<u64, Fault> {
    let data = fs::metadata(path).map_err(|error| Fault::Text(error.to_string()))?;
    if !data.is_file() {
        return Err(Fault::Text("is no regular file; recordings are files or folders".to_owned()));
    }
    Ok(data.len())
}

/// Whether a file was refused for its writer's mark alone.
fn is_marked(error: &::hdf5::Error) -> bool {
    let said = |text: &str| text.contains("already open for write");
    let frames = error.stack();
    said(&error.to_string())
        || frames
            .is_some_and(|stack| stack.iter().any(|frame| said(frame.desc()) || said(frame.description())))
}

/// Groups within groups that are looked at: recordings have four.
const DEEPEST: usize = 8;

/// Refuses links to elsewhere: they would have other files opened, or go in circles.
fn only_hard_links(group: &Group, path: &str) -> Result<(), Fault> {
    if path.matches('/').count() > DEEPEST {
        return Err(Fault::Text(format!("{} lies in more than {DEEPEST} groups", path.escape_debug())));
    }
    let mut names = Vec::new();
    let mut other = None;
    group.iter_visit_default(|name, link| {
        if link.link_type != LinkType::Hard {
            other.get_or_insert_with(|| name.to_owned());
        }
        names.push(name.to_owned());
        Ok(())
    })?;
    if let Some(name) = other {
        let name = format!("{path}/{name}");
        return Err(Fault::Text(format!(
            "{} is a link to elsewhere; recordings have none",
            name.escape_debug()
        )));
    }
    for name in names {
        if let Ok(inner) = group.group(&name) {
            only_hard_links(&inner, &format!("{path}/{name}"))?;
        }
    }
    Ok(())
}

impl Recorded {
    pub(crate) fn open(path: &Path) -> Result<Self, Fault> {
        let file = open(path)?;
        only_hard_links(&file, "")?;
        let file_bytes = regular(path)?;
        let header = header::read(&file, file_bytes)?;
        header.check().map_err(|e| Fault::Text(e.to_string()))?;
        let columns = columns(&header);
        let there = |column: &&Column| !column.may_be_missing() || is_there(&file, column);
        let held: Vec<&Column> = columns.iter().filter(there).collect();
        // Written last: what it covers is complete, whatever happened to the writer.
        let pulses = file.dataset(INDEX)?.shape().first().copied().unwrap_or(0);
        for column in &held {
            let dataset = file.dataset(&column.path)?;
            let found = dataset.shape();
            if found.get(1..) != Some(column.shape.as_slice()) {
                return Err(Fault::Text(format!("/{} has the shape {found:?}", column.path)));
            }
            if found[0] < pulses {
                return Err(Fault::Text(format!("/{} has {} rows of {pulses}", column.path, found[0])));
            }
            sizes::check(&dataset, Some(pulses), file_bytes)?;
        }
        let held = held.into_iter().map(|column| column.path.clone()).collect();
        Ok(Self { file, columns, held, header, pulses })
    }

    /// Last pulse of the segment before this file.
    pub(crate) fn after_pulse(&self) -> Option<u64> {
        after_pulse(&self.file)
    }

    /// Index of one pulse.
    pub(crate) fn index(&self, row: usize) -> Result<u64, Fault> {
        let index = self.file.dataset(INDEX)?;
        let value = index.read_slice_1d::<u64, _>(row..row + 1)?;
        value.first().copied().ok_or_else(|| Fault::Text(format!("no row {row}")))
    }

    /// Flags of one pulse.
    pub(crate) fn flags(&self, row: usize) -> Result<u32, Fault> {
        let value = self.file.dataset("pulse/flags")?.read_slice_1d::<u32, _>(row..row + 1)?;
        value.first().copied().ok_or_else(|| Fault::Text(format!("no row {row}")))
    }

    /// Rows of a column.
    pub(crate) fn length(&self, column: &Column) -> Result<u64, Fault> {
        Ok(self.file.dataset(&column.path)?.shape().first().map_or(0, |rows| *rows as u64))
    }

    /// Whether chunks bear checksums; those of earlier versions do not.
    pub(crate) fn has_checksums(&self) -> bool {
        let filters = self.file.dataset("iq").map(|iq| iq.filters());
        filters.is_ok_and(|filters| filters.contains(&Filter::Fletcher32))
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

    /// Reads all there is and keeps nothing of it. A fault does not end it: others read on behind one, too.
    pub(crate) fn read_through(&self) -> Result<(), Fault> {
        let rows = (CHUNK_BYTES / self.row_bytes().max(1)).clamp(1, 4096);
        let held = self.columns.iter().filter(|column| self.has(column));
        let mut first = None;
        let mut more: u64 = 0;
        for column in held {
            for from in (0..self.pulses).step_by(rows) {
                let to = (from + rows).min(self.pulses);
                match (self.column(column, from, to), &first) {
                    (Ok(_), _) => {}
                    (Err(fault), None) => {
                        first = Some(format!("/{}, rows {from}..{to}: {fault}", column.path))
                    }
                    (Err(_), Some(_)) => more += 1,
                }
            }
        }
        match (first, more) {
            (None, _) => Ok(()),
            (Some(first), 0) => Err(Fault::Text(first)),
            (Some(first), 1) => Err(Fault::Text(format!("{first}; and 1 more fault"))),
            (Some(first), more) => Err(Fault::Text(format!("{first}; and {more} more faults"))),
        }
    }

    /// Bytes of a pulse over all columns.
    pub(crate) fn row_bytes(&self) -> usize {
        self.columns.iter().map(Column::row_bytes).sum()
    }
}
