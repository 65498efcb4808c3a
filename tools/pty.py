#!/usr/bin/env python3
"""A serial line that is none: what comes on standard input can be read from a pseudo terminal.

    nereus nav play FILE file:/dev/stdout --force | tools/pty.py /tmp/gps

makes /tmp/gps, a link to the terminal, and takes it away at the end. As on a wire, bytes that nobody listens to are lost.

Exit 0: standard input has ended; 1: the link cannot be made.
"""
import os
import select
import sys
import tty


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    link = sys.argv[1]
    near, far = os.openpty()
    tty.setraw(far)
    try:
        os.symlink(os.ttyname(far), link)
    except OSError as error:
        print(f"pty.py: {error}", file=sys.stderr)
        return 1
    # Nobody holds the far end but those who listen.
    os.close(far)
    try:
        while piece := os.read(0, 4096):
            waits = select.poll()
            waits.register(near, select.POLLOUT)
            for _, event in waits.poll(0):
                if event & select.POLLOUT and not event & select.POLLHUP:
                    os.write(near, piece)
    except KeyboardInterrupt:
        pass
    finally:
        os.unlink(link)
    return 0


if __name__ == "__main__":
    sys.exit(main())
