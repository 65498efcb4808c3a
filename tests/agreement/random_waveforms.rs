//! What random scenes radiate: often a linear sweep, else one of the other kinds of about its band and
//! length.

use super::random_scene::{Draw, Geometry, Signal};
use super::random_scenes::variable;

/// Now and then the delay of a reference that echoes are dechirped by, s, near the patch, and a lower rate at
/// which they are sampled: some of their beats are filtered away, or nearly all.
pub(super) fn dechirp(draw: &mut Draw, geometry: &Geometry, signal: &mut Signal) -> Option<f64> {
    if !draw.chance(0.12) {
        return None;
    }
    let window_s = signal.samples as f64 / signal.rate_hz;
    let slower = draw.log(1.0, 12.0);
    signal.rate_hz /= slower;
    signal.samples = ((window_s * signal.rate_hz) as u64).max(16);
    let [nearest_s, farthest_s] = geometry.delays_s();
    // As the pulse that the window is for left before its own.
    let late_s = (nearest_s - signal.opens_s).max(0.0);
    Some((draw.between(nearest_s, farthest_s) - late_s).max(0.0))
}

/// The keys of a waveform, separated as those of a table in one line: `sweep` as they are for a linear sweep.
pub(super) fn waveform(draw: &mut Draw, sweep: String, bandwidth_hz: f64, pulse_s: f64) -> Vec<String> {
    let product = bandwidth_hz * pulse_s;
    let text = |keys: &[String]| keys.to_vec();
    match draw.one(&["lfm", "lfm", "lfm", "triangular", "cw", "nlfm", "code", "code"]) {
        "triangular" => {
            let sweep = sweep.replace("\"down\"", "\"up\"").replace("\"up\"", "\"triangular\"");
            text(&["kind = \"lfm\"".to_owned(), sweep])
        }
        "cw" => text(&["kind = \"cw\"".to_owned(), format!("pulse_s = {pulse_s:?}")]),
        "nlfm" if (4.0..=20_000.0).contains(&product) => {
            let taper = match draw.chance(0.3) {
                true => "taper = \"hamming\"".to_owned(),
                false => format!("sidelobe_db = {:?}", draw.between(20.0, 60.0)),
            };
            text(&["kind = \"nlfm\"".to_owned(), sweep, taper])
        }
        "code" if product >= 2.0 => {
            let chips = (product as usize).min(65_536);
            let root = chips.isqrt();
            let barker = [13, 11, 7, 5, 4, 3, 2].into_iter().find(|count| *count <= chips).unwrap_or(2);
            let register = usize::BITS - 1 - (chips + 1).leading_zeros();
            let (keys, count) = match draw.one(&["barker", "frank", "p3", "p4", "m-sequence"]) {
                "frank" if root >= 2 => (format!("code = \"frank\", chips = {}", root * root), root * root),
                "m-sequence" if register >= 2 => {
                    (format!("code = \"m-sequence\", register = {register}"), (1 << register) - 1)
                }
                code @ ("p3" | "p4") => (format!("code = \"{code}\", chips = {chips}"), chips),
                _ => (format!("code = \"barker\", chips = {barker}"), barker),
            };
            // No shorter than a sample, so that as long or shorter than what windows were drawn for.
            let chip_s = if draw.chance(0.5) { pulse_s / count as f64 } else { 1.0 / bandwidth_hz };
            let keys = keys.split(", ").map(str::to_owned);
            let kind = ["kind = \"phase-code\"".to_owned(), format!("chip_s = {chip_s:?}")];
            kind.into_iter().chain(keys).collect()
        }
        _ => text(&["kind = \"lfm\"".to_owned(), sweep]),
    }
}

/// Whether something radiates a continuous signal; the variable `NEREUS_STREAMS` makes it so in every scene
/// that may have one.
fn streams(draw: &mut Draw, share: f64) -> bool {
    draw.chance(share) || variable("NEREUS_STREAMS", 0) > 0
}

/// A bandwidth, Hz, and segments a second of a signal at a sample rate, short enough for a reference.
fn segments(draw: &mut Draw, rate_hz: f64) -> [f64; 2] {
    let samples = draw.log(100.0, 1500.0);
    [draw.log(70.0 / samples, 1.0) * rate_hz, rate_hz / samples]
}

/// The keys of a signal of about this bandwidth, each in a line, and segments a second: mostly noise, else a
/// recording, or a code or a broadcast whose segments are long enough.
fn signal(rate_hz: f64, [bandwidth_hz, prf_hz]: [f64; 2]) -> (String, f64) {
    // Chosen by what was drawn, so that nothing else is drawn otherwise.
    let choice = (bandwidth_hz * 1e3) as u64 % 8;
    let [code_hz, broadcast_hz] = [10.23e6, 312.5e3].map(|hz: f64| prf_hz.min(hz / 70.0));
    match choice {
        0 | 1 => {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/iq/noise.cs8");
            (format!("kind = \"iq-file\"\npath = {path:?}\nrate_hz = {bandwidth_hz:?}"), prf_hz)
        }
        2 if rate_hz > 1.1e6 && rate_hz < 3000.0 * code_hz => {
            (format!("kind = \"gps-l1-ca\"\nprn = {}", 1 + choice), code_hz)
        }
        3 if rate_hz > 300e3 && rate_hz < 3000.0 * broadcast_hz => ("kind = \"fm\"".to_owned(), broadcast_hz),
        _ => (format!("kind = \"noise\"\nbandwidth_hz = {bandwidth_hz:?}"), prf_hz),
    }
}

/// Now and then a continuous signal in place of an emitter's waveform: its keys, and segments a second.
pub(super) fn endless(draw: &mut Draw, rate_hz: f64) -> Option<(String, f64)> {
    streams(draw, 0.25).then(|| {
        let (keys, prf_hz) = signal(rate_hz, segments(draw, rate_hz));
        (keys.replace('\n', ", "), prf_hz)
    })
}

/// Now and then a continuous signal of a radar that receives continuously in place of its pulses and
/// windows, for as few samples as its reference can make.
pub(super) fn continuous(
    draw: &mut Draw,
    (geometry, signal): (&Geometry, &Signal),
    text: &str,
) -> Option<String> {
    let refused = ["rain_clutter", "[sea.far]", "window = {", "[radar.dechirp]"];
    if !streams(draw, 0.06) || refused.iter().any(|keys| text.contains(keys)) {
        return None;
    }
    let samples = draw.log(300.0, 2000.0) as u64;
    let (keys, prf_hz) = self::signal(signal.rate_hz, segments(draw, signal.rate_hz));
    let block_s = samples as f64 / signal.rate_hz;
    // The first echo comes late.
    let lasts_s = geometry.delays_s()[1] + 11.5 * block_s;
    let (mut table, mut out) = (String::new(), Vec::new());
    for line in text.lines() {
        if line.starts_with('[') {
            table = line.to_owned();
            match line {
                "[radar.waveform]" => {
                    out.push(format!("{line}\n{keys}"));
                }
                "[radar.window]" => out.push(format!("{line}\ngate = \"continuous\"\nsamples = {samples}")),
                _ => out.push(line.to_owned()),
            }
            continue;
        }
        let key = line.split(" = ").next().unwrap_or_default();
        match (table.as_str(), key) {
            ("[radar.waveform]" | "[radar.window]", _) => {}
            ("[radar]", "prf_hz" | "pri_us") => out.push(format!("prf_hz = {prf_hz:?}")),
            ("[scene]", "duration_s") => out.push(format!("duration_s = {lasts_s:?}")),
            _ => out.push(line.to_owned()),
        }
    }
    Some(out.join("\n") + "\n")
}

/// Now and then several pulses in turn in place of the radar's one, where windows receive no other emission:
/// its own, of these the other sweep, shorter ones, at other frequencies; the variable `NEREUS_IN_TURN` makes
/// it so wherever it can be.
pub(super) fn in_turn(
    draw: &mut Draw,
    (geometry, signal): (&Geometry, &Signal),
    text: &str,
) -> Option<String> {
    let wanted = draw.chance(0.12) || variable("NEREUS_IN_TURN", 0) > 0;
    let window_s = signal.samples as f64 / signal.rate_hz;
    let latest_s = geometry.delays_s()[1].max(signal.opens_s) + window_s + signal.pulse_s;
    if !wanted || text.contains("[radar.dechirp]") || latest_s > 0.4 / geometry.prf_hz {
        return None;
    }
    let (before, after) = text.split_once("[radar.waveform]\n")?;
    let (keys, after) = after.split_once("\n[")?;
    let own = keys.trim().replace('\n', ", ");
    let free_hz = 0.45 * (signal.rate_hz - signal.bandwidth_hz);
    let other = |draw: &mut Draw| match draw.one(&["sweep", "sweep", "short", "offset", "own"]) {
        "sweep" if own.contains("\"up\"") => own.replace("\"up\"", "\"down\""),
        "sweep" if own.contains("\"down\"") => own.replace("\"down\"", "\"up\""),
        "offset" if free_hz > 0.0 && !own.contains("phase-code") && !own.contains("\"cw\"") => {
            format!("{own}, offset_hz = {:?}", free_hz * draw.between(-1.0, 1.0))
        }
        "own" => own.clone(),
        _ => format!("kind = \"cw\", pulse_s = {:?}", signal.pulse_s * draw.log(0.1, 1.0)),
    };
    let mut pulses = vec![own.clone()];
    pulses.extend((0..draw.one(&[1, 1, 2, 4, 11])).map(|_| other(draw)));
    let keys = match draw.chance(0.25) && free_hz > 0.0 {
        true => {
            let steps = draw.one(&[2, 5, 16]);
            let step_hz = 2.0 * free_hz / f64::from(steps) * draw.one(&[-1.0, 1.0]);
            format!(
                "kind = \"stepped\"\nsteps = {steps}\nstep_hz = {step_hz:?}\npulse_s = {:?}",
                signal.pulse_s
            )
        }
        false => format!("kind = \"in-turn\"\nwaveforms = [{{ {} }}]", pulses.join(" }, { ")),
    };
    Some(format!("{before}[radar.waveform]\n{keys}\n[{after}"))
}
