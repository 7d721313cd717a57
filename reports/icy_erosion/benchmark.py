#!/usr/bin/env python3
"""What moving the beads of the erosion test costs, and what coupling adds: the small scene in several ways.

    SANDGLASS_BINARY=... SANDGLASS_HOME=... /usr/bin/python3 reports/icy_erosion/benchmark.py FOLDER [WINDOWS [NAME=VALUE...]]

Runs in FOLDER, one after another, and prints a table; benchmark.csv in FOLDER has it too. Only ratios mean something, and only
on a machine that does nothing else.

- orchestrated: `sandglass run`, YADE and FreeFEM, without checkpoints, because a state that is written is also loaded, and what
  follows differs in the last bits.
- one process: the very scripts of that run in one YADE, without orchestrator, exchange, record and checkpoints, the head from
  resistances in series in Python in the place of FreeFEM: what a hand-written program for this physics would be.
- plain: the same as one writes it first: YADE's own margin of neighbour lists (half the smallest radius), fallen beads left
  among the others, sides of triangles.
- LAMMPS on one rank, and on two.
"""

import csv
import json
import os
import subprocess
import sys

import h5py

HOME = os.path.realpath(os.environ["SANDGLASS_HOME"])
BINARY = os.path.realpath(os.environ["SANDGLASS_BINARY"])
WORKFLOW = os.path.join(HOME, "workflows", "icy_erosion.yaml")
FOLDER = os.path.abspath(sys.argv[1])
WINDOWS = int(sys.argv[2]) if len(sys.argv) > 2 else 3
CHANGED = dict(word.split("=", 1) for word in sys.argv[3:])
WINDOW = 0.05  # s

# Runs the set-up and then the windows, with a stand-in for the participant. PLAIN replaces texts of the set-up.
SINGLE = '''
import json, os, time
import numpy
from sandglass_column import WATER_WEIGHT, kozeny_carman

os.chdir({folder!r})
texts = [open(name).read() for name in {scripts!r}]
for old, new in {replaced!r}:
    assert old in texts[0], old
    texts[0] = texts[0].replace(old, new)


class Window:
    pass


class Alone:
    """In the place of the participant: the head from resistances in series, K linear between the centres of cells."""

    def __init__(self):
        import h5py

        self.window, self.sent = Window(), {{}}
        with h5py.File({start!r}, "r") as file:
            self.sent["porosity"], self.sent["specific_surface"] = file["porosity"][...], file["specific_surface"][...]

    def wants(self, name):
        return name != "position"

    def send(self, name, values):
        self.sent[name] = values

    def receive(self, name):
        k = kozeny_carman(self.sent["porosity"], self.sent["specific_surface"], density)
        border = numpy.concatenate((k[:1], (k[1:] + k[:-1]) / 2, k[-1:]))

        def part(a, b):
            u = (b - a) / a
            near = abs(u) < 1e-6
            return {half!r} / a * numpy.where(near, 1 - u / 2, numpy.log1p(u) / numpy.where(near, 1, u))

        series = part(border[:-1], k) + part(k, border[1:])
        total = series.sum() + 0.019 / 0.00134
        return {{"pressure_difference": WATER_WEIGHT * 0.23 * series / total, "fine_gradient": [0.23 / total / 0.00134]}}[name]


sandglass = Alone()
exec(compile(texts[0], "setup", "exec"), globals())
_begin, _eroded = time.monotonic(), []  # names that no script has
_code = compile(texts[1], "window", "exec")
for _index in range(1, {windows} + 1):
    sandglass.window.index = _index
    exec(_code, globals())
    _eroded.append(int(sandglass.sent["eroded"]))
with open({answer!r}, "w") as file:
    json.dump({{"seconds": time.monotonic() - _begin, "steps": round({window!r} / O.dt) * {windows}, "eroded": _eroded}}, file)
'''
PLAIN = [("verletDist=verlet_distance, targetInterv=-1, ", ""),
         ("forget_fallen, plane_sides, needed_functors = True, True, True", "forget_fallen, plane_sides, needed_functors = False, False, False")]


def orchestrated(name, **parameters):
    out = os.path.join(FOLDER, name)
    words = [word for key, value in dict(scale="small", checkpoint_every=0, window="%g s" % WINDOW, end_time="%g s" % (WINDOW * WINDOWS), **CHANGED, **parameters).items()
             for word in ("--set", "%s=%s" % (key, value))]
    subprocess.run([BINARY, "run", WORKFLOW, *words, "--out", out], check=True, cwd=FOLDER, stdout=subprocess.DEVNULL)
    with h5py.File(os.path.join(out, "record.h5")) as file:
        eroded = file["fields"]["eroded"][:WINDOWS, 0].astype(int).tolist()
    with open(os.path.join(out, "provenance.json")) as file:
        timings = json.load(file)["timings"]
    # All windows from the first to the last: both solvers, exchange, record; not the start of the solvers.
    return out, timings["stages"]["couple"] - timings["start"], timings["participants"]["grains"], eroded


def script(out, *beginnings):
    """The rendered scripts of a run, told apart by their first lines."""
    found = []
    for words in beginnings:
        for name in sorted(os.listdir(os.path.join(out, "scripts"))):
            path = os.path.join(out, "scripts", name)
            with open(path) as file:
                if words in file.read(200):
                    found.append(path)
    return found


def single(name, out, replaced):
    answer = os.path.join(FOLDER, name + ".json")
    path = os.path.join(FOLDER, name + ".py")
    with open(path, "w") as file:
        file.write(SINGLE.format(folder=FOLDER, scripts=script(out, "The coarse-grid erosion test", "One coupling window of"), replaced=replaced,
                                 start=os.path.join(out, "stages", "start", "start.h5"), half=10e-3 / 10, windows=WINDOWS, window=WINDOW,
                                 answer=answer))
    environment = dict(os.environ, SANDGLASS_SCRIPT=path, SANDGLASS_THREADS="1", PYTHONPATH=os.path.join(HOME, "templates", "python"),
                       OMP_NUM_THREADS="1")
    environment.pop("SANDGLASS_COMMANDS", None)
    subprocess.run(["/usr/bin/python3", os.path.join(HOME, "templates", "yade", "resident.py")], check=True, env=environment, cwd=FOLDER,
                   stdout=subprocess.DEVNULL)
    with open(answer) as file:
        return json.load(file)


def main():
    os.makedirs(FOLDER, exist_ok=True)
    rows = []
    out, whole, grains, eroded = orchestrated("yade", dem="yade")
    alone = single("one-process", out, [])
    # Heads in Python and in FreeFEM differ by rounding, which beads that jostle soon feel: the same within counting scatter.
    if abs(sum(alone["eroded"]) - sum(eroded)) > 3 * (sum(alone["eroded"]) + sum(eroded) + 1) ** 0.5:
        raise SystemExit("one process is not the same physics: %s beads fell through, orchestrated %s" % (alone["eroded"], eroded))
    steps = alone["steps"]
    plain = single("plain", out, PLAIN)
    rows.append(("plain YADE script, one process", plain["seconds"], plain["eroded"]))
    rows.append(("this YADE script, one process", alone["seconds"], alone["eroded"]))
    rows.append(("orchestrated, YADE", whole, eroded))
    for ranks in (1, 2):
        _, seconds, _, fallen = orchestrated("lammps-%d" % ranks, dem="lammps", ranks=ranks)
        rows.append(("orchestrated, LAMMPS, ranks: %d" % ranks, seconds, fallen))
    first = rows[0][1]
    table = [("way", "steps/s", "over plain YADE", "beads fallen through")]
    table += [(name, "%.1f" % (steps / seconds), "%.2f" % (first / seconds), " ".join(map(str, fell))) for name, seconds, fell in rows]
    table.append(("orchestrated over one process, YADE", "", "%.3f" % (whole / alone["seconds"]), ""))
    table.append(("FreeFEM, exchange and record over the whole window", "", "%.4f" % ((whole - grains) / whole), ""))
    table.append(("two ranks over one, LAMMPS", "", "%.2f" % (rows[3][1] / rows[4][1]), ""))
    with open(os.path.join(FOLDER, "benchmark.csv"), "w", newline="") as file:
        csv.writer(file).writerows(table)
    for row in table:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
