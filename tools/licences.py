#!/usr/bin/env python3
"""Prints the licences of all that is linked into a program: crates, and HDF5 and zlib within them.

    tools/licences.py --features hdf5-static [--package nereus] > LICENCES.md

Texts are those in the sources of each crate, as cargo has fetched them; equal texts are printed once. A crate without a
text is listed by its licence's name. Exit 1: a crate names no licence.
"""

import argparse
import json
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

NAMES = re.compile(r"(LICEN[CS]E|COPYING|COPYRIGHT|NOTICE|UNLICENSE)", re.IGNORECASE)
# Sources of others within crates.
WITHIN = {"hdf5-metno-src": ["ext/hdf5"], "libz-sys": ["src/zlib"]}


def linked(package: str, features: list[str], target: str) -> set[tuple[str, str]]:
    """Names and versions of what is linked, without what only builds."""
    words = ["cargo", "tree", "--locked", "--package", package, "--edges", "normal,no-proc-macro", "--prefix", "none"]
    words += ["--format", "{p}", "--target", target, *features]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    lines = (line.split() for line in run.stdout.splitlines() if line.strip())
    return {(words[0], words[1].removeprefix("v")) for words in lines}


def texts(folder: Path, name: str) -> list[str]:
    """Licence texts of a crate, one spelling of blanks."""
    found = []
    for place in [folder, *(folder / inner for inner in WITHIN.get(name, []))]:
        files = sorted(file for file in place.iterdir() if file.is_file() and NAMES.match(file.name))
        found += [file.read_text(encoding="utf-8", errors="replace").strip() for file in files]
    return ["\n".join(line.rstrip() for line in text.splitlines()) for text in found if text]


def main() -> int:
    """Prints the page."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--package", default="nereus")
    arguments.add_argument("--features", default="")
    arguments.add_argument("--no-default-features", action="store_true")
    arguments.add_argument("--target", default="x86_64-unknown-linux-gnu")
    asked = arguments.parse_args()
    features = ["--features", asked.features] if asked.features else []
    features += ["--no-default-features"] if asked.no_default_features else []

    words = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", asked.target, *features]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    wanted = linked(asked.package, features, asked.target)
    crates = [crate for crate in json.loads(run.stdout)["packages"] if (crate["name"], crate["version"]) in wanted]
    crates = sorted((crate for crate in crates if crate["source"]), key=lambda crate: (crate["name"], crate["version"]))

    users = defaultdict(list)
    print(f"# Licences of what {asked.package} is built of\n")
    print("| crate | licence | source |\n| --- | --- | --- |")
    nameless = []
    for crate in crates:
        folder = Path(crate["manifest_path"]).parent
        licence = crate["license"] or (f"see {crate['license_file']}" if crate["license_file"] else None)
        if licence is None:
            nameless.append(crate["name"])
        title = f"{crate['name']} {crate['version']}"
        print(f"| {title} | {licence or '?'} | {crate['repository'] or ''} |")
        for text in texts(folder, crate["name"]):
            users[text].append(title)
    for text, names in users.items():
        print(f"\n## {', '.join(sorted(set(names)))}\n\n~~~text\n{text}\n~~~")
    if nameless:
        print(f"licences: without a licence: {', '.join(nameless)}", file=sys.stderr)
    return 1 if nameless else 0


if __name__ == "__main__":
    sys.exit(main())
