#!/usr/bin/python3
"""Runs a command and passes its output on; ends it once it has printed nothing for ten minutes.

    tests/watchdog.py COMMAND [ARGUMENT...]

The only limit in seconds of the tests: a machine that is slow goes on printing, a test that hangs does not.
By the system's Python: a version manager's would change the environment of what it runs.
"""

import os
import select
import signal
import subprocess
import sys

SILENCE = 600
GRACE = 10
HANGS = 124


def main():
    # A session of its own: what the command has started ends with it.
    child = subprocess.Popen(
        sys.argv[1:], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )

    def end(*_):
        # Watchdogs among them end their own.
        os.killpg(child.pid, signal.SIGTERM)
        try:
            child.wait(GRACE)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
        sys.exit(HANGS)

    signal.signal(signal.SIGTERM, end)
    signal.signal(signal.SIGINT, end)
    while select.select([child.stdout], [], [], SILENCE)[0]:
        text = os.read(child.stdout.fileno(), 65536)
        if not text:
            return child.wait()
        sys.stdout.buffer.write(text)
        sys.stdout.buffer.flush()
    print(f"{' '.join(sys.argv[1:])} printed nothing for {SILENCE} seconds and was ended", flush=True)
    end()


if __name__ == "__main__":
    sys.exit(main())
