//! gpsd as the listener: the sentences of a navigation output on a pseudo terminal are those of a live
//! receiver to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use nereus::frames::Geodetic;
use nereus::nav::Sigma;
use nereus::nav::encode::{Format, Sentence};
use nereus::nav::solution::Solution;
use nereus::pulse::{Pulse, SampleFormat};
use nereus::sinks::nav::{Encoder, Messages, NavSettings, NavSink};
use nereus::sinks::port::Device;
use nereus::sinks::sink::Sink;
use nereus::time::{PulseTimes, TimeTag};
use serialport::{SerialPort, TTYPort};

use crate::recording_fixture::header;

const PRF_HZ: f64 = 50.0;
const RATE_HZ: f64 = 5.0;

/// A boat that sails north-east.
fn place(time: TimeTag, start: TimeTag) -> Geodetic {
    let s = time.since(start);
    Geodetic::from_deg(53.5 + 1e-4 * s, -4.25 + 2e-4 * s, 60.0)
}

struct Boat(TimeTag, Format);

impl Encoder for Boat {
    fn encode(&mut self, pulse: &Pulse, out: &mut Vec<u8>) -> u64 {
        let time = pulse.time;
        let solution = Solution {
            time,
            place: place(time, self.0),
            undulation_m: 43.5,
            velocity_mps: Some([13.3, 11.1, 0.0]),
            yaw_pitch_roll_rad: Some([0.9, 0.0, 0.0]),
            sigma: Sigma::default(),
        };
        u64::from(self.1.write(&solution, out).is_err())
    }
}

/// A process of this test, ended with it.
struct Daemon(Child);

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn gpsd(terminal: &str, port: u16) -> Option<Daemon> {
    for program in ["gpsd", "/usr/sbin/gpsd"] {
        let arguments = ["-N", "-n", "-b", "-S", &port.to_string(), terminal];
        let child = Command::new(program).args(arguments).stderr(Stdio::null()).stdout(Stdio::null()).spawn();
        if let Ok(child) = child {
            return Some(Daemon(child));
        }
    }
    println!("skipped: no gpsd");
    None
}

fn connected(port: u16) -> TcpStream {
    let until = Instant::now() + Duration::from_secs(10);
    loop {
        match TcpStream::connect(("127.0.0.1", port)) {
            Ok(stream) => return stream,
            Err(error) => assert!(Instant::now() < until, "gpsd does not listen: {error}"),
        }
        thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn gpsd_reads_a_terminal_as_a_live_receiver() {
    // The sink has one terminal, gpsd the other; bytes are carried over between.
    let (mut from, sink_end) = TTYPort::pair().unwrap();
    let (mut to, daemon_end) = TTYPort::pair().unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let Some(_daemon) = gpsd(&daemon_end.name().unwrap(), port) else { return };
    let mut client = connected(port);
    client.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    client.write_all(b"?WATCH={\"enable\":true,\"json\":true};\n").unwrap();

    let done = Arc::new(AtomicBool::new(false));
    let ended = Arc::clone(&done);
    let carrier = thread::spawn(move || {
        from.set_timeout(Duration::from_millis(50)).unwrap();
        let mut bytes = [0; 512];
        while !ended.load(Ordering::Acquire) {
            if let Ok(count) = from.read(&mut bytes) {
                let _ = to.write_all(&bytes[..count]);
            }
        }
        to
    });
    let mut header = header(SampleFormat::Cf32);
    header.prf_hz = PRF_HZ;
    header.start = TimeTag::from_iso8601("2021-07-01T12:00:00Z").unwrap();
    let start = header.start;
    let settings = NavSettings {
        device: Device::of(&sink_end.name().unwrap(), 38_400).unwrap(),
        platform: 1,
        messages: Messages::Nmea(vec!["GGA", "RMC"]),
        rate_hz: RATE_HZ,
        latency_s: 0.0,
        force: false,
    };
    let format = Format::Nmea(vec![Sentence::Gga, Sentence::Rmc]);
    let mut sink = NavSink::open(&settings, Box::new(Boat(start, format)), &header).unwrap();
    let feeder = thread::spawn(move || {
        let times = PulseTimes::uniform(PRF_HZ).unwrap();
        let mut pulse = Pulse::new(&header.layout);
        let begun = Instant::now();
        for index in 0..300u32 {
            thread::sleep(Duration::from_secs_f64(f64::from(index) / PRF_HZ).saturating_sub(begun.elapsed()));
            pulse.time = times.emission(start, index.into());
            sink.write(&pulse).unwrap();
        }
        Box::new(sink).finish().unwrap()
    });

    let mut reports = 0;
    let until = Instant::now() + Duration::from_secs(12);
    for line in BufReader::new(client).lines() {
        let Ok(line) = line else { break };
        let report: serde_json::Value = serde_json::from_str(&line).unwrap();
        if report["class"] == "TPV"
            && report["mode"].as_i64() >= Some(2)
            && report["lat"].is_f64()
            && report["time"].is_string()
        {
            let time = TimeTag::from_iso8601(report["time"].as_str().unwrap()).unwrap();
            let wanted = place(time, start);
            // gpsd prints nine decimals of a degree.
            for (key, rad) in [("lat", wanted.lat_rad), ("lon", wanted.lon_rad)] {
                let deg = report[key].as_f64().unwrap();
                assert!((deg - rad.to_degrees()).abs() < 2e-9, "{key} {report}");
            }
            if let Some(height_m) = report["altHAE"].as_f64() {
                assert!((height_m - 60.0).abs() < 2e-3, "{report}");
            }
            if let Some(speed) = report["speed"].as_f64() {
                assert!((speed - 13.3f64.hypot(11.1)).abs() < 2e-3, "{report}");
            }
            reports += 1;
        }
        if reports == 20 || Instant::now() > until {
            break;
        }
    }
    let report = feeder.join().unwrap();
    done.store(true, Ordering::Release);
    drop(carrier.join().unwrap());
    println!("{reports} reports, {:?}", report.port);
    // 30 messages were sent; gpsd needs some to find the rate and kind of its receiver.
    assert_eq!(reports, 20, "{:?}", report.port);
}
