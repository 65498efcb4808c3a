"""Motion compensation against a known error: reports that rise and fall by 1.5 mm weaken a point and set echoes beside it.

The sinusoid leaves 20 log10 J0(beta) of the main lobe, and paired echoes of 20 log10 J1(beta)/J0(beta) (docs/mocomp.md).

    python motion_compensation.py [--small] [--out PICTURE.png]
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

import nereus

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
# Path error 2 x 1.5 mm x cos 45 deg, in radians at 10 GHz.
BETA = 2 * np.pi * 10e9 / 299_792_458.0 * 2 * 1.5e-3 * np.cos(np.pi / 4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--small", action="store_true", help="a small image")
    parser.add_argument("--out", help="picture to make (needs matplotlib)")
    given = parser.parse_args()

    scene = nereus.Scenario(CONFIGS / "mocomp-sinusoid.toml")
    # Pixels of half a cell at most.
    grid = {"centre_m": (0.0, 0.0), "size_m": (8.0, 3.0) if given.small else (96.0, 96.0), "pixel_m": 0.125, "aperture": "hann"}
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "flight.h5"
        scene.record(recording, progress=False)
        images = {nav: nereus.focus(recording, nav, **grid) for nav in ("true", "reported")}

    power = {nav: np.abs(image.values[0]) ** 2 for nav, image in images.items()}
    image = images["true"]
    row, column = np.abs(image.y_m).argmin(), np.abs(image.x_m).argmin()
    near = np.s_[row - 3 : row + 4, column - 3 : column + 4]
    loss_db = 10 * np.log10(power["reported"][near].max() / power["true"][near].max())
    # The echoes are 5 cells to either side along the track: 2.5 Hz over 2 s.
    beside = np.s_[row - 3 : row + 4, column + 9 : column + 17]
    echo_db = 10 * np.log10(power["reported"][beside].max() / power["reported"][near].max())
    # J0 and J1 by their series: beta is small.
    j0, j1 = 1 - BETA**2 / 4 + BETA**4 / 64, BETA / 2 - BETA**3 / 16 + BETA**5 / 384
    print(f"loss of the point:  {loss_db:6.2f} dB, expected {20 * np.log10(j0):6.2f} dB")
    print(f"paired echo:        {echo_db:6.2f} dB, expected {20 * np.log10(j1 / j0):6.2f} dB")
    if given.out:
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
        for ax, image in zip(axes, images.values()):
            image.plot(ax=ax)
        figure.savefig(given.out, dpi=100)


if __name__ == "__main__":
    main()
