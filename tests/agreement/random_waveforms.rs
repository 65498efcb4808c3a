//! What random scenes radiate: often a linear sweep, else one of the other kinds of about its band and
//! length.

use super::random_scene::{Draw, Geometry, Signal};

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
