//! An HDF5 recording that is read: finished, growing, or left by a killed run.

use std::path::Path;

use ::hdf5::filters::Filter;
use ::hdf5::{File, Group, H5Type, LinkType};
use ndarray::IxDyn;

use super::fault::Fault;
use super::file::{after_pulse, open, regular, slab};
use super::{header, sizes, superblock};
use crate::files::Draft;
use crate::recording::columns::{Column, Element, INDEX, Rows, columns};
use crate::recording::header::Header;
use crate::recording::rows::rows_of;

/// Bytes that are read at a time where nothing is kept of them.
const BLOCK_BYTES: usize = 1 << 20;
/// A recording that is read: finished, growing, or left by a killed run.
#[derive(Debug)]
pub(crate) struct Reader {
    file: File,
    columns: Vec<Column>,
    /// Paths of those that are there.
    held: Vec<String>,
    /// What holds for the whole recording.
    pub(crate) header: Header,
    /// Complete pulses.
    pub(crate) pulses: usize,
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

/// Whether a file has a column, asked group by group: what has no parent has no children.
fn is_there(file: &File, column: &Column) -> bool {
    let ends = column.path.match_indices('/').map(|(at, _)| at).chain([column.path.len()]);
    ends.into_iter().all(|end| file.link_exists(&column.path[..end]))
}

/// Pulses of a recording that a reader finds, after a failure: where it is now, if that is known.
pub(crate) fn readable(draft: &Draft) -> u64 {
    let Ok(path) = draft.present() else { return 0 };
    // Where that fails too, what cannot be opened is counted as lost.
    let _ = superblock::enter_end(&path, |file| draft.is(file));
    Reader::open(&path).map_or(0, |recorded| recorded.pulses as u64)
}

impl Reader {
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
        Ok(rows_of!(column.element, get(&self.file, column, from, to)?))
    }

    /// Reads all there is and keeps nothing of it. A fault does not end it: others read on behind one, too.
    pub(crate) fn read_through(&self) -> Result<(), Fault> {
        let rows = (BLOCK_BYTES / self.row_bytes().max(1)).clamp(1, 4096);
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
