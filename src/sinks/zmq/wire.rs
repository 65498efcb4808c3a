//! ZMTP 3.0, the protocol of ZeroMQ on a connection, as far as a publisher without encryption needs it.
//!
//! Source: [23/ZMTP](https://rfc.zeromq.org/spec/23/). A greeting of 64 bytes, a READY command, then frames:
//! a byte of flags, a length of one or eight bytes, the body. Subscribers send messages of one frame, a 1 or
//! 0 and the prefix that they subscribe to or no longer do; later versions send the same as commands.

use std::io::{self, ErrorKind, Read};

/// More frames of this message follow.
const MORE: u8 = 1;
/// The length takes eight bytes.
const LONG: u8 = 2;
/// Not a message, but a command.
const COMMAND: u8 = 4;

/// The greeting: version 3.0, mechanism NULL.
pub(super) fn greeting() -> [u8; 64] {
    let mut bytes = [0; 64];
    bytes[0] = 0xff;
    bytes[9] = 0x7f;
    bytes[10] = 3;
    bytes[12..16].copy_from_slice(b"NULL");
    bytes
}

/// Whether a greeting is that of a peer that can be talked to.
pub(super) fn understands(greeting: &[u8; 64]) -> bool {
    let mechanism = &greeting[12..32];
    greeting[0] == 0xff
        && greeting[9] & 1 == 1
        && greeting[10] >= 3
        && mechanism.starts_with(b"NULL")
        && mechanism[4..].iter().all(|byte| *byte == 0)
}

/// Appends a frame of a message.
pub(super) fn push_frame(out: &mut Vec<u8>, body: &[u8], more: bool) {
    push_prefix(out, body.len(), if more { MORE } else { 0 });
    out.extend_from_slice(body);
}

/// Appends flags and length.
pub(super) fn push_prefix(out: &mut Vec<u8>, length: usize, flags: u8) {
    match u8::try_from(length) {
        Ok(length) => out.extend_from_slice(&[flags, length]),
        Err(_) => {
            out.push(flags | LONG);
            out.extend_from_slice(&(length as u64).to_be_bytes());
        }
    }
}

/// A command, as a whole frame.
pub(super) fn command(name: &str, data: &[u8]) -> Vec<u8> {
    let mut body = vec![name.len() as u8];
    body.extend_from_slice(name.as_bytes());
    body.extend_from_slice(data);
    let mut frame = Vec::with_capacity(body.len() + 9);
    push_prefix(&mut frame, body.len(), COMMAND);
    frame.extend_from_slice(&body);
    frame
}

/// The READY command of a publisher.
pub(super) fn ready() -> Vec<u8> {
    let mut data = Vec::new();
    for (name, value) in [("Socket-Type", "PUB"), ("Identity", "")] {
        data.push(name.len() as u8);
        data.extend_from_slice(name.as_bytes());
        data.extend_from_slice(&(value.len() as u32).to_be_bytes());
        data.extend_from_slice(value.as_bytes());
    }
    command("READY", &data)
}

/// A command of a subscriber.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// Its type of socket, in its READY command.
    Ready(Vec<u8>),
    /// It wants messages that begin so.
    Subscribe(Vec<u8>),
    /// It no longer does.
    Cancel(Vec<u8>),
    /// It asks whether anybody is there; to be answered with these bytes.
    Ping(Vec<u8>),
    /// Something that needs no answer.
    Nothing,
}

/// Longest frame that is taken from a subscriber, bytes.
const LONGEST: u64 = 4096;

/// Reads a frame.
///
/// # Errors
/// What the system reports, and frames that no subscriber sends.
pub(super) fn read(from: &mut impl Read) -> io::Result<Command> {
    let mut flags = [0];
    from.read_exact(&mut flags)?;
    let [flags] = flags;
    let length = if flags & LONG == 0 {
        let mut length = [0];
        from.read_exact(&mut length)?;
        u64::from(length[0])
    } else {
        let mut length = [0; 8];
        from.read_exact(&mut length)?;
        u64::from_be_bytes(length)
    };
    if length > LONGEST || flags & !(MORE | LONG | COMMAND) != 0 {
        return Err(ErrorKind::InvalidData.into());
    }
    let mut body = vec![0; length as usize];
    from.read_exact(&mut body)?;
    if flags & COMMAND == 0 {
        return Ok(match body.split_first() {
            Some((1, topic)) => Command::Subscribe(topic.to_vec()),
            Some((0, topic)) => Command::Cancel(topic.to_vec()),
            _ => Command::Nothing,
        });
    }
    let (length, rest) = body.split_first().ok_or(ErrorKind::InvalidData)?;
    let (name, data) = rest.split_at_checked(usize::from(*length)).ok_or(ErrorKind::InvalidData)?;
    Ok(match name {
        b"READY" => Command::Ready(property(data, b"socket-type").ok_or(ErrorKind::InvalidData)?),
        b"SUBSCRIBE" => Command::Subscribe(data.to_vec()),
        b"CANCEL" => Command::Cancel(data.to_vec()),
        // Two bytes of a time to live, then what is to come back.
        b"PING" => Command::Ping(data.get(2..).unwrap_or_default().to_vec()),
        b"ERROR" => return Err(ErrorKind::ConnectionAborted.into()),
        _ => Command::Nothing,
    })
}

/// A property of a READY command; names are in any case.
fn property(mut data: &[u8], wanted: &[u8]) -> Option<Vec<u8>> {
    loop {
        let (length, rest) = data.split_first()?;
        let (name, rest) = rest.split_at_checked(usize::from(*length))?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let (value, rest) = rest.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        if name.eq_ignore_ascii_case(wanted) {
            return Some(value.to_vec());
        }
        data = rest;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_greeting_has_the_bytes_of_the_standard() {
        let bytes = greeting();
        assert_eq!(bytes[..10], [0xff, 0, 0, 0, 0, 0, 0, 0, 0, 0x7f]);
        assert_eq!((bytes[10], bytes[11], &bytes[12..16], bytes[32]), (3, 0, b"NULL".as_slice(), 0));
        assert!(understands(&bytes));
        let mut other = bytes;
        other[12..17].copy_from_slice(b"CURVE");
        assert!(!understands(&other));
        let mut old = bytes;
        old[10] = 1;
        assert!(!understands(&old));
    }

    #[test]
    fn lengths_change_their_form_above_255() {
        let mut out = Vec::new();
        push_frame(&mut out, &[7; 255], true);
        assert_eq!((out[0], out[1], out.len()), (1, 255, 257));
        out.clear();
        push_frame(&mut out, &[7; 256], false);
        assert_eq!((&out[..9], out.len()), ([2, 0, 0, 0, 0, 0, 0, 1, 0].as_slice(), 265));
    }

    #[test]
    fn a_subscriber_is_understood_in_either_form() {
        let command_of = |bytes: &[u8]| read(&mut &*bytes).unwrap();
        assert_eq!(command_of(&[0, 3, 1, b'a', b'b']), Command::Subscribe(b"ab".to_vec()));
        assert_eq!(command_of(&[0, 1, 1]), Command::Subscribe(vec![]));
        assert_eq!(command_of(&[0, 2, 0, b'a']), Command::Cancel(b"a".to_vec()));
        assert_eq!(command_of(&command("SUBSCRIBE", b"ab")), Command::Subscribe(b"ab".to_vec()));
        assert_eq!(command_of(&command("PING", &[0, 10, 1, 2])), Command::Ping(vec![1, 2]));
        assert_eq!(command_of(&ready()), Command::Ready(b"PUB".to_vec()));
    }

    #[test]
    fn what_no_subscriber_sends_is_an_error() {
        for bytes in [
            [2, 0, 0, 0, 1, 0, 0, 0, 0].as_slice(),
            &[0xff; 16],
            &[4, 0],
            &[4, 3, 9, b'R', b'E'],
            &command("READY", &[200, 1]),
            &command("ERROR", &[]),
        ] {
            assert!(read(&mut &*bytes).is_err(), "{bytes:?}");
        }
    }
}
