#!/usr/bin/env python3
"""Draws the cross section of the modelled sea beside the measured one, and regenerates the tables of docs/sigma0.md.

    tools/sigma0_picture.py [--nereus target/release/nereus] [--page docs/sigma0.md] [--picture docs/sigma0.png]

All numbers are printed by `nereus table`; this only averages, rounds and draws. Measured points are those of
tests/data/clutter. Without matplotlib (--no-picture) the tables alone are written.
"""
import argparse
import csv
import io
import math
import pathlib
import re
import subprocess
import sys

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
SEA = "--kind elfouhaily --carrier-hz 10e9"
WINDS_MPS = (5.0, 10.0, 12.9, 15.0)
INCIDENCE_DEG = (0, 10, 20, 30, 45, 60, 70, 80, 85, 89)
ASPECTS_DEG = range(0, 360, 15)
# Strongest wind, m/s, and least incidence, degrees, of the empirical model.
NRL_MOST_MPS, NRL_LEAST_DEG = 12.9, 30
# Grazing angles, degrees, and winds of the table of breaking waves; winds of that of cross-polarisation, with
# what Vachon and Wolfe 2011 and Hwang et al. 2010 measured at 35 degrees in C band, dB.
BREAKING_DEG, BREAKING_MPS = (3, 5, 7, 10), (5.0, 8.0, 10.0, 12.9)
CROSS = {5.0: -33, 10.0: -30, 15.0: -27}
CROSS_SEA = "--kind elfouhaily --carrier-hz 5.3e9 --incidence-deg 35"
COLUMNS = ("upwind", "azimuth mean", "mars2007, upwind", "NRL")
# docs/physics.md section 10.6: X band, upwind, 10 m/s, specular part undamped: incidence, HH and VV, dB.
SPECIFIED = (
    (0, 12.9, 12.9), (20, 0.5, 0.8), (30, -9.6, -7.7), (45, -19.8, -13.6), (60, -28.3, -17.0), (80, -42.1, -23.0),
)


def rows(nereus, keys):
    """Rows of a table as dictionaries of numbers."""
    printed = subprocess.run([nereus, "table", *keys.split()], check=True, capture_output=True, text=True).stdout
    return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(io.StringIO(printed))]


def decibels(ratios):
    return [10 * math.log10(ratio) for ratio in ratios]


def curves(nereus, wind_mps, incidence_deg):
    """What one wind has at every incidence: {channel: {column: [dB or None]}}."""
    listed = ",".join(f"{angle:g}" for angle in incidence_deg)
    ours = f"sigma0 {SEA} --wind-mps {wind_mps:g} --incidence-deg {listed}"
    around = rows(nereus, f"{ours} --aspect-deg {','.join(str(aspect) for aspect in ASPECTS_DEG)}")
    upwind = rows(nereus, ours)
    paper = rows(nereus, f"{ours} --splitting mars2007")
    measured = {}
    if wind_mps <= NRL_MOST_MPS:
        grazing = ",".join(f"{90 - angle:g}" for angle in incidence_deg if angle >= NRL_LEAST_DEG)
        table = rows(nereus, f"sigma0-nrl --carrier-hz 10e9 --wind-mps {wind_mps:g} --grazing-deg {grazing}")
        measured = {row["incidence_deg"]: row for row in table}
    found = {}
    for channel in ("hh", "vv"):
        name = f"sigma0_{channel}_db"
        means = [
            sum(10 ** (row[name] / 10) for row in around if row["incidence_deg"] == angle) / len(ASPECTS_DEG)
            for angle in incidence_deg
        ]
        found[channel] = {
            "upwind": [row[name] for row in upwind],
            "azimuth mean": decibels(means),
            "mars2007, upwind": [row[name] for row in paper],
            "NRL": [measured[angle][name] if angle in measured else None for angle in incidence_deg],
        }
    return found


def table(found):
    """The lines of one wind's table."""
    heads = [f"{channel.upper()} {column}" for channel in found for column in COLUMNS]
    lines = ["| incidence | " + " | ".join(heads) + " |", "| ---: |" + " ---: |" * len(heads)]
    for i, angle in enumerate(INCIDENCE_DEG):
        cells = [found[channel][column][i] for channel in found for column in COLUMNS]
        lines.append(f"| {angle} | " + " | ".join("" if cell is None else f"{cell:.1f}" for cell in cells) + " |")
    return "\n".join(lines)


def with_breaking(nereus, keys, channel):
    """Azimuth means without and with breaking waves, by incidence: {degrees: (dB, dB)}."""
    found = {}
    for row in rows(nereus, f"sigma0 {keys} --breaking --aspect-deg {','.join(str(aspect) for aspect in ASPECTS_DEG)}"):
        ratio = [10 ** (row[f"{part}_{channel}_db"] / 10) for part in ("spm", "go", "sigma0")]
        sums = found.setdefault(row["incidence_deg"], [0.0, 0.0])
        sums[0] += (ratio[0] + ratio[1]) / len(ASPECTS_DEG)
        sums[1] += ratio[2] / len(ASPECTS_DEG)
    return {angle: decibels(sums) for angle, sums in found.items()}


def grazing_curves(nereus, wind_mps, grazing_deg):
    """Per channel: without breaking waves, with them, and the NRL model, at grazing angles."""
    listed = ",".join(f"{90 - angle:g}" for angle in grazing_deg)
    nrl = rows(nereus, f"sigma0-nrl --carrier-hz 10e9 --wind-mps {wind_mps:g} --grazing-deg {','.join(f'{angle:g}' for angle in grazing_deg)}")
    found = {}
    for channel in ("hh", "vv"):
        ours = list(with_breaking(nereus, f"{SEA} --wind-mps {wind_mps:g} --incidence-deg {listed}", channel).values())
        found[channel] = [(*own, row[f"sigma0_{channel}_db"]) for own, row in zip(ours, nrl)]
    return found


def breaking_table(nereus):
    lines = ["| wind, m/s | grazing | HH without | HH with | HH NRL | VV without | VV with | VV NRL | HH/VV with | HH/VV NRL |",
             "| ---: |" + " ---: |" * 9]
    for wind_mps in BREAKING_MPS:
        found = grazing_curves(nereus, wind_mps, BREAKING_DEG)
        for angle, hh, vv in zip(BREAKING_DEG, found["hh"], found["vv"]):
            cells = [*hh, *vv, hh[1] - vv[1], hh[2] - vv[2]]
            lines.append(f"| {wind_mps:g} | {angle} | " + " | ".join(f"{cell:.1f}" for cell in cells) + " |")
    return "\n".join(lines)


def cross_table(nereus):
    lines = ["| wind, m/s | without | with | measured |", "| ---: | ---: | ---: | ---: |"]
    for wind_mps, measured in CROSS.items():
        (without, with_them), = with_breaking(nereus, f"{CROSS_SEA} --wind-mps {wind_mps:g}", "hv").values()
        lines.append(f"| {wind_mps:g} | {without:.1f} | {with_them:.1f} | {measured} |")
    return "\n".join(lines)


def rewrite(page, nereus):
    """Puts fresh tables under the headings of the winds, and of breaking waves."""
    text = page.read_text()
    for heading, fresh in (("Grazing angles", breaking_table(nereus)), ("Cross-polarisation", cross_table(nereus))):
        pattern = re.compile(rf"(^### {heading}$\n\n)(?:\|.*\n)*", re.MULTILINE)
        text, count = pattern.subn(lambda found: f"{found[1]}{fresh}\n", text)
        if count != 1:
            sys.exit(f"{page}: there must be one heading '### {heading}'")
    for wind_mps in WINDS_MPS:
        fresh = table(curves(nereus, wind_mps, INCIDENCE_DEG))
        pattern = re.compile(rf"(^### {wind_mps:g} m/s$\n\n)(?:\|.*\n)*", re.MULTILINE)
        text, count = pattern.subn(lambda found: f"{found[1]}{fresh}\n", text)
        if count != 1:
            sys.exit(f"{page}: there must be one heading '### {wind_mps:g} m/s'")
    page.write_text(text)


def measured_points(channel, sea_state):
    """Incidence and level of Nathanson's values at 9.3 GHz."""
    with open(PACKAGE / "tests/data/clutter/nathanson.csv", newline="") as file:
        found = [row for row in csv.DictReader(file) if row["channel"] == channel]
    such = [row for row in found if float(row["carrier_ghz"]) == 9.3 and float(row["sea_state"]) == sea_state]
    return [90 - float(row["grazing_deg"]) for row in such], [float(row["sigma0_db"]) for row in such]


def draw(picture, nereus):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    incidence = [*range(0, 86), *(85 + 0.5 * i for i in range(2, 10)), 89.9]
    panels = ((5.0, 5.0, 2), (10.0, 10.0, 4), (15.0, NRL_MOST_MPS, 6))
    figure, axes = plt.subplots(2, 3, figsize=(13, 8), sharex=True, sharey=True, layout="constrained")
    for column, (wind_mps, measured_mps, sea_state) in enumerate(panels):
        ours = curves(nereus, wind_mps, incidence)
        measured = ours if measured_mps == wind_mps else curves(nereus, measured_mps, incidence)
        for axis, channel in zip(axes[:, column], ("hh", "vv")):
            axis.plot(incidence, ours[channel]["upwind"], "C0-", label="consistent, upwind")
            axis.plot(incidence, ours[channel]["azimuth mean"], "C0--", label="consistent, azimuth mean")
            axis.plot(incidence, ours[channel]["mars2007, upwind"], "C2:", label="mars2007, upwind")
            known = [level if level is not None else math.nan for level in measured[channel]["NRL"]]
            axis.plot(incidence, known, "C3-", label=f"NRL model, {measured_mps:g} m/s")
            axis.plot(*measured_points(channel, sea_state), "C3o", mfc="none", label=f"Nathanson, sea state {sea_state}")
            if wind_mps == 10.0:
                level = {"hh": 1, "vv": 2}[channel]
                points = [(row[0], row[level]) for row in SPECIFIED]
                axis.plot(*zip(*points), "kx", label="docs/physics.md section 10.6, upwind, undamped")
            axis.set_title(f"{channel.upper()}, {wind_mps:g} m/s")
            axis.grid(alpha=0.3)
            axis.legend(fontsize=7, loc="lower left")
            axis.set_xlim(0, 90)
            axis.set_ylim(-75, 20)
    for axis in axes[1]:
        axis.set_xlabel("incidence, degrees")
    for axis in axes[:, 0]:
        axis.set_ylabel("sigma0, dB")
    figure.savefig(picture, dpi=100)


def draw_breaking(picture, nereus):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    grazing = (1, 2, 3, 4, 5, 7, 10, 15, 20, 30)
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.5), layout="constrained")
    for axis, channel in zip(axes, ("hh", "vv")):
        for colour, (wind_mps, sea_state) in zip(("C0", "C1", "C3"), ((5.0, 2), (10.0, 4), (NRL_MOST_MPS, 6))):
            without, with_them, nrl = zip(*grazing_curves(nereus, wind_mps, grazing)[channel])
            axis.plot(grazing, without, f"{colour}:", label=f"{wind_mps:g} m/s, none breaking")
            axis.plot(grazing, with_them, f"{colour}-", label=f"{wind_mps:g} m/s, breaking")
            axis.plot(grazing, nrl, f"{colour}--", label="NRL model")
            incidence, level = measured_points(channel, sea_state)
            axis.plot([90 - angle for angle in incidence], level, f"{colour}o", mfc="none", label=f"Nathanson, sea state {sea_state}")
        axis.set(title=f"{channel.upper()}, X band, azimuth mean", xlabel="grazing angle, degrees", xlim=(1, 30), ylim=(-75, -10), xscale="log")
        axis.set_xticks((1, 3, 10, 30), ("1", "3", "10", "30"))
    axes[0].set_ylabel("sigma0, dB")
    winds = range(3, 18)
    found = [next(iter(with_breaking(nereus, f"{CROSS_SEA} --wind-mps {wind}", "hv").values())) for wind in winds]
    axes[2].plot(winds, [own[0] for own in found], "C0:", label="none breaking")
    axes[2].plot(winds, [own[1] for own in found], "C0-", label="breaking")
    axes[2].plot(CROSS.keys(), CROSS.values(), "ko", mfc="none", label="measured, about")
    axes[2].set(title="HV, C band, 35 degrees, azimuth mean", xlabel="wind at 10 m, m/s")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    figure.savefig(picture, dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nereus", default=str(PACKAGE / "target/release/nereus"))
    parser.add_argument("--page", type=pathlib.Path, default=PACKAGE / "docs/sigma0.md")
    parser.add_argument("--picture", type=pathlib.Path, default=PACKAGE / "docs/sigma0.png")
    parser.add_argument("--breaking-picture", type=pathlib.Path, default=PACKAGE / "docs/sigma0_breaking.png")
    parser.add_argument("--no-picture", action="store_true")
    arguments = parser.parse_args()
    rewrite(arguments.page, arguments.nereus)
    if not arguments.no_picture:
        try:
            draw(arguments.picture, arguments.nereus)
            draw_breaking(arguments.breaking_picture, arguments.nereus)
        except ImportError as missing:
            sys.exit(f"{missing}; install with: pip install matplotlib, or ask for --no-picture")


if __name__ == "__main__":
    main()
