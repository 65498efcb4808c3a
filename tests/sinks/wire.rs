//! The wire, byte by byte against the standard, and by a second decoder.

use nereus::frames::{Earth, Geodetic, Point, SceneFrame, Vector};
use nereus::pulse::{PlatformRecord, Pulse, SampleFormat, Samples};
use nereus::recording::header::{Header, Origin};
use nereus::sinks::sink::Sink;
use nereus::sinks::vita49::{Settings, Vita49Sink};
use nereus::sinks::{self, Kind};
use vita49::prelude::*;

use crate::recording_fixture::{fill, header, pulse};
use crate::wire_fixture::{by_stream, caught, datagrams, kind, long, word};

const SIGNAL: u32 = 1;
const CONTEXT: u32 = 4;
const EXTENSION: u32 = 5;
const CHANNELS: u32 = 0x1000_0000;
const PLATFORMS: u32 = 0x2000_0000;

fn header_of(format: SampleFormat, samples: usize) -> Header {
    let mut header = header(format);
    header.layout.samples = samples;
    header
}

/// Picoseconds since 1970 of a packet.
fn time_ps(datagram: &[u8], at: usize) -> i128 {
    i128::from(word(datagram, at)) * 1_000_000_000_000 + i128::from(long(datagram, at + 4))
}

#[test]
fn packets_fit_the_mtu_and_say_their_size() {
    for (mtu, format) in [(576, SampleFormat::Cf32), (1500, SampleFormat::Ci16), (9000, SampleFormat::Cf32)] {
        let header = header_of(format, 384);
        let (all, report) = datagrams(&header, mtu, 0, 3);
        let longest = all.iter().map(Vec::len).max().unwrap();
        // IPv4 and UDP have 28 bytes of header; a full packet leaves less than a sample unused.
        let full = all.iter().filter(|d| kind(d) == SIGNAL).map(|d| d.len() + 28).max().unwrap();
        assert!(longest + 28 <= mtu, "{longest} of {mtu}");
        assert!(full + 8 > mtu || full == 24 + 384 * 8 + 28, "{full} of {mtu}");
        for datagram in &all {
            assert_eq!(4 * (word(datagram, 0) & 0xffff) as usize, datagram.len());
        }
        let wire = report.wire.unwrap();
        assert_eq!((wire.datagrams, wire.lost()), (all.len() as u64, 0));
        assert_eq!(report.bytes as usize, all.iter().map(Vec::len).sum::<usize>());
        assert_eq!(report.pulses, 3);
    }
}

#[test]
fn every_stream_counts_its_packets_modulo_16() {
    let (all, _) = datagrams(&header_of(SampleFormat::Cf32, 384), 1500, 0, 40);
    let streams = by_stream(&all);
    // Two channels (signal, context, description), two platforms (ephemeris, state, name), the run.
    assert_eq!(streams.len(), 2 * 3 + 2 * 3 + 1);
    for ((kind, stream), packets) in streams {
        for (n, packet) in packets.iter().enumerate() {
            assert_eq!(word(packet, 0) >> 16 & 15, n as u32 % 16, "type {kind}, stream {stream:#x}");
        }
    }
}

/// The stamp of every signal packet, against integers of another unit.
#[test]
fn stamps_are_the_instant_of_the_first_sample() {
    for rate_hz in [100e6, 33.3e6, 61.44e6 + 1.0 / 3.0] {
        let mut header = header_of(SampleFormat::Cf32, 700);
        header.sample_rate_hz = rate_hz;
        let (all, _) = datagrams(&header, 1500, 0, 5);
        let mut seen = 0;
        for ((_, stream), packets) in by_stream(&all).into_iter().filter(|((kind, _), _)| *kind == SIGNAL) {
            let mut first = 0;
            for (n, packet) in packets.iter().enumerate() {
                let of = pulse(&header, (n / 4) as u64);
                if n % 4 == 0 {
                    first = 0;
                }
                // Attoseconds: the fraction of the second and the window are f64 (111 as of rounding in the
                // product), and so is n / fs (2e-16 of at most 21 us). Windows of the fixture are eighths of
                // a second.
                let fraction_as = (of.time.fraction_s() * 1e18).round() as i128;
                let window_as = (of.window_start_s * 8.0) as i128 * 125_000_000_000_000_000;
                let sample_as = (f64::from(first) / rate_hz * 1e18).round() as i128;
                let exact_as =
                    i128::from(of.time.seconds()) * 10i128.pow(18) + fraction_as + window_as + sample_as;
                let off_as = time_ps(packet, 8) * 1_000_000 - exact_as;
                assert!(off_as.abs() <= 500_000 + 400, "stream {stream:#x}, packet {n}: {off_as} as");
                first += (packet.len() as u32 - 24) / 8;
                seen += 1;
            }
            assert_eq!(first, 700);
        }
        assert_eq!(seen, 2 * 5 * 4);
    }
}

#[test]
fn trailers_mark_where_a_pulse_begins_and_ends() {
    let codes = |samples: usize, flags: u32| {
        let header = header_of(SampleFormat::Cf32, samples);
        let (socket, mut sink) = caught(&header, 1500);
        let mut pulse = Pulse::new(&header.layout);
        fill(&mut pulse, &header, 0);
        pulse.flags = flags;
        sink.write(&pulse).unwrap();
        let mut buffer = [0; 2000];
        let mut codes = Vec::new();
        while let Ok(length) = socket.recv(&mut buffer) {
            let packet = &buffer[..length];
            if kind(packet) == SIGNAL && word(packet, 4) == CHANNELS {
                let trailer = word(packet, length - 4);
                // Calibrated time, valid data, reference lock, over-range and both bits of the frame are
                // reported.
                assert_eq!(trailer >> 20, 0b1110_0010_1100);
                assert_eq!(trailer >> 17 & 7, 7);
                codes.push((trailer >> 10 & 3, trailer >> 13 & 1));
            }
        }
        codes
    };
    assert_eq!(codes(181, 0), [(0, 0)]);
    assert_eq!(codes(182, 0), [(1, 0), (3, 0)]);
    assert_eq!(codes(600, 4), [(1, 1), (2, 1), (2, 1), (3, 1)]);
}

/// The crate `vita49` was written by others; it shares nothing with the sender.
#[test]
fn a_second_decoder_reads_the_same() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let header = header_of(format, 384);
        let (all, _) = datagrams(&header, 1500, 0, 4);
        let (mut signals, mut contexts, mut ephemerides) = (0, 0, 0);
        let mut iq = Vec::new();
        for datagram in &all {
            if kind(datagram) == EXTENSION {
                // It has no reader for contexts of others: the prologue is checked below.
                assert_eq!(word(datagram, 8), 0x004e_4552);
                assert_eq!(word(datagram, 12) >> 16, 1);
                continue;
            }
            let packet = Vrt::try_from(datagram.as_slice()).unwrap();
            assert_eq!(packet.header().packet_size() as usize * 4, datagram.len());
            assert_eq!((packet.header().tsi(), packet.header().tsf()), (Tsi::Utc, Tsf::RealTimePs));
            let stream = packet.stream_id().unwrap();
            let at = i128::from(packet.integer_timestamp().unwrap()) * 1_000_000_000_000
                + i128::from(packet.fractional_timestamp().unwrap());
            assert_eq!(at, time_ps(datagram, 8));
            if kind(datagram) == SIGNAL {
                signals += 1;
                let trailer = packet.trailer().unwrap();
                assert_eq!(trailer.valid_data_indicator(), Some(true));
                assert_eq!(trailer.over_range_indicator(), Some(iq.len() / pulse_bytes(format) % 3 == 1));
                iq.extend_from_slice(packet.signal_payload().unwrap());
                continue;
            }
            let context = packet.payload().context().unwrap();
            if stream >= PLATFORMS {
                ephemerides += 1;
                assert!(context.ecef_ephemeris().is_some());
                continue;
            }
            contexts += 1;
            assert_eq!(context.bandwidth_hz(), Some(80e6));
            assert_eq!(context.rf_ref_freq_hz(), Some(10e9));
            assert_eq!(context.if_ref_freq_hz(), Some(0.0));
            assert_eq!(context.sample_rate_sps(), Some(100e6));
            // 1 sqrt(W) is 30 dBm; 2^15 codes of 25 nV are -31.727 dBm, to half of 1/128 dB.
            let expected = match format {
                SampleFormat::Cf32 => 30.0,
                SampleFormat::Ci16 => 20.0 * (32_768.0 * 2.5e-8f64).log10() + 30.0,
            };
            let level = f64::from(context.reference_level_db().unwrap());
            assert!((level - expected).abs() <= 0.5 / 128.0, "{level}");
            // Complex Cartesian; item format, width of the field and of the item less one; nothing else.
            let words: u64 = match format {
                SampleFormat::Cf32 => 1 << 29 | 14 << 24 | 31 << 6 | 31,
                SampleFormat::Ci16 => 1 << 29 | 15 << 6 | 15,
            };
            assert_eq!(context.signal_data_payload_format().copied(), Some(words << 32));
            let lists = context.context_association_lists().unwrap();
            assert_eq!(lists.system_list(), [PLATFORMS, PLATFORMS + 1]);
        }
        let pieces = if format == SampleFormat::Cf32 { 3 } else { 2 };
        assert_eq!((signals, contexts, ephemerides), (4 * 2 * pieces, 2, 4 * 2));
        let sent: Vec<u8> = (0..4).flat_map(|n| big_endian(&pulse(&header, n).samples)).collect();
        assert!(iq == sent, "samples differ");
    }
}

fn pulse_bytes(format: SampleFormat) -> usize {
    2 * 384 * if format == SampleFormat::Cf32 { 8 } else { 4 }
}

fn big_endian(samples: &Samples) -> Vec<u8> {
    match samples {
        Samples::Cf32(all) => all.iter().flat_map(|s| [s.re, s.im]).flat_map(f32::to_be_bytes).collect(),
        Samples::Ci16(all) => all.as_flattened().iter().flat_map(|v| v.to_be_bytes()).collect(),
    }
}

/// The standard ephemeris, decoded by others, against the recorded state by another way to ECEF.
#[test]
fn the_ephemeris_is_the_state_to_half_its_least_bit() {
    let mut header = header_of(SampleFormat::Ci16, 50);
    header.origin = Some(Origin { lat_deg: -33.85, lon_deg: 151.2, h_m: 20.0 });
    let (socket, mut sink) = caught(&header, 1500);
    let mut pulse = Pulse::new(&header.layout);
    fill(&mut pulse, &header, 7);
    let attitude = nereus::frames::Rotation::from_yaw_pitch_roll(0.7, -0.2, 0.1);
    for (p, record) in pulse.nav_reported.iter_mut().enumerate() {
        *record = PlatformRecord {
            position_m: [1234.567, -20_000.1, 3000.9 + p as f64],
            velocity_mps: [70.3, -30.2, 1.7],
            attitude_quat: attitude.to_wxyz(),
            age_s: 0.02,
            flags: 64,
        };
    }
    sink.write(&pulse).unwrap();
    let frame = SceneFrame::at(Geodetic::from_deg(-33.85, 151.2, 20.0), Earth::Flat);
    let mut buffer = [0; 2000];
    let mut seen = 0;
    while let Ok(length) = socket.recv(&mut buffer) {
        let datagram = &buffer[..length];
        let stream = word(datagram, 4);
        let Some(record) = pulse.nav_reported.get(stream.wrapping_sub(PLATFORMS) as usize) else { continue };
        let [e, n, u] = record.position_m;
        let [ve, vn, vu] = record.velocity_mps;
        let position = frame.to_ecef(Point::new(e, n, u)).unwrap().to_array();
        let velocity = frame.vector_to_ecef(Vector::new(ve, vn, vu)).unwrap().to_array();
        if kind(datagram) == EXTENSION {
            // The f64 state: the same numbers, and body to ECEF turns the nose as both steps do.
            let f64_at = |at: usize| f64::from_bits(long(datagram, 28 + at));
            assert_eq!([136, 144, 152].map(f64_at), position);
            assert_eq!([160, 168, 176].map(f64_at), velocity);
            assert_eq!([56, 64, 72].map(f64_at), record.position_m);
            assert_eq!([104, 112, 120, 128].map(f64_at), record.attitude_quat);
            assert_eq!((f64_at(40), word(datagram, 28 + 48), word(datagram, 28 + 52)), (0.02, 64, 2));
            let [w, x, y, z] = [184, 192, 200, 208].map(f64_at);
            let nose = glam::DQuat::from_xyzw(x, y, z, w) * glam::DVec3::X;
            let by_steps = frame.vector_to_ecef(attitude * Vector::new(1.0, 0.0, 0.0)).unwrap().raw();
            // A dozen operations on numbers up to 1.
            assert!((nose - by_steps).length() < 12.0 * f64::EPSILON);
            seen += 1;
            continue;
        }
        let packet = Vrt::try_from(datagram).unwrap();
        let ephemeris = packet.payload().context().unwrap().ecef_ephemeris().copied().unwrap();
        assert_eq!((ephemeris.tsi(), ephemeris.tsf()), (Tsi::Utc, Tsf::RealTimePs));
        assert_eq!(i128::from(ephemeris.integer_timestamp()), i128::from(word(datagram, 8)));
        assert_eq!(ephemeris.fractional_timestamp(), long(datagram, 12));
        let [x, y, z] = [ephemeris.position_x_m(), ephemeris.position_y_m(), ephemeris.position_z_m()];
        let [dx, dy, dz] =
            [ephemeris.velocity_dx_mps(), ephemeris.velocity_dy_mps(), ephemeris.velocity_dz_mps()];
        for (found, exact, bit) in [(x, position[0], 5), (y, position[1], 5), (z, position[2], 5)]
            .into_iter()
            .chain([(dx, velocity[0], 16), (dy, velocity[1], 16), (dz, velocity[2], 16)])
        {
            assert!((found.unwrap() - exact).abs() <= 0.5 / f64::from(1u32 << bit), "{found:?} {exact}");
        }
        // Turned back about z, y and x by the three angles, the nose is the body's.
        let [alpha, beta, phi] =
            [ephemeris.attitude_alpha_deg(), ephemeris.attitude_beta_deg(), ephemeris.attitude_phi_deg()]
                .map(|angle| angle.unwrap().to_radians());
        let turn = glam::DQuat::from_euler(glam::EulerRot::ZYX, alpha, beta, phi);
        for axis in [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z] {
            let [bx, by, bz] = axis.to_array();
            let exact = frame.vector_to_ecef(attitude * Vector::new(bx, by, bz)).unwrap().raw();
            // Three angles, each to half of 2^-22 degrees.
            let bound = 3.0 * 0.5 * (2f64.powi(-22)).to_radians();
            assert!((turn * axis - exact).length() <= bound + 1e-14);
        }
        seen += 1;
    }
    assert_eq!(seen, 4);
}

#[test]
fn a_scene_that_is_not_georeferenced_has_no_ephemeris() {
    let mut header = header_of(SampleFormat::Cf32, 50);
    header.origin = None;
    let (all, _) = datagrams(&header, 1500, 0, 2);
    let streams = by_stream(&all);
    assert!(!streams.contains_key(&(CONTEXT, PLATFORMS)));
    let state = streams[&(EXTENSION, PLATFORMS)][0];
    assert!(f64::from_bits(long(state, 28 + 136)).is_nan());
}

#[test]
fn contexts_come_first_and_once_a_second() {
    // 333.3 pulses a second.
    let (all, _) = datagrams(&header_of(SampleFormat::Ci16, 50), 1500, 0, 700);
    assert_eq!((kind(&all[0]), word(&all[0], 4)), (EXTENSION, 0x4000_0000));
    let streams = by_stream(&all);
    for (key, count) in
        [((CONTEXT, CHANNELS), 3), ((EXTENSION, CHANNELS + 1), 3), ((EXTENSION, 0x4000_0000), 3)]
    {
        assert_eq!(streams[&key].len(), count, "{key:?}");
    }
    let changed = |packet: &[u8]| word(packet, 20) >> 31;
    assert_eq!(streams[&(CONTEXT, CHANNELS)].iter().map(|p| changed(p)).collect::<Vec<_>>(), [1, 0, 0]);
}

#[test]
fn outputs_that_cannot_be_sent_to_are_refused() {
    let kind = |address: &str| {
        let settings = Settings { address: address.to_owned(), ..Settings::default() };
        sinks::Settings::new(Kind::Vita49(settings), 8)
    };
    let faults = sinks::preflight(&[kind("127.0.0.1:4991"), kind("127.0.0.1:4991")]);
    assert!(faults.iter().any(|f| f.to_string().contains("two sinks send there")), "{faults:?}");
    let faults = sinks::preflight(&[kind("no such host:4991")]);
    assert!(faults[0].to_string().starts_with("no such host:4991: looking it up"), "{faults:?}");
    let header = header(SampleFormat::Cf32);
    let mtu = |mtu_bytes| Vita49Sink::open(&Settings { mtu_bytes, ..Settings::default() }, &header);
    assert!(mtu(575).unwrap_err().to_string().contains("576 to 65535"));
    assert!(mtu(65_536).is_err() && mtu(65_535).is_ok() && mtu(576).is_ok());
    let mut long = header.clone();
    long.channels[0].name = "n".repeat(190);
    long.channels[0].receiver = "r".repeat(190);
    long.channels[0].transmitter = "t".repeat(190);
    let small = Settings { mtu_bytes: 576, ..Settings::default() };
    assert!(Vita49Sink::open(&small, &long).unwrap_err().to_string().contains("names that fit"));
    let mut sink = Box::new(Vita49Sink::open(&small, &header).unwrap());
    let mut odd = Pulse::new(&header.layout);
    odd.nav_reported.pop();
    assert!(sink.write(&odd).unwrap_err().to_string().contains("nav has 1 values"));
}
