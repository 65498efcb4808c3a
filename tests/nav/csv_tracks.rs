//! CSV tracks: what is read, and how every fault is reported.

use insta::assert_snapshot;
use nereus::nav::{NavError, Place, VerticalDatum, csv};
use proptest::prelude::*;

use crate::sources;

fn error(text: &str) -> String {
    csv::parse(text.as_bytes(), &sources::csv("track.csv")).unwrap_err().to_string()
}

#[test]
fn digits_of_a_time_are_not_lost() {
    let text = "unix_s,x_m,y_m,z_m\n1527705600.000000000123,1,2,3\n1527705600.100000000000456,2,2,3\n";
    let fixes = csv::parse(text.as_bytes(), &sources::csv("t.csv")).unwrap().fixes;
    assert_eq!(fixes[0].time.seconds(), 1_527_705_600);
    assert_eq!(fixes[0].time.fraction_s(), 1.23e-10);
    // One rounding of a number below one: 2^-54.
    assert!((fixes[1].time.fraction_s() - 0.100_000_000_000_456).abs() < 2f64.powi(-54));
    let negative = "unix_s,x_m,y_m,z_m\n-1.25,1,2,3\n-0.25,2,2,3\n";
    let fixes = csv::parse(negative.as_bytes(), &sources::csv("t.csv")).unwrap().fixes;
    assert_eq!((fixes[0].time.seconds(), fixes[0].time.fraction_s()), (-2, 0.75));
}

#[test]
fn heights_follow_the_datum() {
    let text = "height_m,lon_deg,lat_deg,time_utc\n1000,4.5,53,2018-05-30T18:00:00Z\n1000,4.5,53.001,2018-05-30 18:00:01.5\n";
    for (datum, want) in [
        (VerticalDatum::Ellipsoid, 1000.0),
        (VerticalDatum::MeanSeaLevel, 1042.0),
        (VerticalDatum::Barometric { offset_m: -30.0 }, 1012.0),
    ] {
        let mut source = sources::csv("t.csv");
        (source.datum, source.undulation_m) = (datum, 42.0);
        let recording = csv::parse(text.as_bytes(), &source).unwrap();
        let Place::Geodetic(place) = recording.fixes[0].place else { panic!("not geodetic") };
        assert_eq!(place.h_m, want);
        assert!((place.lat_rad.to_degrees() - 53.0).abs() < 1e-13);
        assert_eq!(recording.report.span_s, 1.5);
    }
}

#[test]
fn line_numbers_count_comments_and_blank_lines_whatever_the_line_ends() {
    for end in ["\n", "\r\n"] {
        let lines = [
            "# one",
            "",
            "unix_s,x_m,y_m,z_m",
            "0,0,0,0",
            "# five",
            "",
            "1,x,0,0",
            "2,0,0,0",
            "#",
            "3,0,0,y",
        ];
        let text = lines.join(end);
        let found = error(&text);
        assert!(found.contains("line 7: x_m = 'x'") && found.contains("line 10: z_m = 'y'"), "{found}");
    }
}

#[test]
fn all_faults_are_reported_at_once() {
    assert_snapshot!(error(
        "time_utc,lat_deg,lon_deg,height_m,yaw_deg,pitch_deg,roll_deg\n\
         2018-05-30T18:00:00Z,53,4.5,100,0,0,0\n\
         2018-05-30T18:00:00Z,53,4.5,100,0,0,0\n\
         2018-05-30T17:59:59Z,53,4.5,100,0,0,0\n\
         2018-05-30T18:00:02Z,93,181,NaN,0,95,inf\n\
         2018-05-30T18:00:03+2:00,53,4.5,100,0,0,0\n\
         2018-05-30T18:00:04Z,53,4.5\n\
         2018-02-31T18:00:05Z,53,4.5,,0,0,0\n\
         2018-05-30T18:00:16.5Z,53,4.5,100,0,0,0\n"
    ), @r#"
    track.csv: 12 faults
      line 3: time 2018-05-30T18:00:00.000000Z is not later than 2018-05-30T18:00:00.000000Z of the fix before: times must increase
      line 4: time 2018-05-30T17:59:59.000000Z is not later than 2018-05-30T18:00:00.000000Z of the fix before: times must increase
      line 5: lat_deg = 93 is out of range: -90 to 90
      line 5: lon_deg = 181 is out of range: -180 to 180
      line 5: height_m = 'NaN' is not a finite number
      line 5: pitch_deg = 95 is out of range: -90 to 90
      line 5: roll_deg = 'inf' is not a finite number
      line 6: time_utc = '2018-05-30T18:00:03+2:00' is not a time such as 2018-05-30T18:40:00.25Z
      line 7: 3 fields; the header has 7
      line 8: height_m = '' is not a finite number
      line 8: time_utc = '2018-02-31T18:00:05Z' is not a time such as 2018-05-30T18:40:00.25Z
      line 9: no fix for 16.500 s before 2018-05-30T18:00:16.500000Z; longest gap allowed: max_gap_s = 10 s; max_gap_s = 17 interpolates it
    "#);
}

#[test]
fn headers_are_checked_by_name() {
    assert_snapshot!(error("time_utc,latitude,lon_deg,height_m,x_m,unix_s,x_m,yaw_deg\n"), @r#"
    track.csv: 5 faults
      line 1: unknown column 'latitude'; allowed: time_utc or unix_s; lat_deg, lon_deg, height_m or x_m, y_m, z_m; yaw_deg, pitch_deg, roll_deg
      line 1: column 'x_m' is given twice
      line 1: both time_utc and unix_s are given; give one of them
      line 1: both lat_deg, lon_deg, height_m and x_m, y_m, z_m are given; give one of them
      line 1: missing: all of yaw_deg, pitch_deg and roll_deg, or none
    "#);
    assert_snapshot!(error("lat_deg,lon_deg,height_m\n1,2,3\n"), @r#"
    track.csv: 1 fault
      line 1: missing: time_utc or unix_s
    "#);
    assert_snapshot!(error("unix_s,x_m,y_m,z_m\n"), @r#"
    track.csv: 1 fault
      line 1: the file ends; usable fixes: 0, needed: at least 2
    "#);
    assert_snapshot!(error(""), @r#"
    track.csv: 1 fault
      line 1: the file is empty; needed: a header line and fixes
    "#);
    assert_snapshot!(error("# nothing but a comment\n"), @r#"
    track.csv: 1 fault
      line 1: the file is empty; needed: a header line and fixes
    "#);
}

#[test]
fn many_faults_are_bounded() {
    let rows: String = (0..1000).map(|i| format!("{i},a,b,c\n")).collect();
    let text = error(&format!("unix_s,x_m,y_m,z_m\n{rows}"));
    assert!(text.starts_with("track.csv: 3000 faults\n"), "{text}");
    assert!(text.ends_with("\n  and 2980 more"), "{text}");
    let long = error(&format!("unix_s,x_m,y_m,z_m\n0,{},0,0\n", "9a".repeat(100_000)));
    assert!(long.len() < 200, "{long}");
}

#[test]
fn the_ends_of_the_calendar_are_read_and_printed() {
    for (time, printed) in
        [("-62135596800", "0001-01-01T00:00:00"), ("253402300799.5", "9999-12-31T23:59:59.5")]
    {
        let message = error(&format!("unix_s,x_m,y_m,z_m\n{time},0,0,0\n{time},0,0,0\n"));
        assert!(message.contains(printed), "{message}");
    }
    for time in ["-62135596801", "253402300800", "99999999999999999999"] {
        assert!(error(&format!("unix_s,x_m,y_m,z_m\n{time},0,0,0\n")).contains("unix_s"));
    }
}

#[test]
fn a_missing_file_is_named() {
    let found = nereus::nav::load(&sources::csv("/nowhere/track.csv")).unwrap_err();
    assert!(matches!(found, NavError::Read { .. }));
    assert!(found.to_string().starts_with("/nowhere/track.csv: cannot read the track file: "));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..crate::cases::proptests(512) })]

    #[test]
    fn no_bytes_make_the_parser_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = csv::parse(&bytes, &sources::csv("t.csv"));
    }

    #[test]
    fn no_fields_make_the_parser_panic(
        rows in proptest::collection::vec(
            ("[-+0-9T:Z.eE ]{0,25}", "[-+0-9.einfa]{0,12}", "[-+0-9.e]{0,12}", "[ -~]{0,8}"), 0..20),
        iso in any::<bool>(),
    ) {
        let time = if iso { "time_utc" } else { "unix_s" };
        let mut text = format!("{time},lat_deg,lon_deg,height_m\n");
        for (t, a, b, c) in rows {
            text.push_str(&format!("{t},{a},{b},{c}\n"));
        }
        if let Ok(recording) = csv::parse(text.as_bytes(), &sources::csv("t.csv")) {
            for pair in recording.fixes.windows(2) {
                prop_assert!(pair[1].time > pair[0].time);
            }
        }
    }

    #[test]
    fn dates_of_any_digits_do_not_panic(d in "[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}(\\.[0-9]{1,12})?Z?") {
        let text = format!("time_utc,x_m,y_m,z_m\n{d},0,0,0\n");
        let message = csv::parse(text.as_bytes(), &sources::csv("t.csv")).unwrap_err().to_string();
        prop_assert!(message.contains("1 fault"));
    }
}
