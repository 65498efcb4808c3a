#!/usr/bin/env python3
"""Draws docs/bragg.png: range-Doppler maps of the sea in L band, up- and crosswind, with Bragg waves frozen and travelling.

    tools/bragg_picture.py [--nereus target/release/nereus] [--picture docs/bragg.png]

A radar that stands at 60 degrees incidence looks West for 16 s; maps are means of four windows of 4 s. Needs h5py and matplotlib.
"""
import argparse
import pathlib
import subprocess
import tempfile

SCENE = """
[scene]
duration_s = 16.0
seed = 1
patch_size_m = [128.0, 128.0]
facet_m = 1.0
[sea]
wind_mps = 4.0
wind_from_deg = {wind_from_deg}
spectrum = "elfouhaily"
[sea.scattering]
bragg = "{bragg}"
[radar]
carrier_hz = 1.3e9
sample_rate_hz = 50e6
prf_hz = 32.0
channels = ["VV"]
[radar.waveform]
kind = "lfm"
bandwidth_hz = 40e6
pulse_s = 0.5e-6
[radar.window]
samples = 96
start_us = 6.1
[[platform]]
name = "mast"
track = {{ kind = "fixed", position_m = [866.0, 0.0, 500.0] }}
[[transmitter]]
name = "tx"
platform = "mast"
power_w = 1.0
antenna = {{ kind = "isotropic" }}
[[receiver]]
name = "rx"
platform = "mast"
antenna = {{ kind = "isotropic" }}
[stream]
pace = "fast"
[[sink]]
kind = "hdf5"
path = "bragg.h5"
"""
PULSES = 128


def compressed(path):
    """Range-compressed samples, `[pulse][sample]`, and their one-way ranges, m."""
    import h5py
    import numpy as np

    with h5py.File(path) as file:
        echoes, replica = file["iq"][:, 0, :], file["replica"][()]
        start_s, rate_hz = file["pulse/window_start_s"][0], file.attrs["sample_rate_hz"]
    samples = echoes.shape[1]
    length = samples + len(replica)
    spectrum = np.fft.fft(echoes, length, axis=1) * np.conj(np.fft.fft(replica, length))
    ranges_m = 0.5 * 299_792_458.0 * (start_s + np.arange(samples) / rate_hz)
    return np.fft.ifft(spectrum, axis=1)[:, :samples], ranges_m


def doppler_map(echoes):
    """Mean power over windows of `PULSES`, Hann, dB of its maximum: `[Doppler][sample]`."""
    import numpy as np

    window = np.hanning(PULSES)[:, None]
    parts = [echoes[n : n + PULSES] * window for n in range(0, len(echoes) - PULSES + 1, PULSES)]
    power = np.mean([np.abs(np.fft.fftshift(np.fft.fft(part, axis=0), axes=0)) ** 2 for part in parts], axis=0)
    return 10 * np.log10(power / power.max() + 1e-12)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nereus", default="target/release/nereus")
    parser.add_argument("--picture", type=pathlib.Path, default=pathlib.Path("docs/bragg.png"))
    asked = parser.parse_args()
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    # Of 60 degrees incidence: K = 47.2 rad/m, with surface tension.
    bragg_hz = (9.81 * 47.2 * (1 + (47.2 / 370) ** 2)) ** 0.5 / 6.283185
    figure, axes = plt.subplots(2, 2, figsize=(10, 7), sharex=True, sharey=True, layout="constrained")
    for row, (wind, wind_from_deg) in enumerate((("upwind", 270), ("crosswind", 0))):
        for column, bragg in enumerate(("frozen", "travelling")):
            with tempfile.TemporaryDirectory() as folder:
                scene, recording = pathlib.Path(folder, "bragg.toml"), pathlib.Path(folder, "bragg.h5")
                scene.write_text(SCENE.format(wind_from_deg=wind_from_deg, bragg=bragg))
                subprocess.run([asked.nereus, "run", scene, "--out", recording], check=True, capture_output=True)
                echoes, ranges_m = compressed(recording)
            axis = axes[row][column]
            extent = (ranges_m[0], ranges_m[-1], -16.0, 16.0)
            image = axis.imshow(
                doppler_map(echoes), origin="lower", aspect="auto", extent=extent, vmin=-40, vmax=0, cmap="viridis"
            )
            for sign in (-1, 1):
                axis.axhline(sign * bragg_hz, color="white", linewidth=0.8, linestyle=":")
            axis.set(title=f"{wind}, {bragg}", ylim=(-9, 9), xlim=(945, 1060))
            if column == 0:
                axis.set_ylabel("Doppler, Hz")
            if row == 1:
                axis.set_xlabel("slant range, m")
    figure.colorbar(image, ax=axes, label="dB of the maximum")
    figure.suptitle("Sea in L band, VV, 60 degrees incidence, wind 4 m/s; dotted: the Bragg wave's own frequency")
    figure.savefig(asked.picture, dpi=100)


if __name__ == "__main__":
    main()
