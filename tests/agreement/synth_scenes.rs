//! Scatterer paths of radars and facets in straight motion, for the fast echo and its reference.

use std::sync::Arc;

use nereus::echo::reference::ReferenceEcho;
use nereus::echo::synth::block::{BlockPaths, Node};
use nereus::echo::synth::{Scalar, Settings, Synth};
use nereus::paths::list::ScattererPaths;
use nereus::radar::waveform::{Lfm, Waveform};
use nereus::scene::radar::Sweep;
use nereus::units::SPEED_OF_LIGHT_MPS as C;
use num_complex::Complex64;

/// Numbers in `[-1, 1)`: the upper bits of a linear congruence.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[derive(Clone, Copy)]
pub struct End {
    pub position_m: [f64; 3],
    pub velocity_mps: [f64; 3],
}

/// A radar over a patch of facets.
#[derive(Clone)]
pub struct Patch {
    pub name: &'static str,
    pub ends: [End; 2],
    pub carrier_hz: f64,
    pub bandwidth_hz: f64,
    pub pulse_s: f64,
    pub rate_hz: f64,
    pub prf_hz: f64,
    pub samples: usize,
    pub side_m: f64,
}

/// The paper's aircraft; two aircraft head on to the scene (14.8 kHz); a satellite at 800 km, `B Tc = 1000`.
pub fn patches() -> [Patch; 3] {
    let aircraft = End { position_m: [-250.0, -3000.0, 3000.0], velocity_mps: [222.0, 0.0, 0.0] };
    let airborne = Patch {
        name: "airborne",
        ends: [aircraft; 2],
        carrier_hz: 10e9,
        bandwidth_hz: 60e6,
        pulse_s: 0.333e-6,
        rate_hz: 100e6,
        prf_hz: 222.0,
        samples: 400,
        side_m: 512.0,
    };
    let ahead = End { position_m: [0.0, -30e3, 300.0], velocity_mps: [0.0, 222.0, 0.0] };
    let above = End { position_m: [3e3, -28e3, 600.0], velocity_mps: [0.0, 222.0, -5.0] };
    let satellite = End { position_m: [-2e3, -120e3, 800e3], velocity_mps: [7500.0, 0.0, 0.0] };
    [
        airborne.clone(),
        Patch { name: "two aircraft", ends: [ahead, above], samples: 600, ..airborne.clone() },
        Patch {
            name: "spaceborne",
            ends: [satellite; 2],
            pulse_s: 1000.0 / 60e6,
            prf_hz: 1500.0,
            samples: 300,
            ..airborne
        },
    ]
}

impl Patch {
    pub fn waveform(&self) -> Arc<dyn Waveform> {
        Arc::new(Lfm::new(self.bandwidth_hz, self.pulse_s, Sweep::Up).unwrap())
    }

    pub fn reference(&self, channel_pairs: &[usize]) -> ReferenceEcho {
        ReferenceEcho::new(
            self.waveform(),
            self.carrier_hz,
            self.rate_hz,
            self.samples,
            channel_pairs.to_vec(),
        )
    }

    pub fn synth<T: Scalar>(&self, channel_pairs: &[usize], settings: Settings) -> Synth<T> {
        Synth::new(self.waveform(), self.carrier_hz, self.rate_hz, self.samples, channel_pairs, settings)
            .unwrap()
    }

    fn delay_s(&self, facet_m: [f64; 3], t_s: f64) -> f64 {
        let leg = |end: End| {
            (0..3)
                .map(|i| (end.position_m[i] + end.velocity_mps[i] * t_s - facet_m[i]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        (leg(self.ends[0]) + leg(self.ends[1])) / C
    }

    /// Start of the window of a pulse: follows the nearest corner, with a step of its own.
    pub fn window_s(&self, pulse: usize) -> f64 {
        let half = 0.5 * self.side_m;
        self.delay_s([0.0, -half, 0.0], pulse as f64 / self.prf_hz) - 0.3e-6 - 1.3e-8 * pulse as f64
    }

    /// `count` facets on pulse `pulse`; pair `p` sees them `p` times 40 m farther. Amplitudes change
    /// linearly.
    pub fn paths(&self, count: usize, pairs: usize, channels: usize, pulse: usize) -> ScattererPaths {
        let mut numbers = Numbers(77);
        let t_s = pulse as f64 / self.prf_hz;
        let mut paths = ScattererPaths::new(pairs, channels, count);
        for _ in 0..count {
            let half = 0.5 * self.side_m;
            let facet_m = [half * numbers.next(), half * numbers.next(), 2.0 * numbers.next()];
            paths.emission_offset_s.push(0.0);
            for pair in 0..pairs {
                let step_s = 1e-3;
                paths.delay_s[pair].push(self.delay_s(facet_m, t_s) + 80.0 * pair as f64 / C);
                let ahead = self.delay_s(facet_m, t_s + step_s) - self.delay_s(facet_m, t_s - step_s);
                paths.delay_rate[pair].push(ahead / (2.0 * step_s));
            }
            for amplitude in &mut paths.amplitude {
                let [re, im, slope] = [numbers.next(), numbers.next(), numbers.next()];
                amplitude.push(Complex64::new(re, im) * (1.0 + 0.01 * slope * pulse as f64));
            }
        }
        paths
    }

    /// A block of `pulses` from scatterer paths at evenly spread nodes.
    pub fn fill<T: Scalar>(
        &self,
        synth: &Synth<T>,
        pulses: usize,
        at: impl Fn(usize) -> ScattererPaths,
    ) -> BlockPaths<T> {
        let nodes = 4.min(pulses);
        let places: Vec<usize> = (0..nodes).map(|i| i * (pulses - 1) / (nodes - 1).max(1)).collect();
        let lists: Vec<ScattererPaths> = places.iter().map(|p| at(*p)).collect();
        let nodes: Vec<Node<'_>> =
            places.iter().zip(&lists).map(|(pulse, paths)| Node { pulse: *pulse, paths }).collect();
        let windows: Vec<f64> = (0..pulses).map(|p| self.window_s(p)).collect();
        let mut block = synth.block();
        synth.fill(&nodes, &windows, &mut block).unwrap();
        block
    }
}

/// Spectra of the given pulses by the fast echo.
pub fn spectra<T: Scalar>(
    synth: &Synth<T>,
    block: &BlockPaths<T>,
    channels: usize,
    pulses: &[usize],
) -> Vec<Vec<Complex64>> {
    let (mut grids, mut scratch) = (synth.grids(), synth.scratch());
    synth.spread(block, &mut grids);
    pulses
        .iter()
        .map(|pulse| {
            let mut out = vec![Complex64::new(f64::NAN, 0.0); channels * synth.fft_len()];
            synth.spectrum(block, &grids, *pulse, &mut scratch, &mut out);
            out
        })
        .collect()
}

/// Relative rms difference, dB.
pub fn error_db(fast: &[Complex64], exact: &[Complex64]) -> f64 {
    let wrong: f64 = fast.iter().zip(exact).map(|(a, b)| (a - b).norm_sqr()).sum();
    let all: f64 = exact.iter().map(|b| b.norm_sqr()).sum();
    10.0 * (wrong / all).log10()
}
