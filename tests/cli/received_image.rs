//! `nereus run` to `nereus receive --out` to `nereus focus`: the image of a processor behind the wire.

use std::path::Path;

use nereus::focus::{Image, Navigation, Settings};

use crate::program::{nereus, package};
use crate::receive::{listening, stdout};

/// Images of all channels by reported navigation, where the radar looks by the recording.
fn images(path: &Path, size_m: f64, pixel_m: f64) -> Vec<Image> {
    let recording = nereus::Recording::open(path, None).unwrap();
    let mut settings = Settings::default();
    settings.nav = Navigation::Reported;
    settings.size_m = [size_m; 2];
    settings.pixel_m = pixel_m;
    nereus::focus(&recording, &settings).unwrap()
}

/// Some pulses of a scenario, recorded and sent to a receiver that records them; with and without an ADC.
#[test]
fn the_image_of_what_was_received_is_that_of_the_run() {
    let scenario = package().join("configs/mars-4.toml").display().to_string();
    let (sent, got) = if cfg!(feature = "hdf5") { ("sent.h5", "got.h5") } else { ("sent", "got") };
    for more in [&[][..], &["--set", "radar.adc={ bits = 12, full_scale_dbw = -120.0 }"]] {
        let folder = tempfile::tempdir().unwrap();
        let (receiver, address) = listening(folder.path(), &["--pulses", "24", "--out", got, "--json"]);
        let kind = if cfg!(feature = "hdf5") { "hdf5" } else { "plain" };
        let sinks = format!(
            "sink=[{{ kind = 'vita49', address = '{address}' }}, {{ kind = '{kind}', path = '{sent}' }}]"
        );
        // A short run of a small part of the scene, with antennas away from where the navigation is.
        let run = ["run", &scenario, "--pulses", "238..262", "--set", &sinks, "--set", "ship=[]"];
        let small = ["--set", "scene.patch_size_m=[64.0, 64.0]"];
        let arms = ["--set", "receiver.0.lever_arm_m=[1.5, -0.5, 2.0]", "--set", "stream.policy='slip'"];
        let ended = nereus(folder.path(), &[&run[..], &small, &arms, more].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let report: serde_json::Value = serde_json::from_str(&stdout(receiver)).unwrap();
        assert_eq!((&report["pulses"], &report["recorded"]), (&24.into(), &24.into()), "{report}");

        // Of the middle by all pulses; of a wide one by those in whose beam a pixel lies.
        for (size_m, pixel_m, doppler_hz) in [(32.0, 1.0, None), (400.0, 5.0, Some(222.0))] {
            let [own, received] = [sent, got].map(|name| images(&folder.path().join(name), size_m, pixel_m));
            assert_eq!(own.len(), 4);
            for (own, received) in own.iter().zip(&received) {
                assert!(own.values.iter().any(|z| z.norm_sqr() > 0.0));
                assert_eq!(own.doppler_hz, doppler_hz, "{}", own.channel);
                // Bit by bit: samples, states, replica are those that were sent.
                assert!(own == received, "{}, {size_m} m", own.channel);
            }
        }
        // Without a word about navigation the command takes what there is.
        let focused = |arguments: &[&str]| {
            nereus(folder.path(), &[&["focus", got, "--size-m", "16", "--json"], arguments].concat())
        };
        let ended = focused(&[]);
        assert_eq!((ended.code, ended.stderr.as_str()), (0, ""));
        let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        assert_eq!((&report["nav"], &report["pulses"]), (&"reported".into(), &24.into()), "{report}");
        for nav in ["true", "both"] {
            let ended = focused(&["--nav", nav]);
            let words = "holds no true phase centres: it was received over the wire, which carries what platforms \
                         report; allowed: --nav reported";
            assert!(ended.code == 2 && ended.stderr.contains(words), "{}", ended.stderr);
        }
    }
}
