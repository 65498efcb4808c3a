//! Samples of a recording: which are read, and how many may be.

use std::fs;

use nereus::recording::{Recording, RecordingError};
use num_complex::Complex32;

use crate::geometries::{GEOMETRIES, record_and};

/// Samples of a window: blocks of 4 MiB are 32 pulses of 120 then.
const SAMPLES: usize = 4096;
const CHANNELS: usize = 4;

#[test]
fn only_the_channels_asked_for_are_held_and_no_more_than_memory_takes() {
    let scenario = GEOMETRIES[0].scenario("", [[0.0; 3]; 2]).replace("samples = 768", "samples = 4096");
    record_and(&scenario, |path| {
        let bytes = fs::read(path.join("iq.bin")).unwrap();
        // Pulse, channel, sample; two floats each, little-endian.
        let float = |at: usize| f32::from_le_bytes(bytes[4 * at..4 * at + 4].try_into().unwrap());
        let sample = |pulse: usize, channel: usize, i: usize| {
            let at = 2 * ((pulse * CHANNELS + channel) * SAMPLES + i);
            Complex32::new(float(at), float(at + 1))
        };
        let open =
            |most_bytes: Option<u64>, chosen: &[usize]| {
                Recording::open_channels::<RecordingError>(path, Some(5..110), most_bytes, |_| {
                    Ok(chosen.to_vec())
                })
            };
        // Two channels of 105 pulses, 8 bytes a sample.
        let needed = 2 * 105 * SAMPLES as u64 * 8;
        let part = open(Some(needed), &[3, 1]).unwrap();
        assert_eq!(part.channels(), [3, 1]);
        let mut illuminated = 0;
        for pulse in 0..105 {
            for channel in [3, 1] {
                let window = part.window(pulse, channel);
                assert_eq!(window.len(), SAMPLES);
                assert!(window.iter().enumerate().all(|(i, z)| *z == sample(pulse + 5, channel, i)));
                illuminated += window.iter().filter(|z| z.norm() > 0.0).count();
            }
            assert!(part.window(pulse, 0).is_empty() && part.window(pulse, 2).is_empty());
        }
        assert!(illuminated > 0);
        let whole = Recording::open(path, None).unwrap();
        assert_eq!(whole.channels(), [0, 1, 2, 3]);
        assert_eq!(whole.window(5, 3), part.window(0, 3));
        let refused = open(Some(needed - 1), &[3, 1]).err().unwrap();
        assert!(matches!(refused, RecordingError::Memory { channels: 2, pulses: 105, .. }), "{refused}");
        assert!(refused.to_string().contains("--pulses"), "{refused}");
    });
}
