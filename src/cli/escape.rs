//! Text for a terminal: names in recordings, datagrams and scenarios may hold what moves its cursor, sets its
//! title or turns its text around. Such characters are shown as `\u{1b}`, everywhere, because everything that
//! is printed goes through here. A line feed in a [`name`] or a [`path()`] would forge a line of a report, so
//! these are made printable where they are inserted.

use std::borrow::Cow;
use std::io::{self, Write};

use crate::inputs::{acts, written_out};

/// A name from elsewhere, and a path, on one line.
pub(super) use crate::inputs::{one_line as name, shown as path};

/// The text with such characters written out; its lines stay.
pub(super) fn printable(text: &str) -> Cow<'_, str> {
    written_out(text, |c| acts(c) && !matches!(c, '\n' | '\t'))
}

/// Writes text on, made printable. What is written at a time must be whole characters, as `write!` has it.
pub(super) struct Printable<W>(pub(super) W);

impl<W: Write> Write for Printable<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\n' | b'\t')) {
            return self.0.write(bytes);
        }
        self.0.write_all(printable(&String::from_utf8_lossy(bytes)).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_written_out() {
        assert_eq!(printable("HH \u{1b}[2J\r\u{9b}x\u{7f}"), "HH \\u{1b}[2J\\u{d}\\u{9b}x\\u{7f}");
        assert_eq!(printable("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(path(Path::new("a\nb: whole")), "a\\u{a}b: whole");
        assert!(matches!(printable("Größe\t1 m\n"), Cow::Borrowed(_)));
        let mut out = Printable(Vec::new());
        out.write_all("é x\u{1b}]0;y\u{7}\n".as_bytes()).unwrap();
        assert_eq!(String::from_utf8(out.0).unwrap(), "é x\\u{1b}]0;y\\u{7}\n");
    }
}
