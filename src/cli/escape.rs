//! Text for a terminal: names in recordings, datagrams and scenarios may hold what moves its cursor, sets its title or turns
//! its text around. Such characters are shown as `\u{1b}`, everywhere, because everything that is printed goes through here.

use std::borrow::Cow;
use std::io::{self, Write};

/// Whether a character does something to a terminal instead of standing there.
fn acts(c: char) -> bool {
    let ends_line = matches!(c, '\n' | '\t');
    (c.is_control() && !ends_line)
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}')
}

/// The text with such characters written out.
pub(super) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
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
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_written_out() {
        assert_eq!(printable("HH \u{1b}[2J\r\u{9b}x\u{7f}"), "HH \\u{1b}[2J\\u{d}\\u{9b}x\\u{7f}");
        assert_eq!(printable("a\u{202e}b"), "a\\u{202e}b");
        assert!(matches!(printable("Größe\t1 m\n"), Cow::Borrowed(_)));
        let mut out = Printable(Vec::new());
        out.write_all("é x\u{1b}]0;y\u{7}\n".as_bytes()).unwrap();
        assert_eq!(String::from_utf8(out.0).unwrap(), "é x\\u{1b}]0;y\\u{7}\n");
    }
}
