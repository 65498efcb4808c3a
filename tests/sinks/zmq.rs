//! ZeroMQ: what a subscriber gets, which here speaks ZMTP 3.0 by hand. libzmq judges in `python/tests` and
//! `tools/gnuradio`.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use nereus::pulse::{SampleFormat, Samples};
use nereus::recording::header::Header;
use nereus::sinks::sink::Sink;
use nereus::sinks::zmq::{Messages, Settings, ZmqSink};
use nereus::sinks::{self, Kind};
use serde_json::Value;

use crate::recording_fixture::{header, pulse};

/// A subscriber.
struct Sub(TcpStream);

impl Sub {
    /// Connects and subscribes; the sink knows of it when this returns.
    fn to(address: SocketAddr, topic: &[u8]) -> Self {
        let mut sub = Self::greeted(address);
        let mut body = vec![1];
        body.extend_from_slice(topic);
        sub.send(0, &body);
        sub.ask();
        sub
    }

    fn greeted(address: SocketAddr) -> Self {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let mut greeting = [0; 64];
        (greeting[0], greeting[9], greeting[10], greeting[11]) = (0xff, 0x7f, 3, 1);
        greeting[12..16].copy_from_slice(b"NULL");
        stream.write_all(&greeting).unwrap();
        let mut answer = [0; 64];
        stream.read_exact(&mut answer).unwrap();
        assert_eq!(
            (answer[0], answer[9], answer[10], &answer[12..17]),
            (0xff, 0x7f, 3, b"NULL\0".as_slice())
        );
        let mut sub = Self(stream);
        sub.send(4, b"\x05READY\x0bSocket-Type\0\0\0\x03SUB");
        let (flags, ready) = sub.frame();
        assert!(flags == 4 && ready.starts_with(b"\x05READY\x0bSocket-Type\0\0\0\x03PUB"), "{ready:?}");
        sub
    }

    fn send(&mut self, flags: u8, body: &[u8]) {
        self.0.write_all(&[&[flags, u8::try_from(body.len()).unwrap()], body].concat()).unwrap();
    }

    /// Asks whether somebody is there, and waits for the answer.
    fn ask(&mut self) {
        self.send(4, b"\x04PING\0\0hello");
        assert_eq!(self.frame(), (4, b"\x04PONGhello".to_vec()));
    }

    fn frame(&mut self) -> (u8, Vec<u8>) {
        let mut flags = [0];
        self.0.read_exact(&mut flags).unwrap();
        let mut length = [0; 8];
        if flags[0] & 2 == 0 {
            self.0.read_exact(&mut length[7..]).unwrap();
        } else {
            self.0.read_exact(&mut length).unwrap();
        }
        let mut body = vec![0; u64::from_be_bytes(length) as usize];
        self.0.read_exact(&mut body).unwrap();
        (flags[0] & !2, body)
    }

    fn message(&mut self) -> Vec<Vec<u8>> {
        let mut frames = Vec::new();
        loop {
            let (flags, body) = self.frame();
            frames.push(body);
            if flags == 0 {
                return frames;
            }
            assert_eq!(flags, 1);
        }
    }
}

fn settings(header: &Header, messages: Messages, buffer_pulses: usize) -> Settings {
    let ports = if messages == Messages::Samples { header.layout.channels as u16 } else { 1 };
    Settings { bind: "127.0.0.1:0".to_owned(), ports, messages, buffer_pulses }
}

fn open(header: &Header, messages: Messages, buffer_pulses: usize) -> Box<ZmqSink> {
    Box::new(ZmqSink::open(&settings(header, messages, buffer_pulses), header).unwrap())
}

/// Little-endian pairs of f32.
fn complex(bytes: &[u8]) -> Vec<[f32; 2]> {
    let real = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    bytes.chunks(8).map(|both| [real(&both[..4]), real(&both[4..])]).collect()
}

#[test]
fn samples_of_a_channel_are_complex64_at_its_port() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let header = header(format);
        let mut sink = open(&header, Messages::Samples, 64);
        let addresses = sink.addresses();
        assert_eq!(addresses.len(), 2);
        let mut subs: Vec<Sub> = addresses.iter().map(|address| Sub::to(*address, b"")).collect();
        for n in 0..20 {
            sink.write(&pulse(&header, n)).unwrap();
            for (channel, sub) in subs.iter_mut().enumerate() {
                let message = sub.message();
                assert_eq!(message.len(), 1);
                let expected: Vec<[f32; 2]> = match pulse(&header, n).samples {
                    Samples::Cf32(all) => all.iter().map(|sample| [sample.re, sample.im]).collect(),
                    // sqrt(W): a mid-rise converter.
                    Samples::Ci16(all) => {
                        all.iter().map(|pair| pair.map(|code| (f32::from(code) + 0.5) * 2.5e-8)).collect()
                    }
                };
                assert_eq!(complex(&message[0]), expected[channel * 50..(channel + 1) * 50]);
            }
        }
        let report = sink.finish().unwrap();
        let all = report.subscribers.unwrap();
        assert_eq!((report.pulses, all.seen, all.messages, all.lost), (20, 2, 40, 0));
    }
}

#[test]
fn multipart_messages_hold_header_and_channels() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let header = Header { pulses: 100, ..crate::emitters::disturbed(format) };
        let mut sink = open(&header, Messages::Multipart, 64);
        let mut sub = Sub::to(sink.addresses()[0], b"");
        let mut only_pulses = Sub::to(sink.addresses()[0], b"pul");
        // Pulses 3 ms apart: the run is described twice.
        for n in 0..400 {
            sink.write(&pulse(&header, n)).unwrap();
            if n == 0 || n == 334 {
                let run = sub.message();
                assert_eq!((run.len(), run[0].as_slice()), (2, b"run".as_slice()), "{n}");
                let run: Value = serde_json::from_slice(&run[1]).unwrap();
                assert_eq!(run["channels"][1]["name"], "HV");
                assert_eq!((&run["carrier_hz"], &run["pulses"]), (&10e9.into(), &100.into()));
                assert_eq!(run["instrument"]["emitters"], serde_json::json!(header.emitters()));
                assert_eq!(run["replica"][2], serde_json::json!([2.0, -1.0]));
                // The truth is not published: neither the scenario nor what it has of targets.
                assert_eq!((&run["config"], &run["targets"]), (&Value::Null, &Value::Null));
            }
            let message = sub.message();
            assert_eq!(only_pulses.message(), message);
            assert_eq!((message.len(), message[0].as_slice()), (4, b"pulse".as_slice()));
            let text: Value = serde_json::from_slice(&message[1]).unwrap();
            let sent = pulse(&header, n);
            assert_eq!((&text["sequence"], &text["index"]), (&n.into(), &n.into()));
            assert_eq!((&text["samples"], &text["channels"]), (&50.into(), &2.into()));
            let (ns, frac_ns) = sent.time.to_unix_ns();
            assert_eq!(text["time_ns"].as_i64(), Some(ns));
            // This reader of JSON rounds the last digit as it likes.
            assert!((text["time_frac_ns"].as_f64().unwrap() - frac_ns).abs() < 1e-15);
            assert_eq!(text["window_start_s"].as_f64(), Some(sent.window_start_s));
            assert_eq!(text["flags"], sent.flags);
            let state = &text["platforms"][1];
            assert_eq!((&state["name"], &state["flags"]), (&"aircraft".into(), &220.into()));
            assert_eq!(state["position_m"][2].as_f64(), Some(sent.nav_reported[1].position_m[2]));
            assert_eq!(state["attitude_quat"][3].as_f64(), Some(sent.nav_reported[1].attitude_quat[3]));
            assert_eq!(message[2..].concat(), sent.samples.as_bytes());
        }
        let finishing = std::thread::spawn(move || sink.finish().unwrap());
        let end = sub.message();
        assert_eq!(end[0], b"end");
        assert_eq!(serde_json::from_slice::<Value>(&end[1]).unwrap()["sequence"], 400);
        drop((sub, only_pulses));
        assert_eq!(finishing.join().unwrap().subscribers.unwrap().lost, 0);
    }
}

/// One that sleeps, one that is gone in the middle, one that sends nonsense, one that never introduces
/// itself.
#[test]
fn nobody_waits_for_a_subscriber() {
    let mut header = header(SampleFormat::Cf32);
    header.layout.samples = 8192;
    let mut sink = open(&header, Messages::Multipart, 16);
    let address = sink.addresses()[0];
    let mut reads = Sub::to(address, b"pulse");
    let sleeps = Sub::to(address, b"pulse");
    let mut leaves = Some(Sub::to(address, b"pulse"));
    let mut talks = Sub::to(address, b"nothing");
    let silent = TcpStream::connect(address).unwrap();
    let mut slowest = Duration::ZERO;
    for n in 0..300_u64 {
        let begun = Instant::now();
        sink.write(&pulse(&header, n)).unwrap();
        slowest = slowest.max(begun.elapsed());
        let text: Value = serde_json::from_slice(&reads.message()[1]).unwrap();
        assert_eq!(text["sequence"], n);
        if n == 20 {
            // What waits for it is lost.
            leaves = None;
        }
        if n % 50 == 0 {
            let _ = talks.0.write_all(&[0xff; 100]);
        }
    }
    assert!(leaves.is_none());
    drop(silent);
    let begun = Instant::now();
    let all = sink.finish().unwrap().subscribers.unwrap();
    // It waits a second for those that sleep, not more.
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
    println!("slowest write {slowest:?}, {all:?}");
    drop(sleeps);
    // 38 MB were published; the sockets of the one that sleeps hold a few of them, its queue 16 pulses.
    assert!(all.seen == 4 && all.lost > 100, "{all:?}");
    assert!(slowest < Duration::from_secs(5), "{slowest:?}");
}

/// Connections that do not say what they are, or say it a byte at a time, take nobody's place.
#[test]
fn connections_that_say_nothing_give_way() {
    let header = header(SampleFormat::Cf32);
    let mut sink = open(&header, Messages::Multipart, 16);
    let address = sink.addresses()[0];
    let mut early = Sub::to(address, b"pulse");
    // The sink takes in 64 at most.
    let silent: Vec<TcpStream> = (0..80).map(|_| TcpStream::connect(address).unwrap()).collect();
    let mut late = Sub::to(address, b"pulse");
    sink.write(&pulse(&header, 0)).unwrap();
    assert_eq!(late.message()[0], b"pulse");
    assert_eq!(early.message()[0], b"pulse");
    drop(silent);
    // A handshake at five bytes a second would take 17 s.
    let mut slow = TcpStream::connect(address).unwrap();
    let begun = Instant::now();
    let mut greeting = [0; 64];
    (greeting[0], greeting[9], greeting[10]) = (0xff, 0x7f, 3);
    let mut bytes = greeting.iter().chain([0; 400].iter());
    while let Some(byte) = bytes.next()
        && slow.write_all(&[*byte]).is_ok()
    {
        assert!(begun.elapsed() < Duration::from_secs(9));
        std::thread::sleep(Duration::from_millis(200));
    }
    assert_eq!(sink.finish().unwrap().subscribers.unwrap().seen, 2);
}

#[test]
fn ports_that_others_have_are_reported() {
    let header = header(SampleFormat::Cf32);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let settings = |bind: &str, ports| Settings {
        bind: bind.to_owned(),
        ports,
        messages: Messages::Samples,
        buffer_pulses: 4,
    };
    let expected = format!(
        "{address}: cannot publish there: Address already in use (os error 98); \
         allowed: an address of this machine and ports that no other program uses"
    );
    let fault = ZmqSink::open(&settings(&address, 1), &header).unwrap_err();
    if cfg!(target_os = "linux") {
        assert_eq!(fault.to_string(), expected);
    }
    let kind = |settings| sinks::Settings::new(Kind::Zmq(settings), 4);
    let faults = sinks::preflight(&[kind(settings(&address, 1))]);
    assert_eq!((faults.len(), faults[0].to_string()), (1, fault.to_string()));
    assert!(faults[0].is_wrong_input());
    drop(taken);
    let faults = sinks::preflight(&[kind(settings(&address, 1))]);
    assert!(faults.is_empty(), "{faults:?}");
    // Ports of two sinks that meet.
    let faults =
        sinks::preflight(&[kind(settings("127.0.0.1:61234", 3)), kind(settings("127.0.0.1:61236", 1))]);
    assert_eq!(faults[0].to_string(), "127.0.0.1:61236: is the output of two sinks; each needs its own");
    let faults = sinks::preflight(&[kind(settings("127.0.0.1:65534", 3))]);
    assert!(faults[0].to_string().ends_with("allowed: a first port of at most 65533"), "{}", faults[0]);
}
