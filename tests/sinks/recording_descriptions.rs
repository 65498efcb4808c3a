//! The words for every dataset: in both kinds of recordings, in merged ones, and on the page.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use nereus::pulse::SampleFormat;
use nereus::pulse::log::{Entry, Log, Origin};
use nereus::recording::descriptions::{DESCRIPTIONS, Description};
use nereus::recording::header::Header;
use nereus::recording::instrument::Look;
use nereus::sinks::plain::PlainSink;
use nereus::sinks::sink::Sink;

use crate::recording_fixture::{header, instrument, pulse, python};

/// A header that has everything a recording may have.
fn full(format: SampleFormat) -> Header {
    let log = Log::default();
    let text = "clear".to_owned();
    log.enter(Entry { pulse: 1, time_ns: 0, platform: "tower".into(), text, origin: Origin::Control });
    let mut instrument = instrument();
    // Its transmitter scans, and its receiver has a window of its own.
    let sector_deg = [-30.0, 30.0];
    instrument.antennas[0].look =
        Look::Scan { level: false, rate_deg_per_s: 60.0, sector_deg, elevation_deg: 0.0 };
    let mut full = Header { changes: Some(Arc::new(log)), instrument: Some(instrument), ..header(format) };
    full.layout.windows = 1;
    full
}

/// The path of a dataset of the fixture as the table has it.
fn pattern(path: &str) -> String {
    let parts = path.trim_start_matches('/').split('/').map(|part| match part {
        "tower" | "aircraft" => "<platform>",
        "mast" | "pod" | "tx" => "<antenna>",
        part => part,
    });
    parts.collect::<Vec<_>>().join("/")
}

/// The row of a dataset. Of the two rows of the samples the words decide.
fn row(path: &str, words: [&str; 4]) -> &'static Description {
    let own =
        |of: &&Description| of.path == pattern(path) && [of.description, of.unit, of.axes, of.frame] == words;
    DESCRIPTIONS.iter().find(own).unwrap_or_else(|| panic!("{path}: no row has {words:?}"))
}

fn page() -> String {
    fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/recording.md")).unwrap()
}

/// A section of the page.
fn section<'a>(page: &'a str, title: &str) -> &'a str {
    let (_, rest) =
        page.split_once(&format!("\n## {title}\n")).unwrap_or_else(|| panic!("no section {title}"));
    rest.split("\n## ").next().unwrap()
}

/// What stands between backticks in the first cell of the rows of a table.
#[cfg(feature = "hdf5")]
fn listed(section: &str) -> BTreeSet<String> {
    let names = section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    names.map(str::to_owned).collect()
}

/// Runs the block of Python on the page that has these words, for a recording in place of `named`; its `iq`
/// are the samples.
fn run_block(page: &str, words: &str, named: &str, path: &Path) {
    let blocks = page.split("```python\n").skip(1).filter_map(|rest| rest.split("```").next());
    let block = blocks.into_iter().find(|block| block.contains(words)).unwrap();
    let path = format!("{:?}", path.to_str().unwrap());
    assert!(block.contains(named) && block.lines().count() <= 12, "{block}");
    let check = "np.testing.assert_allclose(iq, reader.open_recording(PATH).samples(), rtol=1e-6)\n";
    python(words == "h5py", &format!("{}\n{}", block.replace(named, &path), check.replace("PATH", &path)));
}

#[test]
fn the_page_has_the_table_of_the_code() {
    let want: Vec<String> = DESCRIPTIONS
        .iter()
        .map(|of| {
            let Description { path, axes, unit, frame, description, .. } = of;
            format!("| `/{path}` | {} | {axes} | {unit} | {frame} | {description} |", of.type_name())
        })
        .collect();
    let page = page();
    let found: Vec<&str> = page.lines().filter(|line| line.starts_with("| `/")).collect();
    assert!(found == want, "docs/recording.md should have these rows, and no other:\n{}", want.join("\n"));
}

#[test]
fn a_plain_recording_has_the_words_of_every_file() {
    for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rec");
        let header = full(format);
        let mut sink = Box::new(PlainSink::create(&path, false, &header).unwrap());
        sink.write(&pulse(&header, 0)).unwrap();
        sink.finish().unwrap();
        let meta: Value = serde_json::from_slice(&fs::read(path.join("meta.json")).unwrap()).unwrap();

        let mut rows = BTreeSet::new();
        for entries in ["columns", "descriptions"] {
            for (name, entry) in meta[entries].as_object().unwrap() {
                let word = |key: &str| entry[key].as_str().unwrap_or_else(|| panic!("{name}: {key}"));
                // Codes are pairs: an axis more than in HDF5.
                let axes = word("axes").trim_end_matches(", in-phase and quadrature");
                assert_eq!(axes == word("axes"), name != "iq" || format == SampleFormat::Cf32);
                let of = row(name, [word("description"), word("unit"), axes, word("frame")]);
                rows.insert(of.description);
                if entries == "columns" {
                    let beside_pulses = entry["shape"].as_array().unwrap().len();
                    assert_eq!(word("axes").split(", ").count(), 1 + beside_pulses, "{name}");
                }
            }
        }
        let other = DESCRIPTIONS.iter().map(|of| of.description).filter(|of| !rows.contains(of));
        assert_eq!(other.count(), 1, "all but the row of the other kind of samples");

        // Every key of the file is on the page.
        let page = page();
        let text = [section(&page, "Attributes of the file"), section(&page, "Plain folders")].concat();
        for key in meta.as_object().unwrap().keys() {
            assert!(text.contains(&format!("`{key}`")), "docs/recording.md lacks {key} of meta.json");
        }
        run_block(&page, "meta.json", "\"rec\"", &path);
    }
}

#[cfg(feature = "hdf5")]
mod hdf5_files {
    use super::*;
    use crate::recording_fixture::verified;
    use crate::recording_hdf5::record;
    use hdf5::types::VarLenUnicode;
    use hdf5::{Dataset, File, Group};
    use nereus::recording::merge::merge;

    fn datasets(group: &Group, list: &mut Vec<Dataset>) {
        list.extend(group.datasets().unwrap());
        group.groups().unwrap().iter().for_each(|inner| datasets(inner, list));
    }

    fn all(file: &File) -> Vec<Dataset> {
        let mut list = Vec::new();
        datasets(file, &mut list);
        list
    }

    const NAMES: [&str; 4] = ["description", "unit", "axes", "frame"];

    /// Every dataset has its row, and beside the words only the converter's attributes; the rows there are.
    fn rows(path: &Path) -> BTreeSet<&'static str> {
        let file = File::open(path).unwrap();
        let rows = all(&file).into_iter().map(|dataset| {
            let name = dataset.name();
            let words = NAMES.map(|attribute| {
                let attribute =
                    dataset.attr(attribute).unwrap_or_else(|_| panic!("{name} lacks {attribute}"));
                attribute.read_scalar::<VarLenUnicode>().unwrap().to_string()
            });
            let of = row(&name, words.each_ref().map(String::as_str));
            assert_eq!(of.axes.split(", ").count(), dataset.ndim(), "{name}");
            let dtype = format!("{:?}", dataset.dtype().unwrap().to_descriptor().unwrap());
            let want = match of.type_name() {
                "uint8" => "Unsigned(U1)",
                "uint32" => "Unsigned(U4)",
                "uint64" => "Unsigned(U8)",
                "int64" => "Integer(U8)",
                "float64" => "Float(U8)",
                "text" => "VarLenUnicode",
                _ => "Compound",
            };
            assert!(dtype.starts_with(want), "{name} is {dtype}, not {}", of.type_name());
            let mut others = dataset.attr_names().unwrap();
            others.retain(|attribute| !NAMES.contains(&attribute.as_str()));
            others.sort();
            let codes = of.unit == "code" && of.path == "iq";
            assert_eq!(others, if codes { vec!["adc_bits", "adc_step"] } else { vec![] }, "{name}");
            of.description
        });
        rows.collect()
    }

    #[test]
    fn every_dataset_has_its_row_and_every_row_its_dataset() {
        let mut found = BTreeSet::new();
        for format in [SampleFormat::Cf32, SampleFormat::Ci16] {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("rec.h5");
            let header = full(format);
            record(&path, None, &header, 0, 3);
            found.extend(rows(&path));
            let words = "import subprocess\nout = subprocess.run([sys.executable, reader.__file__, PATH], \
                         capture_output=True, text=True, check=True).stdout\n\
                         assert '/nav/pod/boresight_quat [3, 4]: 1, pulse, w-x-y-z' in out, out\n\
                         rec = reader.open_recording(PATH)\n\
                         assert rec.words('truth/delay_s')['unit'] == 's' and 'unit' not in rec.meta";
            python(true, &words.replace("PATH", &format!("{:?}", path.to_str().unwrap())));
        }
        let missing: Vec<_> = DESCRIPTIONS.iter().filter(|of| !found.contains(of.description)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn parts_with_and_without_words_become_a_whole_with_them() {
        let dir = tempfile::tempdir().unwrap();
        let parts: Vec<_> = [(0, 20), (20, 50)]
            .map(|(from, to)| {
                let path = dir.path().join(format!("{from}.h5"));
                let header = Header { first_pulse: from, pulses: to - from, ..full(SampleFormat::Cf32) };
                record(&path, None, &header, from, to);
                path
            })
            .into();
        let want = rows(&parts[0]);
        // As a program before these attributes has made it.
        let older = File::open_rw(&parts[1]).unwrap();
        for dataset in all(&older) {
            NAMES.iter().for_each(|attribute| dataset.delete_attr(attribute).unwrap());
        }
        older.close().unwrap();
        let out = dir.path().join("whole.h5");
        assert_eq!(merge(&parts, &out, false).unwrap().pulses, 50);
        assert_eq!(rows(&out), want);
        for path in parts.iter().chain([&out]) {
            let verdict = verified(path);
            assert!(verdict.whole, "{verdict:?}");
            assert_eq!(verdict.pulses, verdict.asked);
        }
    }

    #[test]
    fn the_page_lists_every_attribute_of_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let header = full(SampleFormat::Cf32);
        // A second segment of a shard, and one as received over the wire.
        let header = Header { shard: "1/2".parse().ok(), ..header };
        let segments = record(&dir.path().join("s.h5"), Some(0.1), &header, 0, 40).files;
        let received = dir.path().join("received.h5");
        record(&received, None, &Header { truth: false, ..header }, 0, 1);
        let found: BTreeSet<String> = [&segments[1], &received]
            .into_iter()
            .flat_map(|path| File::open(path).unwrap().attr_names().unwrap())
            .collect();
        let page = page();
        assert_eq!(listed(section(&page, "Attributes of the file")), found);

        let codes = dir.path().join("codes.h5");
        record(&codes, None, &full(SampleFormat::Ci16), 0, 3);
        for path in [&segments[1], &received, &codes] {
            run_block(&page, "h5py", "\"rec.h5\"", path);
        }
    }
}
