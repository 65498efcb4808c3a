"""The program: `python -m nereus run configs/quickstart.toml`."""

import sys

from ._nereus import main


def run() -> int:
    """Runs the program with the arguments of this process and returns its exit code."""
    return main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(run())
