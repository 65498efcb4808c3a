"""Streams pulses into a processor: every pulse is range-compressed as it comes, and the strongest echo is named.

    python stream_into_a_processor.py [--small] [--pace realtime] [SCENARIO]
"""

import argparse
from pathlib import Path

import numpy as np

import nereus

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


class RangeCompressor:
    """A matched filter with the replica of the stream."""

    def __init__(self, info):
        self.samples = info["samples"]
        replica = np.atleast_2d(info["replica"])  # one for each waveform in turn
        self.length = self.samples + replica.shape[1] - 1
        self.replicas = np.conj(np.fft.fft(replica, self.length))

    def __call__(self, pulse, channel=0):
        replica = self.replicas[pulse.index % len(self.replicas)]
        return np.fft.ifft(np.fft.fft(pulse.iq[channel], self.length) * replica)[: self.samples]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", nargs="?", default=CONFIGS / "selftest.toml")
    parser.add_argument("--pace", choices=["fast", "realtime"], default="fast")
    parser.add_argument("--small", action="store_true", help="few pulses")
    given = parser.parse_args()

    scene = nereus.Scenario(given.scenario)
    pulses = (0, min(scene.pulse_count, 20 if given.small else 2000))
    with scene.stream(given.pace, pulses) as stream:
        compress, fs = RangeCompressor(stream.info), stream.info["sample_rate_hz"]
        mean = 0.0
        for count, pulse in enumerate(stream, 1):
            mean += (np.abs(compress(pulse)) ** 2 - mean) / count
            if pulse.flags & nereus.Flag.AFTER_GAP:
                print(f"pulse {pulse.index}: pulses before it were missed")
        peak = int(mean.argmax())
        delay_us = (pulse.window_start_s + peak / fs) * 1e6
        print(f"{count} pulses: strongest echo {delay_us:.2f} us after the emission, "
              f"{10 * np.log10(mean[peak] / np.median(mean)):.1f} dB above the median cell")
        for name, platform in pulse.reported.items():
            print(f"{name}: at {np.round(platform.position_m, 1)} m by its own report")


if __name__ == "__main__":
    main()
