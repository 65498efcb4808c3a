//! Logs of AIS as receivers and offices write them. What sentences hold is what pyais 3.3.1 decodes of them.

use super::*;

/// A position report of message 1, with the UTC of its reception in a tag block.
const TAGGED: &str = "\\c:1714564800*55\\!AIVDM,1,1,,A,139>Jh@P1T0eii`NqRv1hgv00000,0*22\n";
/// Its ship's size, in two sentences: 140 m x 22 m, 7.3 m draught.
const STATIC: &str = "!AIVDO,2,1,0,A,55M:Ii0000000000001@E=@00000000000000000<P`:<0000B@000000000,0*01
!AIVDO,2,2,0,A,00000000000,2*26
";
/// Position of the same vessel, 366123460, in second 14 of a minute.
const OF_STATIC: &str = "!AIVDO,1,1,,A,15M:Ii?P1@Org5PM1K00I0FMP000,0*73\n";
/// 2016-01-12 13:02:11 by a base station.
const BASE: &str = "!AIVDO,1,1,,A,402=VPAv0F=2;OsK20LW3P000000,0*51\n";

fn log(text: &str) -> Log {
    parse(text.as_bytes()).unwrap()
}

fn refused(text: &str) -> String {
    parse(text.as_bytes()).unwrap_err().to_string()
}

/// Equal to half of the last digit that AIS has.
fn near(report: &Report, [lat_deg, lon_deg, course_deg, knots]: [f64; 4]) {
    assert!((report.lat_deg - lat_deg).abs() < 1e-6 && (report.lon_deg - lon_deg).abs() < 1e-6, "{report:?}");
    assert!((report.course_deg.unwrap() - course_deg).abs() < 1e-9, "{report:?}");
    assert!((report.speed_mps.unwrap() - knots * KNOT_MPS).abs() < 1e-9, "{report:?}");
}

#[test]
fn sentences_with_tag_blocks_are_read() {
    // The second is a report that libraries of AIS decode in their manuals; here with the time appended.
    let appended = "!AIVDM,1,1,,A,15RTgt0PAso;90TKcjM8h6g208CQ,0*4A,r003669976,1714564801\n";
    let found = log(&format!("$GPGGA,1*00\n{TAGGED}{appended}"));
    assert!(found.passed_over.is_nothing(), "{}", found.passed_over);
    let [first, second] = &found.reports[..] else { panic!("{found:?}") };
    assert_eq!((first.mmsi, second.mmsi), (211_000_001, 371_798_000));
    near(first, [54.0002, 10.0003, 45.0, 10.0]);
    near(second, [48.381633, -123.395383, 224.0, 12.3]);
    assert_eq!(first.time, TimeTag::from_iso8601("2024-05-01T12:00:00Z").unwrap());
    assert_eq!(second.time.since(first.time), 1.0);
    // Milliseconds, lines that end in CR alone, and a station before the time.
    let milliseconds = TAGGED.replace("\\c:1714564800*55", "\\s:x,c:1714564800500*7D").replace('\n', "\r");
    assert_eq!(log(&milliseconds).reports[0].time.since(first.time), 0.5);
}

#[test]
fn class_b_sizes_and_base_stations_are_read() {
    let class_b = "!AIVDO,1,1,,A,B5M:Ih00BovgKh7@`E2aV78P0000,0*12\n";
    let part_b = "!AIVDO,1,1,,A,H5M:Ih4U000000000000002P:450,0*07\n";
    let extended = "!AIVDO,1,1,,A,C5M:Ih@3wov`707@;23Q3w`P0000000000000000000000h1Q100,0*2F\n";
    let found = log(&format!("{class_b}{BASE}{STATIC}{class_b}{part_b}{extended}{OF_STATIC}"));
    // The first has no time yet.
    assert_eq!((found.passed_over.without_time, found.passed_over.without_motion), (1, 1));
    let [class_b, extended, class_a] = &found.reports[..] else { panic!("{found:?}") };
    near(class_b, [50.75, -1.1, 271.3, 7.5]);
    assert_eq!((class_b.mmsi, class_b.size_m), (366_123_456, [Some(30.0), Some(9.0), None]));
    // Speed 102.3 and course 360 are not available.
    assert_eq!((extended.course_deg, extended.speed_mps), (None, None));
    assert_eq!(extended.size_m, [Some(15.0), Some(4.0), None]);
    near(class_a, [50.72, -1.15, 10.0, 8.0]);
    assert_eq!(class_a.size_m, [Some(140.0), Some(22.0), Some(7.3)]);
    // Second 17 after 11, second 14.
    let base = TimeTag::from_iso8601("2016-01-12T13:02:11Z").unwrap();
    assert_eq!([class_b, class_a].map(|report| report.time.since(base)), [6.0, 3.0]);
}

#[test]
fn the_second_of_a_report_is_the_nearest() {
    let clock = TimeTag::from_iso8601("2016-01-12T13:02:11Z").unwrap();
    for (second, off_s) in [(11, 0.0), (40, 29.0), (42, -29.0), (59, -12.0), (0, -11.0), (60, 0.0), (63, 0.0)]
    {
        assert_eq!(sentences::nearest(clock, second).since(clock), off_s, "second {second}");
    }
}

#[test]
fn what_is_damaged_or_says_nothing_is_counted() {
    // Position 91, 181; then speed 102.2.
    let silent = "!AIVDO,1,1,,A,15M:IhwP0N<tSF0l4Q@0I?wqP000,0*2B\n";
    let fast = "!AIVDO,1,1,,A,15M:IhgP?vOrPL0M0d8>4?wqP000,0*6B\n";
    let wrong = TAGGED.replace("*22", "*23");
    let cut = "!AIVDM,1,1,,A,139>Jh@P1T0,0*44\n";
    let found = log(&format!("{BASE}{silent}{fast}{wrong}{TAGGED}{cut}"));
    assert_eq!(found.reports.len(), 2);
    let PassedOver { without_position, without_motion, damaged, without_time } = found.passed_over;
    assert_eq!((without_position, without_motion, damaged, without_time), (1, 1, 2, 0));
    assert_eq!(found.passed_over.to_string(), "1 without a position, 1 without course or speed, 2 damaged");
}

#[test]
fn sentences_without_a_report_are_refused_with_the_remedy() {
    let text = refused(OF_STATIC);
    assert!(text.contains("among 1 AIS messages, 1 without a time; allowed: times in tag blocks"), "{text}");
    let text = refused(&TAGGED.replace("*22", "*23"));
    assert!(text.contains("among 0 AIS messages, 1 damaged"), "{text}");
    // The time of a tag block with a wrong checksum is none.
    let text = refused(&TAGGED.replace("*55", "*54"));
    assert!(text.contains("1 without a time"), "{text}");
}

/// The layouts of two offices that publish logs, old and new, with commas in quotes.
#[test]
fn public_tables_are_read() {
    let marine = "MMSI,BaseDateTime,LAT,LON,SOG,COG,Heading,VesselName,IMO,Length,Width,Draft
211000001,2024-05-01T12:00:00,54.0002,10.0003,10.0,45.0,511.0,\"EXAMPLE, THE\",IMO1,120,20,6.1
211000002,2024-05-01T12:00:01,54.0002,10.0003,,,511.0,,,,,
";
    let newer = "mmsi,base_date_time,longitude,latitude,sog,cog,heading,length,width,draft
211000001,2024-05-01 12:00:00,10.0003,54.0002,10.0,45.0,511,120,20,6.1
";
    let danish = "# Timestamp,Type of mobile,MMSI,Latitude,Longitude,SOG,COG,Heading,Width,Length,Draught
01/05/2024 12:00:00,Class A,211000001,54.0002,10.0003,10.0,45.0,45,20,120,6.1
01/05/2024 12:00:01,Base Station,2190067,55.0,10.0,,,,,,
";
    for (text, passed_over) in [(marine, 1), (newer, 0), (danish, 1)] {
        let found = log(text);
        let report = &found.reports[0];
        near(report, [54.0002, 10.0003, 45.0, 10.0]);
        assert_eq!(report.time, TimeTag::from_iso8601("2024-05-01T12:00:00Z").unwrap());
        assert_eq!(report.size_m, [Some(120.0), Some(20.0), Some(6.1)]);
        assert_eq!(found.passed_over.without_motion, passed_over);
    }
}

/// Every value that AIS declares to be none, each alone in a row.
#[test]
fn an_unknown_value_costs_its_row() {
    let header = "Time,MMSI,Latitude_degrees,Longitude_degrees,COG_degrees,SOG_knots,Length_metres\n";
    let sound = "2024-05-01 12:00:00,211000001,54.0,10.0,45.0,10.0,120\n";
    for (from, to, position) in [
        ("54.0", "91", false),
        ("54.0", "", false),
        ("10.0,45", "181,45", false),
        ("211000001", "", false),
        ("211000001", "2110000010", false),
        ("45.0", "360", true),
        ("45.0", "511.0", true),
        ("45.0", "-12.5", true),
        ("45.0", "", true),
        ("10.0,120", "102.2,120", true),
        ("10.0,120", "102.3,120", true),
        ("10.0,120", ",120", true),
    ] {
        let found = log(&format!("{header}{sound}{}", sound.replacen(from, to, 1)));
        let (reports, PassedOver { without_position, without_motion, .. }) =
            (found.reports.len(), found.passed_over);
        let expected = if position { (2, 0, 1) } else { (1, 1, 0) };
        assert_eq!((reports, without_position, without_motion), expected, "{from} -> {to}");
    }
    for size in ["0", "", "1200", "-1"] {
        let found = log(&format!("{header}{}", sound.replace(",120", &format!(",{size}"))));
        assert_eq!((found.reports[0].size_m[0], found.passed_over.is_nothing()), (None, true), "{size}");
    }
}

/// Every byte of a log replaced by others: it is read or refused, and what is read is on earth.
#[test]
fn garbled_sentences_never_panic() {
    let whole = format!("{BASE}{STATIC}{OF_STATIC}{TAGGED}").into_bytes();
    for at in 0..whole.len() {
        for with in [b'!', b'\\', b'*', b',', b'9', b'w', b'\n', 0, 0xff] {
            let mut garbled = whole.clone();
            garbled[at] = with;
            let reports = parse(&garbled).map(|log| log.reports).unwrap_or_default();
            assert!(reports.iter().all(|r| r.lat_deg.abs() <= 90.0 && r.lon_deg.abs() <= 180.0));
        }
        let _ = parse(&whole[..at]);
    }
    for time in ["0", "-5", "99999999999999999999", "9223372036854775807", "7258118400", "999999999999"] {
        let tag = format!("c:{time}");
        let sum = tag.bytes().fold(0, |sum, byte| sum ^ byte);
        let text = TAGGED.replace("c:1714564800*55", &format!("{tag}*{sum:02X}"));
        assert_eq!(parse(text.as_bytes()).is_ok(), time == "999999999999", "{time}");
    }
}
