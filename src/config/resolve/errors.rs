//! Errors of a platform's reports, and the turbulence that it flies through.

use crate::config::choices::GustLevel;
use crate::config::error::Problem;
use crate::config::keys::{self, Table};
use crate::config::section::Section;
use crate::frames::Vector;
use crate::motion::errors::preset::Class;
use crate::motion::errors::{ATTITUDE, AxisErrors, Dropouts, ErrorModel, Recorded, VELOCITY};
use crate::motion::gusts::{Gusts, LEVELS_MPS};

/// When steps and noise have no meaning.
const SMOOTH: &str = "recorded = \"reported\": the truth must be smooth";

/// `[platform.errors]`; `has_report`: the platform has a track of its own for what it reports; `live`: its
/// track is live.
pub(super) fn errors(section: Section<'_>, has_report: bool, live: bool) -> Option<ErrorModel> {
    use keys::errors as k;
    let preset = section.choice::<Class>(&k::PRESET);
    let mut model = preset.map_or_else(ErrorModel::default, Class::model);
    let recorded = section.choice(&k::RECORDED);
    let from_report = recorded == Some(Recorded::Reported);
    if from_report && has_report {
        let when = "the platform has a [platform.reported] of its own".to_owned();
        section.fault(&k::RECORDED, Problem::Idle { when });
    }
    if from_report && live {
        // The truth beside it would have to be known before.
        let place = "beside live navigation";
        section.fault(&k::RECORDED, Problem::Live { found: "\"reported\"", place, allowed: "\"truth\"" });
    }
    if from_report && preset.is_some() {
        // Its velocity errors are no motion; what is left of it would not be the class.
        let when = "recorded = \"reported\": give position and attitude".to_owned();
        section.fault(&k::PRESET, Problem::Idle { when });
    }
    let rate_hz = section.number(&k::RATE_HZ);
    if section.has(&k::RATE_HZ) {
        model.rate_hz = rate_hz.filter(|rate_hz| *rate_hz > 0.0);
    }
    let latency_s = section.number(&k::LATENCY_S);
    model.latency_s = latency_s.unwrap_or(model.latency_s);
    let jitter_s = section.number(&k::JITTER_S);
    let between = section.choice(&k::BETWEEN);
    let has_dropouts = section.has(&k::DROPOUTS);
    let dropouts = section.section(&k::DROPOUTS).and_then(dropouts);
    let arm = section.vector(&k::LEVER_ARM_ERROR_M).map(|[x, y, z]| Vector::new(x, y, z));
    let sound = kinds(&section, &mut model, from_report);
    if from_report {
        section.idle(&[&k::VELOCITY, &k::LEVER_ARM_ERROR_M], SMOOTH);
    }
    section.finish();
    model.recorded = recorded?;
    model.jitter_s = jitter_s?;
    model.between = between?;
    model.dropouts = if has_dropouts { Some(dropouts?) } else { None };
    model.lever_arm_error = arm?;
    sound.then_some(model)
}

/// Errors of position, velocity and attitude; whether they could be read.
fn kinds(section: &Section<'_>, model: &mut ErrorModel, smooth: bool) -> bool {
    use keys::errors as k;
    let kinds = [
        (&k::POSITION, &keys::error_m::TABLE, 0, 1.0),
        (&k::VELOCITY, &keys::error_mps::TABLE, VELOCITY, 1.0),
        (&k::ATTITUDE, &keys::error_deg::TABLE, ATTITUDE, 1f64.to_radians()),
    ];
    let mut sound = true;
    for (kind, (key, table, first, unit)) in kinds.into_iter().enumerate() {
        let Some(of_kind) = section.section(key) else {
            sound &= !section.has(key);
            continue;
        };
        match axis_errors(of_kind, table, unit, &mut model.axes[first..first + 3], smooth) {
            Some(quantisation) => model.quantisation[kind] = quantisation,
            None => sound = false,
        }
    }
    sound
}

fn dropouts(section: Section<'_>) -> Option<Dropouts> {
    use keys::dropouts as k;
    let (per_hour, mean_s) = (section.number(&k::PER_HOUR), section.number(&k::MEAN_S));
    let during = section.choice(&k::DURING);
    section.finish();
    Some(Dropouts { per_hour: per_hour?, mean_s: mean_s?, during: during? })
}

/// One kind of error into its three axes, those of a preset where nothing is written; its quantisation.
fn axis_errors(
    section: Section<'_>,
    table: &Table,
    unit: f64,
    axes: &mut [AxisErrors],
    smooth: bool,
) -> Option<f64> {
    let &[
        bias,
        bias_sigma,
        white,
        walk,
        gm_sigma,
        gm_tau_s,
        sinusoid,
        sinusoid_hz,
        sinusoid_deg,
        step,
        step_at_s,
        ramp,
        quantisation,
    ] = table.keys
    else {
        return None;
    };
    if smooth {
        section.idle(&[white, step, quantisation], SMOOTH);
    }
    let [bias, bias_sigma, white, walk, gm_sigma, sinusoid, step, ramp] =
        [bias, bias_sigma, white, walk, gm_sigma, sinusoid, step, ramp]
            .map(|key| (section.has(key), section.vector::<3>(key)));
    let [gm_tau_s, sinusoid_hz, sinusoid_deg, step_at_s, quantisation] =
        [gm_tau_s, sinusoid_hz, sinusoid_deg, step_at_s, quantisation]
            .map(|key| (section.has(key), section.number(key)));
    section.finish();
    for (place, axis) in axes.iter_mut().enumerate() {
        let lists = [
            (&bias, &mut axis.bias),
            (&bias_sigma, &mut axis.bias_sigma),
            (&white, &mut axis.white),
            (&walk, &mut axis.walk),
            (&gm_sigma, &mut axis.gm_sigma),
            (&sinusoid, &mut axis.sinusoid),
            (&step, &mut axis.step),
            (&ramp, &mut axis.ramp),
        ];
        for ((written, values), to) in lists {
            let values = (*values)?;
            if *written {
                *to = values[place] * unit;
            }
        }
        if gm_tau_s.0 || axis.gm_tau_s == 0.0 {
            axis.gm_tau_s = gm_tau_s.1?;
        }
        axis.sinusoid_hz = sinusoid_hz.1?;
        axis.sinusoid_phase_rad = sinusoid_deg.1?.to_radians();
        axis.step_at_s = step_at_s.1?;
    }
    Some(quantisation.1? * unit)
}

/// `[platform.turbulence]`.
pub(super) fn gusts(section: Section<'_>) -> Option<Gusts> {
    use keys::turbulence as k;
    let written = section.exactly_one(&[&k::LEVEL, &k::WIND20_MPS]);
    let level = section.choice(&k::LEVEL).map(|level| match level {
        GustLevel::Light => LEVELS_MPS[0],
        GustLevel::Moderate => LEVELS_MPS[1],
        GustLevel::Severe => LEVELS_MPS[2],
    });
    let wind20_mps = section.number(&k::WIND20_MPS);
    let (height_m, airspeed_mps) = (section.number(&k::HEIGHT_M), section.number(&k::AIRSPEED_MPS));
    let sound = [(&k::HEIGHT_M, height_m), (&k::AIRSPEED_MPS, airspeed_mps)]
        .into_iter()
        .all(|(key, value)| value.is_some() || !section.has(key));
    let cutoff_hz = section.number(&k::CUTOFF_HZ);
    let (velocity_gain, attitude_gain) =
        (section.number(&k::VELOCITY_GAIN), section.number(&k::ATTITUDE_GAIN));
    let hold_s = section.number(&k::TRACK_HOLD_S);
    section.finish();
    written?;
    let gusts = Gusts {
        wind20_mps: level.or(wind20_mps)?,
        height_m,
        airspeed_mps,
        cutoff_hz: cutoff_hz?,
        velocity_gain: velocity_gain?,
        attitude_gain: attitude_gain?,
        hold_s: Some(hold_s?).filter(|hold_s| *hold_s > 0.0),
    };
    sound.then_some(gusts)
}
