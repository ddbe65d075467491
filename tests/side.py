#!/usr/bin/python3
"""Runs a command on one half of the cores: threads that wait for each other by spinning would keep those of the other half
from running.

    tests/side.py 0|1 COMMAND [ARGUMENT...]
"""

import os
import sys

cores = sorted(os.sched_getaffinity(0))
os.sched_setaffinity(0, cores[int(sys.argv[1]) :: 2] or cores)
os.execvp(sys.argv[2], sys.argv[2:])
