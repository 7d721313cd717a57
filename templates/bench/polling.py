"""A stand-in for the way ICY couples, to compare with: a sphere that settles, one window after the other.

    python3 polling.py WINDOWS INTERVAL          prints the seconds of each window

As the paper describes it (Pirnia and others, ICY, section 2.2): for every window the program that drives the continuum
calls a client in a process of its own; what it asks for starts YADE anew, with the values as text; YADE leaves a text file;
a reader waits for that file, looking every INTERVAL seconds. The continuum is Stokes' law here, at no cost, where ICY has
COMSOL solve; the client's TCP connection is left out; and YADE starts faster here than by its own launcher. So this is
cheaper than ICY was. How often ICY looks is not in the paper.
"""

import math
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
RESULT = "result.txt"
VISCOSITY, DIAMETER, WINDOW = 1e-3, 1e-4, 1e-3


def read_result():
    with open(RESULT) as file:
        return [float(word) for word in file.read().split()]


def client(arguments):
    """Starts YADE for one window and does not wait for it."""
    environment = dict(os.environ, SANDGLASS_SCRIPT=os.path.join(HERE, "polling_sphere.py"), BENCH_VALUES=" ".join(arguments))
    with open("yade.log", "ab") as log:
        subprocess.Popen([sys.executable, os.path.join(HERE, "..", "yade", "resident.py")], env=environment, stdout=log,
                         stderr=log)


def coordinate(windows, interval):
    position = velocity = 0.0
    for index in range(1, windows + 1):
        begin = time.perf_counter()
        drag = -3 * math.pi * VISCOSITY * DIAMETER * velocity
        values = [repr(value) for value in (position, velocity, drag, WINDOW)]
        subprocess.run([sys.executable, os.path.abspath(__file__), "client", *values], check=True)
        while not os.path.exists(RESULT):
            time.sleep(interval)
        position, velocity = read_result()
        os.remove(RESULT)
        print(repr(time.perf_counter() - begin), flush=True)


if sys.argv[1] == "client":
    client(sys.argv[2:])
else:
    coordinate(int(sys.argv[1]), float(sys.argv[2]))
