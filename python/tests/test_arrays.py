"""Arrays in scenarios: what the engine makes of them, and what is refused."""

import os

import numpy as np
import pytest

import nereus

UTC = np.datetime64("2024-05-01T00:00:00", "ns")


def test_a_trajectory_is_flown(scene):
    time = UTC + np.arange(30) * np.timedelta64(100, "ms")
    t = np.arange(30) * 0.1
    position = np.column_stack([50 * t, 60 * t + t * t, 300 - t])
    track = nereus.trajectory(time, position)
    flown = scene.set({"scene.start_utc": "2024-05-01T00:00:01Z", "platform.1.track": track})
    pulse = next(flown.stream(pulses=(50, 51)))
    np.testing.assert_allclose(pulse.truth["aircraft"].position_m, [75.0, 92.25, 298.5], atol=1e-3)


def test_a_trajectory_with_attitude(scene):
    attitude = np.tile([5.0, -2.0, 30.0], (3, 1))
    track = nereus.trajectory([0, 1, 2], np.zeros((3, 3)) + [0, 0, 300], attitude_deg=attitude)
    flown = scene.set({"scene.start_utc": "1970-01-01T00:00:00Z", "platform.1.track": track})
    np.testing.assert_allclose(next(flown.stream()).truth["aircraft"].attitude_deg, [5, -2, 30], atol=1e-6)


def test_times_keep_their_nanoseconds():
    time = UTC + np.array([1, 1_000_000_001])
    text = nereus.trajectory(time, np.zeros((2, 3)))["path"].text
    seconds = UTC.astype("int64") // 10**9
    assert text.splitlines()[1].startswith(f"{seconds}.000000001,") and f"\n{seconds + 1}.000000001," in text


def test_a_waveform_of_samples_is_the_chirp_it_samples(scene):
    rate, pulse_s, bandwidth = 200e6, 1e-6, 30e6
    t = (np.arange(200) + 0.5) / rate
    chirp = np.exp(1j * np.pi * bandwidth / pulse_s * (t - pulse_s / 2) ** 2)
    sampled = scene.set({"radar.waveform": nereus.waveform(chirp.astype(np.complex64), rate), "radar.noise_figure_db": 0.0})
    ours, theirs = (next(of.stream()).iq for of in (sampled, scene.set({"radar.noise_figure_db": 0.0})))
    match = abs(np.vdot(ours, theirs)) / np.linalg.norm(ours) / np.linalg.norm(theirs)
    assert match > 0.97


def test_targets_are_tables_in_memory(scene):
    position = np.array([[1000.0, 10.0 * i, 2.0] for i in range(5)])
    many = scene.set({"target": nereus.targets(position, np.arange(1, 6), velocity_mps=[0, 1, 0], name="buoy")})
    stream = many.stream()
    assert stream.info["targets"] == [f"buoy{i}" for i in range(5)]
    assert next(stream).target_delay_s.shape == (1, 5)


def test_a_pattern_and_a_spectrum_are_read(scene):
    az, el = np.linspace(-180, 180, 73), np.linspace(-90, 90, 37)
    gain = np.full((az.size, el.size), 6.0206)
    quiet = scene.set({"radar.noise_figure_db": 0.0})
    antenna = nereus.pattern(az, el, gain)
    plain = next(quiet.set({"receiver.0.antenna": {"kind": "isotropic"}}).stream()).iq
    measured = next(quiet.set({"receiver.0.antenna": antenna}).stream()).iq
    peak = np.unravel_index(np.abs(plain).argmax(), plain.shape)
    assert np.abs(measured).max() > np.abs(plain).max()
    assert peak is not None
    k = np.linspace(-1, 1, 41)
    psi = np.exp(-((k[:, None] - 0.3) ** 2 + k[None, :] ** 2) / 0.01)
    keys = {"scene.patch_size_m": [64.0, 64.0], "scene.facet_m": 1.0}
    sea = {"wind_mps": 3.0, "wind_from_deg": 270.0, **nereus.spectrum(k, k, psi)}
    water = nereus.sea(scene.set({**keys, "sea": sea}))
    expected = 4 * np.sqrt(psi.sum() * 0.05**2)
    assert water.figures["expected_significant_height_m"] == pytest.approx(expected, rel=0.1)


def test_files_of_arrays_live_as_long_as_the_scenario(scene):
    shaped = scene.set({"radar.waveform": nereus.waveform(np.ones(50), 50e6)})
    folder = shaped._folders[0].path
    other = shaped.set({"scene.seed": 2})
    del shaped
    assert os.listdir(folder)
    os.remove(os.path.join(folder, os.listdir(folder)[0]))
    assert next(other.stream()).index == 0
    del other
    assert not os.path.exists(folder)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: nereus.trajectory(["a", "b"], np.zeros((2, 3))), "time: an array of <U1; allowed: real numbers"),
        (lambda: nereus.trajectory([0, 1], np.zeros((2, 2))), r"position_m: an array of shape \[2, 2\]; allowed: \[2, 3\]"),
        (lambda: nereus.trajectory([0, 1], [[0, 0, np.nan]] * 2), r"position_m: nan at \[0, 2\]; allowed: finite"),
        (lambda: nereus.trajectory([0, 0], np.zeros((2, 3))), "strictly increasing"),
        (lambda: nereus.trajectory([], np.zeros((0, 3))), "time: is empty"),
        (lambda: nereus.trajectory([0, 1]), "exactly one of position_m and position_llh"),
        (lambda: nereus.trajectory([0.0, 1.0], np.zeros((2, 3), complex)), "position_m: an array of complex128"),
        (lambda: nereus.trajectory([UTC, np.datetime64("NaT")], np.zeros((2, 3))), r"NaT at \[1\]"),
        (lambda: nereus.waveform(np.zeros((2, 2)), 1e6), r"samples: an array of shape \[2, 2\]; allowed: \[n\]"),
        (lambda: nereus.waveform([1.0, np.inf], 1e6), r"samples: .*inf.* at \[1\]"),
        (lambda: nereus.pattern([0, 1], [0, 1], np.zeros((2, 3))), r"gain_dbi: .*\[2, 3\]; allowed: \[2, 2\]"),
        (lambda: nereus.pattern([1, 0], [0, 1], np.zeros((2, 2))), "azimuth_deg: 0.0 at"),
        (lambda: nereus.spectrum([0, 1], [0, 1], -np.ones((2, 2))), r"psi_m4: -1.0 at \[0, 0\]; allowed: 0 or more"),
        (lambda: nereus.targets(np.zeros(3), 1.0), r"position_m: an array of shape \[3\]; allowed: \[n, 3\]"),
        (lambda: nereus.targets(np.zeros((2, 3)), [1.0]), r"rcs_m2: .*\[1\]; allowed: \[2\]"),
    ],
)
def test_arrays_that_are_refused(make, words):
    with pytest.raises(nereus.ArrayError, match=words):
        make()


def test_arrays_elsewhere_in_a_scenario_are_refused_by_their_key(scene):
    with pytest.raises(nereus.ArrayError, match=r"target.0.position_m: nan at \[1\]"):
        scene.set({"target.0.position_m": np.array([0, np.nan, 0])})
    with pytest.raises(nereus.ArrayError, match="radar.waveform.path: an array of complex128.*nereus.waveform"):
        scene.set({"radar.waveform": {"path": np.zeros(3, complex)}})
