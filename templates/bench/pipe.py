"""The cheapest exchange there is, to compare with: raw bytes through a pipe, back and forth.

    python3 pipe.py COUNT        COUNT doubles, from descriptor SANDGLASS_COMMANDS to SANDGLASS_REPLIES
"""

import os
import sys

import numpy

commands, replies = (int(os.environ[name]) for name in ("SANDGLASS_COMMANDS", "SANDGLASS_REPLIES"))
values = numpy.zeros(int(sys.argv[1]))
memory = memoryview(values).cast("B")

with open(commands, "rb", buffering=0) as source:
    while True:
        got = 0
        while got < len(memory):
            count = source.readinto(memory[got:])
            if not count:
                sys.exit(0)
            got += count
        sent = 0
        while sent < len(memory):
            sent += os.write(replies, memory[sent:])
