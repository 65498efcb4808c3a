"""Pulses per second of a loop in Python over those of the same loop in Rust (stream.rs), by turns.

    cargo bench -p nereus-python --bench stream --no-run          # prints the program
    python python/benches/stream.py PROGRAM configs/mars-1.toml 444 --turns 5

The package must be built with --release. Prints the median of each and of the ratios of neighbours.
"""

import argparse
import statistics
import subprocess
import sys
import time

LOOP = """
import sys, time
import nereus
scene, pulses = nereus.Scenario(sys.argv[1]), int(sys.argv[2])
first, total = None, 0.0
for pulse in scene.stream(pace="fast", pulses=(0, pulses)):
    first = first or time.perf_counter()
    total += float(pulse.iq[0, 0].real)
print(f"{(pulses - 1) / (time.perf_counter() - first):.2f}")
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="stream.rs, built")
    parser.add_argument("scenario")
    parser.add_argument("pulses", type=int)
    parser.add_argument("--turns", type=int, default=5)
    given = parser.parse_args()
    words = [given.scenario, str(given.pulses)]
    programs = {"rust": [given.program, *words], "python": [sys.executable, "-c", LOOP, *words]}
    rates: dict[str, list[float]] = {name: [] for name in programs}
    for turn in range(given.turns):
        # Whoever is first changes, so that neither always finds the machine as the other left it.
        for name in list(programs) if turn % 2 == 0 else list(programs)[::-1]:
            printed = subprocess.run(programs[name], capture_output=True, text=True, check=True).stdout
            rates[name].append(float(printed))
            time.sleep(0.2)
        print(f"turn {turn}: rust {rates['rust'][-1]:.1f}, python {rates['python'][-1]:.1f} pulses/s", flush=True)
    ratios = [p / r for p, r in zip(rates["python"], rates["rust"])]
    medians = {name: statistics.median(values) for name, values in rates.items()}
    print(f"median: rust {medians['rust']:.1f}, python {medians['python']:.1f} pulses/s; ratio {statistics.median(ratios):.3f}")


if __name__ == "__main__":
    main()
