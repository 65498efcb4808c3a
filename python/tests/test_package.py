"""What the package promises by itself: types, names, its program."""

import subprocess
import sys
from pathlib import Path

from scenes import ROOT

import nereus


def test_every_name_is_there_and_typed():
    folder = Path(nereus.__file__).parent
    assert (folder / "py.typed").is_file()
    for name in set(nereus.__all__) - {"distributed"}:
        assert getattr(nereus, name).__doc__ or name == "__version__", name


def test_the_stub_names_what_the_engine_has():
    stub = (Path(nereus.__file__).parent / "_nereus.pyi").read_text()
    for kind in (nereus.Pulse, nereus.Platform, nereus.Antenna, nereus.Ship, nereus.Stream, nereus.Reception):
        for name in vars(kind):
            if not name.startswith("__"):
                assert f"def {name}(" in stub, f"{kind.__name__}.{name}"


def test_the_program_runs():
    run = subprocess.run([sys.executable, "-m", "nereus", "--version"], capture_output=True, text=True)
    assert run.returncode == 0 and run.stdout.startswith("nereus ")
    run = subprocess.run([sys.executable, "-m", "nereus", "run", "none.toml"], capture_output=True, text=True)
    assert run.returncode == 2 and "cannot read scenario" in run.stderr


def _features(package: str, edges: str) -> dict[str, set[str]]:
    """Features of every dependency."""
    words = ["cargo", "tree", "--locked", "--offline", "-p", package, "--prefix", "none", "-e", edges, "-f", "{p}|{f}"]
    run = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    found: dict[str, set[str]] = {}
    for line in run.stdout.splitlines():
        name, _, features = line.removesuffix(" (*)").partition("|")
        found.setdefault(name, set()).add(features)
    return found


def test_dependencies_have_the_features_of_the_librarys_tests():
    # Otherwise the library is built twice: once for its tests, and once for the package.
    library, package = _features("nereus", "normal,build,dev"), _features("nereus-python", "normal,build")
    other = {name: (package[name], library[name]) for name in set(library) & set(package) if not package[name] <= library[name]}
    assert not other, "features for python/Cargo.toml to add (the package's, the library's)"
