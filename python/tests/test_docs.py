"""The front page and the manuals: blocks of README.md, docs/python.md and docs/scale-out.md, in order."""

import os

import pytest
from scenes import ROOT


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for shared in ("configs", "hulls"):
        os.symlink(ROOT / shared, tmp_path / shared)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(name, count, space):
    """The first blocks of a page."""
    page = (ROOT / name).read_text()
    blocks = [rest.split("```")[0] for rest in page.split("```py\n")[1:]]
    assert len(blocks) >= count
    for block in blocks[:count]:
        line = page[: page.index(block)].count("\n")
        exec(compile("\n" * line + block, name, "exec"), space)


def test_the_front_page_runs(folder, capsys):
    assert (ROOT / "README.md").read_text().count("```py\n") == 1
    run("README.md", 1, {})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [str(pulse) for pulse in range(20)]
    assert all(line.endswith(" us after the emission") for line in lines)


def test_the_manual_runs(folder):
    blocks = (ROOT / "docs/python.md").read_text().count("```py\n")
    assert blocks >= 7
    run("docs/python.md", blocks, {})


def test_scaling_out_runs(folder):
    distributed = pytest.importorskip("distributed")
    text = (ROOT / "configs/errors.toml").read_text()
    (folder / "flight.toml").write_text(text)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            # What follows needs a Slurm: tools/slurm.
            space = {"__name__": "__main__", "client": client}
            run("docs/scale-out.md", 2, space)
    assert space["ds"].sizes["pulse"] == space["scene"].pulse_count
    assert space["found"].shape == (20, 2)
