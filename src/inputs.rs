//! Files that a command is given to read.
//!
//! Opening a pipe waits for who writes into it, and a device may never end, so what is no regular file is
//! refused before it is opened. Folders can be opened; reading them fails with the system's own text.
//!
//! ```
//! use nereus::inputs;
//! let path = std::env::temp_dir().join(format!("nereus-inputs-{}", std::process::id()));
//! std::fs::write(&path, "12345678")?;
//! // One byte more than is allowed: the file is longer.
//! assert_eq!(inputs::read(&path, 4)?, b"12345");
//! # std::fs::remove_file(path)?;
//! # Ok::<(), std::io::Error>(())
//! ```

use std::borrow::Cow;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;
#[cfg(test)]
use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

/// Kind of the error of what is no file.
const REFUSED: ErrorKind = ErrorKind::Unsupported;
const WHY: &str = "is a pipe or a device; allowed: a regular file";

fn regular(data: &Metadata) -> io::Result<()> {
    if data.is_file() || data.is_dir() { Ok(()) } else { Err(io::Error::new(REFUSED, WHY)) }
}

/// The text of an error of which its kind alone was kept.
pub fn reason(kind: ErrorKind) -> String {
    if kind == REFUSED { WHY.to_owned() } else { kind.to_string() }
}

/// Opens a file that is one.
///
/// # Errors
/// Pipes, sockets and devices, and what the system refuses.
pub fn open(path: &Path) -> io::Result<File> {
    regular(&std::fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // Another file may have got the name since: a pipe does not hold up who opens it so.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    let file = options.open(path)?;
    #[cfg(test)]
    OPENED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
    regular(&file.metadata()?)?;
    Ok(file)
}

/// Every path that was opened, in tests.
#[cfg(test)]
static OPENED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// How often a path was opened.
#[cfg(test)]
pub(crate) fn opened(path: &Path) -> usize {
    OPENED.lock().unwrap_or_else(PoisonError::into_inner).iter().filter(|known| *known == path).count()
}

/// Reads a file, and at most one byte more than is allowed: then it is too long.
///
/// # Errors
/// As [`open`], and what cannot be read.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The first bytes of a file, at most so many; none of what is no file. Links are not followed.
pub fn beginning(path: &Path, bytes: u64) -> Option<Vec<u8>> {
    let is_file = std::fs::symlink_metadata(path).is_ok_and(|data| data.is_file());
    let mut start = Vec::new();
    is_file.then(|| open(path).ok()?.take(bytes).read_to_end(&mut start).ok())??;
    Some(start)
}

/// Whether a character does something to a terminal instead of standing there, or turns text around.
pub fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}' | '\u{61c}')
}

/// The text with characters for which `acts` holds written out, as `\u{1b}`.
pub fn written_out(text: &str, acts: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if acts(c) {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// JSON without what acts on a terminal, which is escaped as JSON has it: serde_json escapes only what is
/// below U+0020, and [`written_out`] would write the rest as `\u{202e}`, which is no JSON.
pub(crate) fn escaped_json(plain: String) -> String {
    if !plain.contains(acts) {
        return plain;
    }
    let mut text = String::with_capacity(plain.len() + 16);
    // Such characters stand within strings only.
    for c in plain.chars() {
        if acts(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                text += &format!("\\u{unit:04x}");
            }
        } else {
            text.push(c);
        }
    }
    text
}

/// A name or a message that came in a file, on one line: what it holds must not look like a line of this
/// program.
pub fn one_line(text: &str) -> Cow<'_, str> {
    written_out(text, acts)
}

/// A path as a line of a report holds it.
pub(crate) fn shown(path: &Path) -> String {
    one_line(&path.to_string_lossy()).into_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_name_stays_on_its_line() {
        assert_eq!(one_line("HH\nb.h5: whole\t\r"), "HH\\u{a}b.h5: whole\\u{9}\\u{d}");
        assert_eq!(one_line("a\u{2028}b\u{85}"), "a\\u{2028}b\\u{85}");
        assert!(matches!(one_line("Größe 1"), Cow::Borrowed(_)));
    }

    #[test]
    fn a_pipe_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
        for path in [pipe.as_path(), Path::new("/dev/zero")] {
            assert_eq!(open(path).unwrap_err().kind(), ErrorKind::Unsupported, "{}", path.display());
        }
        assert!(read(folder.path(), 9).is_err());
    }
}
