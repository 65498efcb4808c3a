//! A run with its page, and a browser's side of HTTP and of WebSocket (RFC 6455), as far as the tests of the
//! page need them.

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command};
use std::thread;
use std::time::{Duration, Instant};

use crate::program::started;

/// One strong target, a radar and a receiver at rest, clocks that are right; light enough for any machine.
pub const SCENARIO: &str = r#"
[scene]
duration_s = 60.0
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 100.0
channels = ["HH", "VV"]
noise_figure_db = 3.0
waveform = { kind = "lfm", bandwidth_hz = 60e6, pulse_s = 1e-6 }
window = { samples = 600, start_us = 33.0 }
[[platform]]
name = "mast"
track = { kind = "fixed", position_m = [0.0, 0.0, 50.0] }
[[platform]]
name = "aircraft"
track = { kind = "straight", position_m = [0.0, -1000.0, 1000.0], velocity_mps = [0.0, 50.0, 0.0] }
[[transmitter]]
name = "tx"
platform = "mast"
power_w = 1000.0
antenna = { kind = "isotropic" }
[[receiver]]
name = "rx"
platform = "aircraft"
antenna = { kind = "rectangle", width_m = 0.5, height_m = 0.2 }
pointing = { kind = "at", position_m = [5000.0, 0.0, 0.0] }
[[target]]
name = "buoy"
position_m = [5000.0, 0.0, 2.0]
rcs_m2 = 1e5
[stream]
policy = "slip"
[[sink]]
kind = "null"
"#;

/// A program that serves a page.
pub struct Shown {
    pub child: Child,
    pub address: String,
    pub token: String,
    _folder: tempfile::TempDir,
}

impl Drop for Shown {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The address of its page that a program prints.
pub fn served(folder: tempfile::TempDir, mut child: Child) -> Shown {
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with("monitor: ") {
        line.clear();
        assert!(lines.read_line(&mut line).unwrap() > 0, "the program ends without a page");
    }
    // A pipe that nobody reads would hold up the program.
    thread::spawn(move || lines.lines().map_while(Result::ok).for_each(drop));
    let place = line.trim().strip_prefix("monitor: http://").unwrap().trim_end_matches('/');
    let (address, token) = place.split_once('/').unwrap();
    let (address, token) = (address.to_owned(), token.to_owned());
    assert!(address.starts_with("127.0.0.1:") && token.len() == 32, "{line}");
    Shown { child, address, token, _folder: folder }
}

/// The run of the scenario, and its page.
pub fn shown(more: &[&str]) -> Shown {
    shown_of(SCENARIO, more)
}

/// The run of any scenario, and its page.
pub fn shown_of(scenario: &str, more: &[&str]) -> Shown {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("page.toml"), scenario).unwrap();
    let run = ["run", "page.toml", "--json", "--monitor", "127.0.0.1:0"];
    let child = started(folder.path(), &[&run[..], more].concat());
    served(folder, child)
}

impl Shown {
    pub fn browser(&self) -> Browser {
        let own = format!("Origin: http://{}\r\n", self.address);
        Browser::open(&self.address, &self.token, &own).unwrap()
    }

    pub fn path(&self, part: &str) -> String {
        format!("/{}/{part}", self.token)
    }

    /// Ends the run as Ctrl-C does, and returns its report.
    pub fn end(mut self) -> serde_json::Value {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        self.report()
    }

    fn report(&mut self) -> serde_json::Value {
        let mut text = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
        assert!(self.child.wait().unwrap().success());
        serde_json::from_str(text.lines().last().unwrap()).unwrap()
    }
}

/// Opens a connection.
pub fn connection(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream
}

/// What comes back for bytes sent as they are, until the other side closes.
pub fn raw(address: &str, bytes: &[u8]) -> String {
    let mut stream = connection(address);
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// Status and whole answer to `GET` with further header lines.
pub fn get(address: &str, path: &str, more: &str) -> (u16, String) {
    let host =
        if more.to_lowercase().contains("host:") { String::new() } else { format!("Host: {address}\r\n") };
    let answer = raw(address, format!("GET {path} HTTP/1.1\r\n{host}{more}\r\n").as_bytes());
    (code(&answer), answer)
}

/// The status code of an answer; 0 of none.
pub fn code(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0)
}

/// What follows the header.
pub fn body(answer: &str) -> &str {
    answer.split_once("\r\n\r\n").map_or("", |(_, body)| body)
}

/// A message from the run.
#[derive(Debug)]
pub enum Message {
    Json(serde_json::Value),
    Lines(Vec<Line>),
    Map { rows: usize, span_hz: f64 },
    Radials(Vec<Radial>),
    Closed(u16),
}

/// A range line: its pulse, first delay and step, levels in dBW.
#[derive(Debug)]
pub struct Line {
    pub pulse: u64,
    pub start_s: f64,
    pub step_s: f64,
    pub levels_dbw: Vec<f64>,
}

/// A radial: its pulse and time, azimuth and heading, first delay and step, levels in dBW (`None`: 127 dB
/// below the peak, or less).
#[derive(Clone, Debug)]
pub struct Radial {
    pub pulse: u64,
    pub time_s: f64,
    pub azimuth_deg: f64,
    pub heading_deg: f64,
    pub start_s: f64,
    pub step_s: f64,
    pub levels_dbw: Vec<Option<f64>>,
}

/// A browser that looks on.
pub struct Browser {
    pub stream: TcpStream,
}

impl Browser {
    /// Opens the socket of a page, or the status with which that is refused.
    pub fn open(address: &str, token: &str, more: &str) -> Result<Self, u16> {
        let mut stream = connection(address);
        let ask = format!(
            "GET /{token}/socket HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{more}\r\n"
        );
        stream.write_all(ask.as_bytes()).unwrap();
        let mut head = Vec::new();
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") {
            if stream.read_exact(&mut byte).is_err() {
                break;
            }
            head.push(byte[0]);
        }
        let head = String::from_utf8_lossy(&head);
        match code(&head) {
            // The answer to the key of RFC 6455, 1.3.
            101 if head.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=") => Ok(Self { stream }),
            refused => Err(refused),
        }
    }

    /// Sends a frame with a head of one's own choice.
    pub fn frame(&mut self, opcode: u8, length: u64, payload: &[u8]) -> io::Result<()> {
        let mut bytes = vec![0x80 | opcode];
        match length {
            0..126 => bytes.push(0x80 | length as u8),
            126..65_536 => {
                bytes.push(0x80 | 126);
                bytes.extend((length as u16).to_be_bytes());
            }
            _ => {
                bytes.push(0x80 | 127);
                bytes.extend(length.to_be_bytes());
            }
        }
        // A mask of zeros leaves the payload as it is.
        bytes.extend([0; 4]);
        bytes.extend(payload);
        self.stream.write_all(&bytes)
    }

    /// Sends an empty frame that is not the last of its message: the first of a text, or one that goes on.
    pub fn fragment(&mut self, opcode: u8) -> io::Result<()> {
        self.stream.write_all(&[opcode, 0x80, 0, 0, 0, 0])
    }

    pub fn send(&mut self, text: &str) {
        self.frame(1, text.len() as u64, text.as_bytes()).unwrap();
    }

    pub fn next(&mut self) -> io::Result<Message> {
        let mut head = [0; 2];
        self.stream.read_exact(&mut head)?;
        let length = match head[1] {
            126 => {
                let mut bytes = [0; 2];
                self.stream.read_exact(&mut bytes)?;
                u16::from_be_bytes(bytes).into()
            }
            127 => {
                let mut bytes = [0; 8];
                self.stream.read_exact(&mut bytes)?;
                u64::from_be_bytes(bytes)
            }
            short => u64::from(short),
        };
        assert!(length < 8 << 20, "{length}");
        let mut payload = vec![0; length as usize];
        self.stream.read_exact(&mut payload)?;
        Ok(match head[0] & 15 {
            1 => Message::Json(serde_json::from_slice(&payload).unwrap()),
            2 => binary(&payload),
            8 => Message::Closed(u16::from_be_bytes([payload[0], payload[1]])),
            other => panic!("opcode {other}"),
        })
    }

    /// The next message for which `wanted` has a value.
    pub fn until<T>(&mut self, mut wanted: impl FnMut(&Message) -> Option<T>) -> T {
        let begun = Instant::now();
        loop {
            let message = self.next().expect("a message");
            if let Some(found) = wanted(&message) {
                return found;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "not within a minute");
        }
    }

    /// The next JSON message of a kind.
    pub fn json(&mut self, kind: &str) -> serde_json::Value {
        self.until(|message| match message {
            Message::Json(value) if value["kind"] == kind => Some(value.clone()),
            _ => None,
        })
    }

    /// How the other side ends it: its close code, or 0 for a connection that is cut.
    pub fn closed(&mut self) -> u16 {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(15) {
            match self.next() {
                Ok(Message::Closed(code)) => return code,
                Ok(_) => {}
                Err(_) => return 0,
            }
        }
        panic!("it goes on");
    }
}

fn binary(bytes: &[u8]) -> Message {
    let short = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let real = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let (columns, rows, step_s) = (short(4), short(6), real(8));
    if bytes[0] == 2 {
        assert_eq!(bytes.len(), 48 + 2 * rows * columns);
        return Message::Map { rows, span_hz: real(40) };
    }
    if bytes[0] == 3 {
        let size = 48 + columns;
        assert_eq!(bytes.len(), 16 + rows * size);
        let radial = |row: usize| {
            let at = 16 + row * size;
            let level = |code: u8| (code > 0).then(|| real(at + 40) - 0.5 * f64::from(255 - code));
            Radial {
                pulse: real(at) as u64,
                time_s: real(at + 8),
                start_s: real(at + 16),
                azimuth_deg: real(at + 24),
                heading_deg: real(at + 32),
                step_s,
                levels_dbw: bytes[at + 48..at + size].iter().map(|code| level(*code)).collect(),
            }
        };
        return Message::Radials((0..rows).map(radial).collect());
    }
    let size = 24 + 2 * columns;
    assert_eq!((bytes[0], bytes.len()), (1, 16 + rows * size));
    let line = |row: usize| {
        let at = 16 + row * size;
        let level = |column: usize| {
            let at = at + 24 + 2 * column;
            f64::from(i16::from_le_bytes([bytes[at], bytes[at + 1]])) * 0.01
        };
        Line {
            pulse: real(at) as u64,
            start_s: real(at + 16),
            step_s,
            levels_dbw: (0..columns).map(level).collect(),
        }
    };
    Message::Lines((0..rows).map(line).collect())
}
