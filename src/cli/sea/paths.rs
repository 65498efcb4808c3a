//! `nereus snapshot --paths`: the scatterer paths within the receive window of a pulse, as the reference echo
//! takes them.

use super::super::error::CliError;
use super::SeaError;
use crate::config::Run;
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::pipeline::stages::PulseFactory;
use crate::recording::field_file::Attribute;
use crate::recording::output::Output;
use crate::recording::path_file::PathFile;
use crate::scene::radar::{Sweep, Waveform};

/// Writes the file; returns how many scatterer paths it holds.
pub(super) fn write(
    output: Output,
    run: &Run,
    factory: &PulseFactory,
    index: u64,
) -> Result<usize, CliError> {
    let (pulse, paths) =
        factory.scatterer_paths(index).map_err(|error| BuildErrors::from(BuildError::Radar(error)))?;
    let radar = &run.scene.radar;
    let pair = |pair: &crate::scene::radar::Pair| {
        let (tx, rx) = (&radar.transmitters[pair.transmitter].name, &radar.receivers[pair.receiver].name);
        format!("{tx}/{rx}")
    };
    let pairs: Vec<String> = radar.pairs().iter().map(pair).collect();
    let channels: Vec<String> = radar.channels.iter().map(|channel| channel.name.clone()).collect();
    let software = format!("nereus {}", env!("CARGO_PKG_VERSION"));
    let mut attributes = vec![
        ("software", Attribute::Text(&software)),
        ("config", Attribute::Text(&run.text)),
        ("seed", Attribute::Whole(run.scene.seed)),
        ("pulse", Attribute::Whole(index)),
        ("carrier_hz", Attribute::Real(radar.carrier_hz)),
        ("sample_rate_hz", Attribute::Real(radar.sample_rate_hz)),
        ("prf_hz", Attribute::Real(radar.emissions.mean_prf_hz())),
        ("window_start_s", Attribute::Real(pulse.window_start_s)),
        ("samples", Attribute::Whole(radar.window.samples as u64)),
    ];
    match &radar.waveform {
        Waveform::Lfm { bandwidth_hz, duration_s, sweep } => attributes.extend([
            ("waveform", Attribute::Text("lfm")),
            ("bandwidth_hz", Attribute::Real(*bandwidth_hz)),
            ("pulse_s", Attribute::Real(*duration_s)),
            ("sweep", Attribute::Text(if matches!(sweep, Sweep::Up) { "up" } else { "down" })),
        ]),
        Waveform::Samples { rate_hz, .. } => attributes.extend([
            ("waveform", Attribute::Text("samples")),
            ("waveform_rate_hz", Attribute::Real(*rate_hz)),
        ]),
    }
    let file = PathFile {
        attributes: &attributes,
        pairs: &pairs,
        channels: &channels,
        channel_pairs: factory.channel_pairs(),
        paths: &paths,
    };
    output.write(|partial| Ok::<_, SeaError>(file.write(partial)?))?;
    Ok(paths.len())
}
