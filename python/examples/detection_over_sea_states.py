"""Monte Carlo of detection: how often a buoy is seen by a CFAR detector, against wind.

    python detection_over_sea_states.py [--small] [--out PICTURE.png]
"""

import argparse
import itertools
from pathlib import Path

import numpy as np

import nereus

SCENE = nereus.Scenario(Path(__file__).parent / "coast.toml")
GUARD, TRAIN, FALSE_ALARMS, PULSES = 4, 16, 1e-3, 8
# Threshold over the mean of the training cells, for sums of PULSES exponential powers (Monte Carlo of its own).
RNG = np.random.default_rng(1)
THRESHOLD = np.quantile(
    RNG.gamma(PULSES, size=400_000) / (RNG.gamma(PULSES * 2 * TRAIN, size=400_000) / (2 * TRAIN)), 1 - FALSE_ALARMS
)


def detections(scene, pulses):
    """Whether the buoy is detected, for every group of PULSES pulses."""
    found, power = [], 0.0
    with scene.stream(pulses=(0, pulses)) as stream:
        fs, samples = stream.info["sample_rate_hz"], stream.info["samples"]
        length = samples + stream.info["replica"].size
        replica = np.conj(np.fft.fft(stream.info["replica"], length))
        for pulse in stream:
            power = power + np.abs(np.fft.ifft(np.fft.fft(pulse.iq[0], length) * replica)[:samples]) ** 2
            if (pulse.index + 1) % PULSES == 0:
                cell = round((pulse.target_delay_s[0, 0] - pulse.window_start_s) * fs)
                left = power[cell - GUARD - TRAIN : cell - GUARD]
                right = power[cell + GUARD + 1 : cell + GUARD + 1 + TRAIN]
                found.append(power[cell] > THRESHOLD * np.concatenate([left, right]).mean())
                power = 0.0
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--small", action="store_true", help="few winds, seeds and pulses")
    parser.add_argument("--out", help="picture to make (needs matplotlib)")
    given = parser.parse_args()
    winds, sizes, seeds, pulses = ([3, 12], [1.0], 1, PULSES) if given.small else (range(2, 17, 2), [0.3, 1.0, 3.0], 6, 40)

    share = np.zeros((len(sizes), len(winds)))
    for (i, rcs), (j, wind) in itertools.product(enumerate(sizes), enumerate(winds)):
        found = []
        for seed in range(seeds):
            scene = SCENE.set({"sea.wind_mps": float(wind), "scene.seed": seed, "target.0.rcs_m2": rcs})
            found += detections(scene, pulses)
        share[i, j] = np.mean(found)
        print(f"{rcs:4.1f} m2 at {wind:2d} m/s: {share[i, j]:.2f} of {len(found)} trials detected")
    if given.out:
        import matplotlib.pyplot as plt

        figure, ax = plt.subplots(figsize=(7, 4.2), layout="constrained")
        for rcs, row in zip(sizes, share):
            ax.plot(list(winds), row, "o-", label=f"{rcs:g} m$^2$")
        ax.set(xlabel="wind at 10 m, m/s", ylabel="share detected", ylim=(-0.02, 1.02),
               title=f"A buoy at 3 km, CFAR over {PULSES} pulses, false alarms {FALSE_ALARMS:g}")
        ax.grid(alpha=0.3)
        ax.legend(loc="lower left")
        figure.savefig(given.out, dpi=110)


if __name__ == "__main__":
    main()
