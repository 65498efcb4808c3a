//! INSPVAX and SBET files.

use insta::assert_snapshot;
use nereus::frames::{Geodetic, Point};
use nereus::nav::encode::Format;
use nereus::nav::{AttitudeSource, FileFormat, FileSource, NavError, Place, load, replay};
use proptest::prelude::*;

use crate::sentences::solution_of;
use crate::sources;

fn source(path: &str, format: FileFormat) -> FileSource {
    FileSource { format, attitude: AttitudeSource::Recorded, max_gap_s: 1.5, ..sources::csv(path) }
}

fn geodetic(place: Place) -> Geodetic {
    let Place::Geodetic(place) = place else { panic!("not geodetic") };
    place
}

#[test]
fn a_recorded_cart_is_read() {
    let path = sources::repository("configs/tracks/cart.inspvax");
    let mut source = source(path.to_str().unwrap(), FileFormat::Inspvax);
    source.max_gap_s = 0.06;
    let recording = load(&source).unwrap();
    assert_eq!(recording.fixes.len(), 300);
    let (first, last) = (&recording.fixes[0], &recording.fixes[299]);
    assert_eq!(first.time.to_string(), "2014-11-24T20:30:19.900000Z");
    assert!((last.time.since(first.time) - 14.95).abs() < 1e-9);
    // What an independent unpacking of the first message gives: 16 leap seconds in 2014, height and
    // undulation of the message.
    let place = geodetic(first.place);
    assert!((place.lat_rad.to_degrees() - 43.404_083_561_565_2).abs() < 1e-9);
    assert!((place.lon_rad.to_degrees() + 80.470_222_635_887_9).abs() < 1e-9);
    // The track turns as the velocity of the messages does: sums of velocity are differences of position, to
    // the 0.02 m/s and the corrections of the filter.
    let frame = nereus::frames::SceneFrame::at(place, nereus::frames::Earth::Flat);
    let way = frame.from_geodetic(geodetic(last.place)).unwrap() - Point::new(0.0, 0.0, 0.0);
    let mut sum = [0.0; 3];
    for pair in recording.fixes.windows(2) {
        let h = pair[1].time.since(pair[0].time);
        for fix in pair {
            let [e, n] = fix.velocity_mps.unwrap();
            for (sum, v) in sum.iter_mut().zip([e, n, fix.climb_mps.unwrap()]) {
                *sum += 0.5 * h * v;
            }
        }
    }
    for (way, sum) in way.to_array().into_iter().zip(sum) {
        assert!((way - sum).abs() < 0.02 * 14.95, "{way} {sum}");
    }
    // It drives ahead or astern: the heading is along the way, or against it.
    for fix in &recording.fixes {
        let ([e, n], [yaw, ..]) = (fix.velocity_mps.unwrap(), fix.yaw_pitch_roll_rad.unwrap());
        let across = e * yaw.cos() - n * yaw.sin();
        assert!(across.abs() < 0.25, "{e} {n} {yaw}");
    }
    assert_snapshot!(recording.report.to_string(), @"300 fixes over 14.950 s from 300 lines, longest gap 0.050 s");
}

/// The whole capture and the whole logs, where they are.
#[test]
fn whole_recordings_are_read() {
    let Ok(folder) = std::env::var("NEREUS_NAV_DATA") else {
        println!("skipped: NEREUS_NAV_DATA names no folder with whole recordings");
        return;
    };
    let file = |name: &str| std::path::Path::new(&folder).join(name);
    let text = |name: &str| {
        let mut decoder = nereus::nav::decode::Decoder::new();
        let bytes = std::fs::read(file(name)).unwrap();
        decoder.push(&bytes, &mut |_| {});
        decoder.finish(&mut |_| {});
        format!("{:?}", decoder.counts())
    };
    assert_snapshot!(text("ship_gofree_merrimac.nmea"), @"Counts { lines: 6324, good: 568, bad_checksum: 0, unknown: 5614, malformed: 142, void: 0 }");
    assert_snapshot!(text("ship_plaka_first20000.nmea"), @"Counts { lines: 20000, good: 6250, bad_checksum: 0, unknown: 13750, malformed: 0, void: 0 }");
    let capture = nereus::nav::pcap::load(&file("novatel_span_propak6_ins_ppp.pcap.gz")).unwrap();
    let mut decoder = nereus::nav::decode::Decoder::new();
    assert_eq!(capture.streams.len(), 1);
    // The receiver's answers to commands are lines that are no sentence: `<OK` and its prompt.
    decoder.push(&capture.streams[0].bytes, &mut |_| {});
    decoder.finish(&mut |_| {});
    assert_snapshot!(format!("{:?}", decoder.counts()), @"Counts { lines: 3332, good: 2289, bad_checksum: 0, unknown: 4807, malformed: 2290, void: 0 }");
}

#[test]
fn ascii_and_binary_are_the_same_track() {
    let mut ascii = Vec::new();
    let mut binary = Vec::new();
    for second in 0..5 {
        Format::InspvaxAscii.write(&solution_of(second), &mut ascii).unwrap();
        Format::InspvaxBinary.write(&solution_of(second), &mut binary).unwrap();
    }
    let read = |bytes: &[u8]| replay::parse(bytes, &source("t", FileFormat::Inspvax)).unwrap();
    let (ascii, binary) = (read(&ascii), read(&binary));
    assert_eq!(ascii.fixes.len(), 5);
    for (a, b) in ascii.fixes.iter().zip(&binary.fixes) {
        assert_eq!(a.time, b.time);
        // Half of 1e-11 deg twice, half of 1e-5 m.
        let apart_m = (geodetic(a.place).to_ecef() - geodetic(b.place).to_ecef()).norm();
        assert!(apart_m < 6e-6, "{apart_m}");
    }
}

fn sbet(records: &[[f64; 17]]) -> Vec<u8> {
    records.iter().flatten().flat_map(|figure| figure.to_le_bytes()).collect()
}

fn record(seconds: f64) -> [f64; 17] {
    let mut figures = [0.0; 17];
    figures[..11].copy_from_slice(&[seconds, 0.9, 0.1, 300.0, 40.0, -30.0, 2.0, 0.1, 0.05, 1.5, 0.25]);
    figures
}

#[test]
fn sbet_records() {
    let format = FileFormat::Sbet { gps_week: 2000 };
    let read = |bytes: &[u8]| replay::parse(bytes, &source("t.sbet", format));
    let recording = read(&sbet(&[record(331_218.5), record(331_219.0)])).unwrap();
    let fix = &recording.fixes[0];
    assert_eq!(fix.time.to_string(), "2018-05-09T20:00:00.500000Z");
    assert_eq!(geodetic(fix.place), Geodetic { lat_rad: 0.9, lon_rad: 0.1, h_m: 300.0 });
    assert_eq!(fix.yaw_pitch_roll_rad, Some([1.25, 0.05, 0.1]));
    // Speed and the angle between velocity and nose do not depend on the wander angle: x ahead of the wander
    // frame, y to port.
    let [e, n] = fix.velocity_mps.unwrap();
    assert!((e.hypot(n) - 50.0).abs() < 1e-12 && fix.climb_mps == Some(2.0));
    let course = e.atan2(n);
    // 30 m/s to starboard of the frame's x axis, which looks 0.25 rad to the west of North.
    assert!((course - (30f64.atan2(40.0) - 0.25)).abs() < 1e-12);
    // Over the end of a week.
    for late in [0.5, 604_800.5] {
        let recording = read(&sbet(&[record(604_799.75), record(late)])).unwrap();
        assert!((recording.report.span_s - 0.75).abs() < 1e-9);
    }
}

#[test]
fn faults_of_files() {
    let text = |error: NavError| error.to_string();
    let format = FileFormat::Sbet { gps_week: 2000 };
    let mut bad = record(2.0);
    (bad[1], bad[8]) = (53.0, f64::NAN);
    let mut bytes = sbet(&[record(1.0), bad, record(0.5), record(10.0), record(-1.0)]);
    bytes.push(0);
    assert_snapshot!(text(replay::parse(&bytes, &source("t.sbet", format)).unwrap_err()), @r"
    t.sbet: 6 faults
      line 6: the file ends 1 bytes into a record of 136
      line 2: latitude = 53 is out of range: -1.5707963267948966 to 1.5707963267948966
      line 2: pitch = NaN is out of range: -1.5707963267948966 to 1.5707963267948966
      line 5: time = -1 is out of range: 0 to 6048000
      line 3: time 2018-05-05T23:59:42.500000Z is not later than 2018-05-05T23:59:43.000000Z of the fix before: times must increase
      line 4: no fix for 9.000 s before 2018-05-05T23:59:52.000000Z; longest gap allowed: max_gap_s = 1.5 s; max_gap_s = 9 interpolates it
    ");
    assert_snapshot!(text(replay::parse(&[], &source("t.sbet", format)).unwrap_err()), @r"
    t.sbet: 1 fault
      line 1: the file ends; usable fixes: 0, needed: at least 2
    ");
    let log = b"$GPHDT,1.0,T*23\r\n\xAA\x44\x12";
    assert_snapshot!(text(replay::parse(log, &source("t.inspvax", FileFormat::Inspvax)).unwrap_err()), @r"
    t.inspvax: no usable fix: no INSPVAX, INSPVA or INSPVAS message has a right checksum and a solution
      0 fixes over 0.000 s from 0 lines, longest gap 0.000 s; 1 with a wrong checksum skipped; 1 malformed skipped
    ");
    let mut log = Vec::new();
    for second in [0, 1, 5, 4, 9] {
        Format::InspvaxBinary.write(&solution_of(second), &mut log).unwrap();
    }
    assert_snapshot!(text(replay::parse(&log, &source("t.inspvax", FileFormat::Inspvax)).unwrap_err()), @r"
    t.inspvax: 1 fault
      line 3: no fix for 4.000 s before 2018-05-30T18:40:05.125000Z, the first of 2 gaps, the longest 4.000 s before 2018-05-30T18:40:05.125000Z; longest gap allowed: max_gap_s = 1.5 s; max_gap_s = 4 interpolates them all
    ");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(128) })]

    #[test]
    fn no_bytes_make_the_readers_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600), week in 0u32..10_000) {
        let _ = replay::parse(&bytes, &source("t", FileFormat::Sbet { gps_week: week }));
        let _ = replay::parse(&bytes, &source("t", FileFormat::Inspvax));
        let _ = nereus::nav::pcap::parse(&bytes);
    }

    #[test]
    fn no_figures_make_sbet_panic(figures in proptest::collection::vec(proptest::array::uniform17(any::<f64>()), 0..4)) {
        if let Ok(recording) = replay::parse(&sbet(&figures), &source("t", FileFormat::Sbet { gps_week: 2000 })) {
            for fix in recording.fixes {
                prop_assert!(geodetic(fix.place).h_m.is_finite());
            }
        }
    }
}
