#!/usr/bin/env python3
"""Draws a recording: the scene seen from above, and the range-compressed echo of every pulse.

    tools/picture.py out/quickstart.h5 docs/quickstart.png [--channel VV]

Needs numpy, h5py and matplotlib (pip install numpy h5py matplotlib).
"""
import argparse
import sys

try:
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}; install with: pip install numpy h5py matplotlib")

SPEED_OF_LIGHT_MPS = 299_792_458.0


def compress(iq, replica):
    """Matched filter along the last axis; sample 0 of the result is zero delay in the window."""
    length = 1 << (iq.shape[-1] + replica.size - 1).bit_length()
    spectrum = np.fft.fft(iq, length) * np.conj(np.fft.fft(replica, length))
    return np.fft.ifft(spectrum)[..., : iq.shape[-1]] / np.sum(np.abs(replica) ** 2)


def looks(power, rows):
    """Means over consecutive pulses, about so many rows in all: the speckle of a sea evens out."""
    count = max(1, len(power) // rows)
    whole = len(power) // count * count
    return power[:whole].reshape(-1, count, power.shape[1]).mean(axis=1)


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("picture")
    parser.add_argument("--channel", default="VV")
    parser.add_argument("--rows", type=int, default=200, help="about so many rows: pulses are averaged in power")
    arguments = parser.parse_args()
    with h5py.File(arguments.recording, "r") as recording:
        names = [text(name) for name in recording.attrs["channels"]]
        if arguments.channel not in names:
            sys.exit(f"channel {arguments.channel} is not recorded; there are {', '.join(names)}")
        channel = names.index(arguments.channel)
        fs = float(recording.attrs["sample_rate_hz"])
        pulses = recording["pulse/index"].shape[0]
        raw = recording["iq"][:pulses, channel, :]
        iq = raw if raw.dtype.kind == "c" else raw["r"] + 1j * raw["i"].astype(np.float32)
        replica = recording["replica"][:]
        compressed = compress(iq, replica)
        start = recording["pulse/window_start_s"][:pulses]
        time = (recording["pulse/time_ns"][:pulses] - recording["pulse/time_ns"][0]) * 1e-9
        delays = recording["truth/delay_s"][:pulses, 0, :]
        platforms = {
            name: group["true/position_m"][:pulses]
            for name, group in recording["nav"].items()
            if "true" in group
        }
    power = looks(np.abs(compressed) ** 2, arguments.rows)
    power_db = 10 * np.log10(power + 1e-60)
    # Between the noise and the brightest targets lies the sea.
    top = np.percentile(power_db, 99.8)
    bottom = max(np.percentile(power_db, 20), top - 50)
    figure, (above, echo) = plt.subplots(1, 2, figsize=(13, 5.2), width_ratios=[1, 1.5])
    for name, position in platforms.items():
        if np.ptp(position, axis=0).max() < 1.0:
            above.plot(position[0, 0] / 1e3, position[0, 1] / 1e3, "^", markersize=10, label=name)
        else:
            above.plot(position[:, 0] / 1e3, position[:, 1] / 1e3, linewidth=3, label=f"{name}, {time[-1]:.0f} s")
    above.plot(0, 0, "+", color="black", markersize=14, label="origin of the scene")
    # As wide as it is high, with some room around.
    corners = np.array([above.get_xlim(), above.get_ylim()])
    half = 0.55 * np.ptp(corners, axis=1).max()
    (left, right), (low, high) = corners.mean(axis=1)[:, None] + [-half, half]
    above.set(xlabel="East, km", ylabel="North, km", aspect="equal", title="Scene from above")
    above.set(xlim=(left, right), ylim=(low, high))
    above.grid(alpha=0.3)
    above.legend(fontsize=8)
    # Echoes that begin later than this are cut off by the end of the window.
    whole = max(1, iq.shape[1] - np.count_nonzero(np.abs(replica) > 1e-2 * np.abs(replica).max()))
    # The window moves with what it follows: rows are drawn against the delay after its start.
    extent = [0, iq.shape[1] / fs * 1e6, time[-1], time[0]]
    image = echo.imshow(power_db, extent=extent, aspect="auto", cmap="magma", vmin=bottom, vmax=top)
    for target in range(delays.shape[1]):
        echo.plot((delays[::40, target] - start[::40]) * 1e6, time[::40], ".", color="cyan", markersize=1, alpha=0.5)
    echo.set(
        xlabel="delay after the start of the window, us",
        ylabel="time, s",
        xlim=(0, whole / fs * 1e6),
        title=f"{arguments.channel}, range-compressed; dots: true delays",
    )
    figure.colorbar(image, ax=echo, label="dBW")
    figure.tight_layout()
    figure.savefig(arguments.picture, dpi=90)
    print(arguments.picture)


if __name__ == "__main__":
    main()
