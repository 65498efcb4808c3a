#!/usr/bin/env python3
"""Lateness of pulses with each kind of sink and without any, side by side.

    tools/sinks_lateness.py [--nereus target/release/nereus] [--seconds 10] [--turns 3] [--prf-hz 1000] [--json]

Runs configs/live-wire.toml in real time, by turns with every set of sinks, each with a subscriber where it sends: `nereus receive`,
pyzmq, iceoryx2. Prints for each set the median over the turns of lateness (p50, p99, p99.9, worst, us), and what was late, dropped
or missed in all of them. What cannot be had here is named and left out. Times of different days are not comparable.
"""
import argparse
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TOP = Path(__file__).resolve().parent.parent
# Each counts pulses until the run has ended, and prints how many it has missed.
ZMQ = """
import json, sys, zmq
subscriber = zmq.Context().socket(zmq.SUB)
subscriber.setsockopt(zmq.RECONNECT_IVL, 10)
subscriber.setsockopt(zmq.RCVTIMEO, 30_000)
subscriber.setsockopt(zmq.RCVHWM, 20_000)
subscriber.setsockopt(zmq.SUBSCRIBE, b"")
subscriber.connect(sys.argv[1])
received, topic = 0, b""
while topic != b"end":
    topic, text, *_ = subscriber.recv_multipart()
    received += topic == b"pulse"
print(json.loads(text)["sequence"] - received)
"""
SHM = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("shm", sys.argv[2])
shm = importlib.util.module_from_spec(spec)
spec.loader.exec_module(shm)
with shm.subscribe(sys.argv[1], idle_s=30.0) as pulses:
    first = next(pulses).sequence
    for pulse in pulses:
        pass
print(first + pulses.missed)
"""


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def sets_of_sinks(nereus, folder):
    """By name: the sinks, and the words of their subscribers."""
    wire, port = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_STREAM)
    service = f"lateness-{os.getpid()}"
    file = f"{{ kind = 'hdf5', path = '{folder}/recording.h5' }}"
    sends = {
        "vita49": (
            f"{{ kind = 'vita49', address = '127.0.0.1:{wire}' }}",
            [nereus, "receive", "--json", "--idle-s", "2", "--listen", f"127.0.0.1:{wire}"],
        ),
        "zmq": (
            f"{{ kind = 'zmq', bind = '127.0.0.1:{port}', messages = 'multipart' }}",
            [sys.executable, "-c", ZMQ, f"tcp://127.0.0.1:{port}"],
        ),
        "shm": (
            f"{{ kind = 'shm', service = '{service}' }}",
            [sys.executable, "-c", SHM, service, str(TOP / "python/nereus/shm.py")],
        ),
    }
    for kind, module in (("zmq", "zmq"), ("shm", "iceoryx2")):
        if subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True).returncode:
            print(f"left out: {kind} (python3 has no {module})", file=sys.stderr)
            del sends[kind]
    probe = [nereus, "run", str(TOP / "configs/live-wire.toml"), "--pulses", "0..1", "--set"]
    if "shm" in sends and subprocess.run([*probe, f"sink=[{sends['shm'][0]}]"], capture_output=True).returncode:
        print("left out: shm (build with --features shm)", file=sys.stderr)
        del sends["shm"]
    sets = {"none": ([], []), "hdf5": ([file], [])}
    sets.update({kind: ([sink], [words]) for kind, (sink, words) in sends.items()})
    sets["all"] = ([file, *(sink for sink, _ in sends.values())], [words for _, words in sends.values()])
    return sets


def measure(arguments, sinks, subscribers):
    """A run: the report, and what subscribers have missed."""
    readers = [subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for words in subscribers]
    try:
        time.sleep(0.5 if readers else 0.0)
        words = [arguments.nereus, "run", str(TOP / "configs/live-wire.toml"), "--json", "--force", "--pace", "realtime"]
        keys = {"sink": f"[{', '.join(sinks)}]", "radar.prf_hz": arguments.prf_hz, "scene.duration_s": arguments.seconds}
        for key, value in keys.items():
            words += ["--set", f"{key}={value}"]
        run = subprocess.run(words, capture_output=True, text=True)
        if run.returncode:
            raise SystemExit(run.stderr)
        missed = 0
        for reader in readers:
            counts = json.loads(reader.communicate(timeout=60)[0].splitlines()[-1])
            missed += counts["missing"]["pulses_by_index"] if isinstance(counts, dict) else counts
    finally:
        for reader in readers:
            reader.kill()
    report = json.loads(run.stdout.splitlines()[-1])
    return report, missed + sum(sink["dropped"] for sink in report["sinks"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--nereus", default=str(TOP / "target/release/nereus"))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--prf-hz", type=float, default=1000.0)
    parser.add_argument("--json", action="store_true", help="one JSON object, last")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        sets = sets_of_sinks(arguments.nereus, folder)
        turns = {name: [] for name in sets}
        for turn in range(arguments.turns):
            for name, (sinks, subscribers) in sets.items():
                turns[name].append(measure(arguments, sinks, subscribers))
                print(f"turn {turn + 1} of {arguments.turns}: {name}", file=sys.stderr)
    rows = {}
    for name, runs in turns.items():
        rows[name] = {key: statistics.median(report["lateness_us"][key] for report, _ in runs) for key in ("p50", "p99", "p999", "max")}
        rows[name] |= {key: sum(report[key] for report, _ in runs) for key in ("pulses", "late", "dropped")}
        rows[name]["missed"] = sum(missed for _, missed in runs)
    print(f"{arguments.prf_hz:g} Hz, {arguments.turns} turns of {arguments.seconds:g} s, lateness in us")
    print(f"{'sinks':8}" + "".join(f"{key:>9}" for key in next(iter(rows.values()))))
    for name, row in rows.items():
        print(f"{name:8}" + "".join(f"{value:9.0f}" for value in row.values()))
    if arguments.json:
        print(json.dumps({"prf_hz": arguments.prf_hz, "seconds": arguments.seconds, "sinks": rows}))


if __name__ == "__main__":
    main()
