"""Runs a participant's script in the private environment of an optional solver (`sandglass setup NAME`).

    command: [/usr/bin/python3, -m, sandglass_private, kratos]

The script is the one of SANDGLASS_SCRIPT. Where the solver is not installed, the orchestrator is told so.
"""

import os
import sys


def main(name):
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    python = os.path.join(root, ".build", "solvers", name, "bin", "python")
    if not os.path.exists(python):
        os.write(int(os.environ["SANDGLASS_REPLIES"]),
                 ("error %s is not installed: run './sandglass setup %s'\n" % (name, name)).encode())
        return 1
    os.execv(python, [python, os.environ["SANDGLASS_SCRIPT"]])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
