//! Whether a dataset can hold what it announces.
//!
//! A damaged or forged header may announce any size. Nothing is allocated for a dataset before it is known
//! that the file is long enough for it. What is stored elsewhere is not read at all: external files, virtual
//! datasets.

use ::hdf5::Dataset;
use ::hdf5::dataset::Layout;
use ::hdf5::filters::Filter;

use super::fault::Fault;

/// Deflate makes nothing smaller than this part of it.
const MOST_DEFLATED: u64 = 1032;

/// Bytes of the first `rows` rows that a dataset announces, or of all.
fn announced(dataset: &Dataset, rows: Option<usize>) -> Option<u64> {
    let element = u64::try_from(dataset.dtype().ok()?.size()).ok()?;
    let mut shape = dataset.shape();
    if let (Some(first), Some(rows)) = (shape.first_mut(), rows) {
        *first = rows.min(*first);
    }
    let counts = shape.into_iter().map(|count| u64::try_from(count).ok());
    counts.chain([Some(element)]).try_fold(1_u64, |bytes, count| bytes.checked_mul(count?))
}

/// Refuses a dataset that a file of this length cannot hold, or that is not in the file. A run that ended
/// early may leave columns with more rows than were written: only the first `rows` count then.
pub(super) fn check(dataset: &Dataset, rows: Option<usize>, file_bytes: u64) -> Result<(), Fault> {
    let name = dataset.name();
    let refuse = |why: String| Err(Fault::Text(format!("{} {why}", name.escape_debug())));
    let made = dataset.dcpl()?;
    if !made.get_external()?.is_empty() {
        return refuse("lies in another file; recordings are read from one file alone".to_owned());
    }
    if made.get_layout()? == Layout::Virtual {
        return refuse("is put together from other datasets; recordings hold their own".to_owned());
    }
    let filters = made.get_filters()?;
    let known = |filter: &Filter| matches!(filter, Filter::Deflate(_) | Filter::Shuffle | Filter::Fletcher32);
    if !filters.iter().all(known) {
        return refuse(
            "is packed by a filter that is not read; allowed: deflate, shuffle, Fletcher32".to_owned(),
        );
    }
    let most =
        if filters.iter().any(|filter| matches!(filter, Filter::Deflate(_))) { MOST_DEFLATED } else { 1 };
    let stored = dataset.storage_size().min(file_bytes);
    let Some(bytes) = announced(dataset, rows) else {
        return refuse(format!("announces {:?} values, more than can be counted", dataset.shape()));
    };
    if bytes > stored.saturating_mul(most) {
        return refuse(format!(
            "announces {bytes} bytes, {stored} are stored in a file of {file_bytes}: it was cut off or damaged"
        ));
    }
    // What is read at a time is a chunk, whole.
    if let Some(chunk) = made.get_chunk()?
        && bytes > 0
    {
        let element = dataset.dtype()?.size();
        let chunk_bytes = chunk.iter().try_fold(element, |bytes, count| bytes.checked_mul(*count));
        if chunk_bytes.is_none_or(|bytes| bytes as u64 > stored.saturating_mul(most)) {
            return refuse(format!("has chunks of {chunk:?} values, more than the {stored} bytes stored"));
        }
    }
    Ok(())
}
