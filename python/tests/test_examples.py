"""The examples, small: the shortest always, all with NEREUS_ALL (tools/python --all)."""

import os
import subprocess
import sys

import pytest
from scenes import ROOT

EXAMPLES = ROOT / "python/examples"
SHORTEST = "stream_into_a_processor.py"


@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_an_example_runs(tmp_path, name):
    if name != SHORTEST and not os.environ.get("NEREUS_ALL"):
        pytest.skip("NEREUS_ALL=1 runs it")
    words = [sys.executable, str(EXAMPLES / name), "--small"]
    if name != SHORTEST:
        pytest.importorskip("matplotlib")
        words += ["--out", str(tmp_path / "picture.png")]
    run = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "agg"}, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()
    assert name == SHORTEST or (tmp_path / "picture.png").stat().st_size > 1000
