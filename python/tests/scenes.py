"""The scene of the tests: made in milliseconds."""

from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def small() -> dict[str, Any]:
    return {
        "scene": {"duration_s": 1.0},
        "radar": {
            "carrier_hz": 10e9,
            "sample_rate_hz": 50e6,
            "prf_hz": 100.0,
            "channels": ["HH", "VV"],
            "noise_figure_db": 3.0,
            "waveform": {"kind": "lfm", "bandwidth_hz": 30e6, "pulse_s": 1e-6},
            "window": {"samples": 128, "start_us": 6.0},
        },
        "platform": [
            {"name": "mast", "track": {"kind": "fixed", "position_m": [0.0, 0.0, 30.0]}},
            {
                "name": "aircraft",
                "track": {"kind": "straight", "position_m": [0.0, 0.0, 300.0], "velocity_mps": [0.0, 60.0, 0.0]},
            },
        ],
        "transmitter": [{"name": "tx", "platform": "mast", "power_w": 100.0, "antenna": {"kind": "isotropic"}}],
        "receiver": [{"name": "rx", "platform": "aircraft", "antenna": {"kind": "isotropic"}}],
        "target": [{"name": "corner", "position_m": [1000.0, 0.0, 2.0], "rcs_m2": 100.0}],
    }
