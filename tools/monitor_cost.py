#!/usr/bin/env python3
"""What the live page costs the stream: lateness, losses and speed with no monitor, with one, with five clients that take
everything, and with one that stops reading. By turns, so that a machine that changes its speed does so for all.

    tools/monitor_cost.py                                   # target/release/nereus, configs/quickstart.toml, 5 rounds
    tools/monitor_cost.py --rounds 9 --duration-s 20

In real time (policy "drop") it compares lateness and losses; at pace "fast" the pulses made in a second. Clients are plain
sockets, not browsers: what a browser takes on the same machine is its own. Medians, with the range.
"""

import argparse
import base64
import json
import os
import re
import socket
import statistics
import subprocess
import tempfile
import threading
from pathlib import Path
from urllib.parse import urlsplit

ROOT = Path(__file__).resolve().parent.parent
CASES = {"no monitor": None, "a monitor, no client": 0, "one client": 1, "five clients": 5, "one that stops reading": -1}


def client(address, stop, reads):
    """Opens the page's socket, and takes all that comes, or nothing."""
    url = urlsplit(address)
    with socket.create_connection((url.hostname, url.port)) as stream:
        key = base64.b64encode(os.urandom(16)).decode()
        stream.sendall(
            f"GET {url.path}socket HTTP/1.1\r\nHost: {url.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        ask = b'{"channel":0,"doppler":true}'
        stream.sendall(bytes([0x81, 0x80 | len(ask), 0, 0, 0, 0]) + ask)
        stream.settimeout(0.5)
        while not stop.is_set():
            if not reads:
                stop.wait(0.2)
                continue
            try:
                if not stream.recv(1 << 20):
                    return
            except TimeoutError:
                pass
            except OSError:
                return


def measure(program, scenario, duration_s, pace, clients):
    """One run; its report."""
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", scenario, "--json", "--pace", pace, "--duration-s", str(duration_s)]
        command += ["--set", 'sink=[{kind="null"}]', "--set", 'stream.policy="drop"']
        if clients is not None:
            command += ["--monitor", "127.0.0.1:0"]
        run = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        stop, threads = threading.Event(), []
        for line in run.stderr:
            found = re.search(r"monitor: (http:\S+)", line)
            if found:
                for _ in range(abs(clients)):
                    threads.append(threading.Thread(target=client, args=(found[1], stop, clients > 0), daemon=True))
                    threads[-1].start()
        out = run.stdout.read()
        stop.set()
        for thread in threads:
            thread.join(2)
        if run.wait() != 0:
            raise SystemExit(f"the run failed: {' '.join(command)}")
        return json.loads(out.strip().splitlines()[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "target/release/nereus"))
    parser.add_argument("--scenario", default=str(ROOT / "configs/quickstart.toml"))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--duration-s", type=float, default=10.0, help="of a run in real time")
    parser.add_argument("--fast-duration-s", type=float, default=60.0, help="emission time of a run as fast as it can")
    args = parser.parse_args()
    runs = {(pace, name): [] for pace in ("realtime", "fast") for name in CASES}
    for turn in range(args.rounds):
        for pace, name in runs:
            duration_s = args.duration_s if pace == "realtime" else args.fast_duration_s
            report = measure(args.program, args.scenario, duration_s, pace, CASES[name])
            runs[pace, name].append(report)
        print(f"round {turn + 1} of {args.rounds}", flush=True)
    load = os.getloadavg()[1]
    print(f"\n{args.rounds} rounds of {args.duration_s:g} s in real time and {args.fast_duration_s:g} s fast of {Path(args.scenario).name}, {os.cpu_count()} cores, load {load:.1f}")
    print(f"\n{'in real time':24} {'dropped':>8} {'late':>6} {'p50 us':>8} {'p99 us':>20} {'speed':>7}")
    for name in CASES:
        reports = runs["realtime", name]
        p99 = [report["lateness_us"]["p99"] for report in reports]
        middle = lambda pick: statistics.median(pick(report) for report in reports)
        print(
            f"{name:24} {sum(r['dropped'] for r in reports):8d} {sum(r['late'] for r in reports):6d} "
            f"{middle(lambda r: r['lateness_us']['p50']):8.1f} {statistics.median(p99):8.1f} ({min(p99):.0f} to {max(p99):.0f})"
            f" {middle(lambda r: r['real_time_factor']):7.2f}"
        )
    print(f"\n{'as fast as it can':24} {'pulses a second':>16} {'ratio by turns':>15}")
    speed = lambda report: report["pulses"] / report["elapsed_s"]
    for name in CASES:
        reports = runs["fast", name]
        ratio = statistics.median(speed(a) / speed(b) for a, b in zip(reports, runs["fast", "no monitor"]))
        print(f"{name:24} {statistics.median(map(speed, reports)):16.1f} {ratio:15.3f}")


if __name__ == "__main__":
    main()
