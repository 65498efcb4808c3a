//! Files as they lie about: gzipped, and text of two bytes a character.
//!
//! ```
//! use nereus::nav::unpacked;
//! assert_eq!(unpacked::utf8(b"\xFF\xFE$\0G\0P\0"), &b"$GP"[..]);
//! assert_eq!(unpacked::utf8(b"\xEF\xBB\xBFtime_utc"), &b"time_utc"[..]);
//! ```

use std::borrow::Cow;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::NavError;
use crate::inputs;

/// The most bytes that are read of a file, unpacked.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// What a gzipped file begins with.
pub const GZIP: [u8; 2] = [0x1F, 0x8B];

/// A file that is unpacked as it is read, if it is gzipped.
///
/// # Errors
/// What cannot be opened or read.
pub fn open(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    let mut file = inputs::open(path)?;
    let mut begin = Vec::new();
    file.by_ref().take(GZIP.len() as u64).read_to_end(&mut begin)?;
    let is_packed = begin == GZIP;
    let whole = io::Cursor::new(begin).chain(file);
    Ok(if is_packed { Box::new(MultiGzDecoder::new(whole)) } else { Box::new(whole) })
}

/// The bytes of a file, unpacked if it is gzipped.
///
/// # Errors
/// A file that cannot be read, broken compression, and more than [`MAX_FILE_BYTES`].
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, NavError> {
    let mut bytes = Vec::new();
    open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|source| NavError::Read { path: path.to_owned(), source })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(NavError::TooLarge { path: path.to_owned(), allowed_bytes: MAX_FILE_BYTES });
    }
    Ok(bytes)
}

/// The first bytes of a file, unpacked; empty if it cannot be read.
pub(crate) fn beginning(path: &Path, most: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A packed file that is cut still has a beginning.
    let _ = open(path).and_then(|file| file.take(most).read_to_end(&mut bytes));
    bytes
}

/// Text as bytes of UTF-8, without a byte order mark; UTF-16 is recognised by its mark, or by the zeros of
/// its first eight characters.
pub fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    if let Some(text) = bytes.strip_prefix(b"\xEF\xBB\xBF") {
        return Cow::Borrowed(text);
    }
    let zeros = |at: usize| bytes.len() >= 16 && (0..16).all(|i| (bytes[i] == 0) == (i % 2 == at));
    let (text, is_little) = match bytes {
        [0xFF, 0xFE, text @ ..] => (text, true),
        [0xFE, 0xFF, text @ ..] => (text, false),
        _ if zeros(1) => (bytes, true),
        _ if zeros(0) => (bytes, false),
        _ => return Cow::Borrowed(bytes),
    };
    let units = text.as_chunks::<2>().0.iter();
    let units =
        units.map(|unit| if is_little { u16::from_le_bytes(*unit) } else { u16::from_be_bytes(*unit) });
    let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Cow::Owned(text.collect::<String>().into_bytes())
}
