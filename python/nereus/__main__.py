"""The program: `python -m nereus run configs/quickstart.toml`."""

import signal
import sys

from ._nereus import main


def run() -> int:
    """Runs the program with the arguments of this process and returns its exit code."""
    # Python's handler waits for Python code to go on: as in the program itself, Ctrl-C ends what has none of its own.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(run())
