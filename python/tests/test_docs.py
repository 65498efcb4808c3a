"""The manual: every block of docs/python.md, in order."""

import os

from scenes import ROOT


def test_the_manual_runs(tmp_path, monkeypatch):
    for shared in ("configs", "hulls"):
        os.symlink(ROOT / shared, tmp_path / shared)
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/python.md").read_text()
    blocks = [rest.split("```")[0] for rest in page.split("```py\n")[1:]]
    assert len(blocks) >= 7
    space: dict[str, object] = {}
    for block in blocks:
        line = page[: page.index(block)].count("\n")
        exec(compile("\n" * line + block, "docs/python.md", "exec"), space)
