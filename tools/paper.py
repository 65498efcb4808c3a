#!/usr/bin/env python3
"""Measures in the images of mars-1 to mars-4 what the MaRS paper states of its own (docs/paper.md has the table).

    tools/paper.py [--nereus target/release/nereus] [--out docs/paper-images.csv] [--keep FOLDER] [CONFIG ...]

Each configuration is run three times with the same waves: as it is; with its ship 100 km away; with a strong point in the middle instead of the
ship. Images are those of `nereus focus` (true navigation, 512 x 512 pixels of 1 m), all channels. Printed and written per channel:

mean_dbw          mean power of the image without the ship
contrast          <I^2>/<I>^2 of it, 4 m means
strip_db          mean power of the turbulent strip (20 to 195 m astern of the ship's stern, 15 m to either side) over that of the same waves without ship
strip_seen_db     the same over the sea 40 to 120 m to either side of it
wake              rms of what the ship's waves change of the power (4 m Gaussian means, within the Kelvin angle of the bow, without the strip), over the mean power
sea               rms of the power of the same area without ship over its mean
seen              wake / sea: 1 where the wake varies as much as the sea that hides it
range_m, cross_m  half-power widths of the point in its main channel

Needs numpy, scipy and h5py, and a release build with HDF5. Exit 1 when a run fails.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

AWAY = "ship.0.position_m=[100000, 0]"
POINT = '\n[[target]]\nname = "point"\nposition_m = [0.0, 0.0, 0.0]\nrcs_m2 = 1e9\n'
STERN_M, BOW_M = -50.0, 50.0
CUSP = np.radians(19.47)


def run(nereus, *words):
    ended = subprocess.run([nereus, *map(str, words)], capture_output=True, text=True)
    if ended.returncode:
        sys.exit(f"{' '.join(map(str, words))}\n{ended.stderr}")
    return ended.stdout


def image(nereus, scenario, folder, name, settings=()):
    """Complex images by channel, their axes, the report of `focus`, and the seconds of both commands."""
    recording, made = folder / f"{name}.h5", folder / f"{name}-image.h5"
    begun = time.monotonic()
    run(nereus, "run", scenario, "--pace", "fast", "--out", recording, "--force", *settings)
    ran = time.monotonic()
    printed = run(nereus, "focus", recording, "--out", made, "--force", "--json")
    ended = time.monotonic()
    import h5py

    with h5py.File(made) as f:
        names = [c.decode() if isinstance(c, bytes) else c for c in f.attrs["channels"]]
        images = {c: f["image"][i].astype(complex) for i, c in enumerate(names)}
        axes = f["x_m"][:], f["y_m"][:]
    return images, axes, json.loads(printed.splitlines()[-1]), (ran - begun, ended - ran)


def measures(with_ship, without, axes):
    from scipy.ndimage import gaussian_filter

    x, y = np.meshgrid(*axes)
    astern = (x < STERN_M - 20) & (x > STERN_M - 195)
    strip, beside = astern & (abs(y) < 15), astern & (abs(y) > 40) & (abs(y) < 120)
    waves = (x < BOW_M) & (x > -250) & (abs(y) < np.tan(CUSP) * (BOW_M - x)) & (abs(y) > 25)
    a, b = (np.abs(z) ** 2 for z in (with_ship, without))
    smooth_a, smooth_b = (gaussian_filter(p, 4.0) for p in (a, b))
    db = lambda p, q: 10 * np.log10(p.mean() / q.mean())
    mean = smooth_b[waves].mean()
    wake, sea = (smooth_a - smooth_b)[waves].std() / mean, smooth_b[waves].std() / mean
    four = b[: len(b) // 4 * 4, : b.shape[1] // 4 * 4].reshape(len(b) // 4, 4, -1, 4).mean((1, 3))
    return {
        "mean_dbw": 10 * np.log10(b.mean()),
        "contrast": (four**2).mean() / four.mean() ** 2,
        "strip_db": db(a[strip], b[strip]),
        "strip_seen_db": db(a[strip], a[beside]),
        "wake": wake,
        "sea": sea,
        "seen": wake / sea,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--nereus", default="target/release/nereus")
    parser.add_argument("--out", default="docs/paper-images.csv")
    parser.add_argument("--keep", help="folder for recordings and images (else they go away)")
    parser.add_argument("config", nargs="*", default=[f"configs/mars-{i}.toml" for i in (1, 2, 3, 4)])
    args = parser.parse_args()
    scratch = tempfile.TemporaryDirectory()
    folder = pathlib.Path(args.keep or scratch.name)
    folder.mkdir(exist_ok=True, parents=True)
    rows = []
    for config in map(pathlib.Path, args.config):
        ship, axes, _, seconds = image(args.nereus, config, folder, config.stem)
        bare, *_ = image(args.nereus, config, folder, f"{config.stem}-bare", ["--set", AWAY])
        # Beside the configuration, for the files that it names.
        with tempfile.NamedTemporaryFile("w", suffix=".toml", dir=config.parent) as point:
            point.write(config.read_text() + POINT)
            point.flush()
            *_, report, _ = image(args.nereus, point.name, folder, f"{config.stem}-point", ["--set", AWAY])
        for channel in ship:
            found = next(c for c in report["channels"] if c["name"] == channel)
            target = next(iter(found["targets"]), None) or {}
            row = {"config": config.stem, "channel": channel, **measures(ship[channel], bare[channel], axes)}
            # A sphere answers in its own polarisation: what leaks into the others is not measured.
            for key, cut in (("range_m", "range"), ("cross_m", "cross_range")):
                row[key] = target[cut]["width_m"] if channel in ("HH", "VV") and cut in target else float("nan")
            row["run_s"], row["focus_s"] = seconds
            rows.append(row)
            print("  ".join(f"{k} {v:.2f}" if isinstance(v, float) else v for k, v in row.items()), flush=True)
    with open(args.out, "w", newline="") as out:
        writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
