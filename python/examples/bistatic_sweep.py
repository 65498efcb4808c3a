"""Sweeps a bistatic geometry: a receiver on a drone flies round the patch; echo of the sea and of a buoy against its azimuth.

    python bistatic_sweep.py [--small] [--out PICTURE.png]
"""

import argparse
from pathlib import Path

import numpy as np

import nereus

SCENE = nereus.Scenario(Path(__file__).parent / "coast.toml")
DISTANCE_M, HEIGHT_M = 2000.0, 600.0


def power_dbw(scene, pulses):
    """Mean power of a sample, dBW, without noise."""
    with scene.set({"radar.noise_figure_db": 0.0}).stream(pulses=(0, pulses)) as stream:
        return 10 * np.log10(np.mean([np.mean(np.abs(pulse.iq) ** 2) for pulse in stream]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--small", action="store_true", help="few places and pulses")
    parser.add_argument("--out", help="picture to make (needs matplotlib)")
    given = parser.parse_args()
    # 180 degrees: behind the transmitter, monostatic in azimuth; 0: forward scattering.
    azimuths, pulses = ([180.0, 60.0], 2) if given.small else (np.arange(0.0, 181.0, 15.0), 40)

    rows = []
    for azimuth in azimuths:
        turn = np.radians(azimuth)
        place = np.array([DISTANCE_M * np.cos(turn), DISTANCE_M * np.sin(turn), HEIGHT_M])
        scene = SCENE.set({"platform.1.track.position_m": place})
        # A target so small that the sea alone is left, and one so large that the sea does not matter.
        sea = power_dbw(scene.set({"target.0.rcs_m2": 1e-9}), pulses)
        both = power_dbw(scene.set({"target.0.rcs_m2": 1e6}), pulses)
        rows.append((azimuth, sea, both - 60.0))
        print(f"azimuth {azimuth:5.1f} deg: sea {sea:7.1f} dBW, buoy of 1 m2 {both - 60.0:7.1f} dBW")
    if given.out:
        import matplotlib.pyplot as plt

        azimuth, sea, buoy = np.array(rows).T
        figure, ax = plt.subplots(figsize=(7, 4.2), layout="constrained")
        ax.plot(azimuth, sea, "o-", label="sea")
        ax.plot(azimuth, buoy, "s-", label="buoy of 1 m$^2$")
        ax.set(xlabel="azimuth of the receiver, deg (180: behind the transmitter)", ylabel="mean power of a sample, dBW",
               title="A receiver that flies round a patch of sea")
        ax.grid(alpha=0.3)
        ax.legend()
        figure.savefig(given.out, dpi=110)


if __name__ == "__main__":
    main()
