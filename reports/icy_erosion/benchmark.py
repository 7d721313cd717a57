#!/usr/bin/env python3
"""What moving the beads of the erosion test costs, and what coupling adds: one scene in several ways.

    SANDGLASS_BINARY=... SANDGLASS_HOME=... /usr/bin/python3 reports/icy_erosion/benchmark.py FOLDER [NAME=VALUE...]
                                                                      [--windows COUNT] [--rounds COUNT] [--specimen SPECIMEN.H5]

The small scene, or with scale=full and the specimen that another run has made the full one.

Runs in FOLDER, one after another, those that are not there yet, and prints a table; benchmark.csv in FOLDER has it too. Only ratios mean something, and only
on a machine that does nothing else.

- orchestrated: `sandglass run`, YADE and FreeFEM, without checkpoints, because a state that is written is also loaded, and what
  follows differs in the last bits.
- one process: the very scripts of that run in one YADE, without orchestrator, exchange, record and checkpoints, the head from
  resistances in series in Python in the place of FreeFEM: what a hand-written program for this physics would be. The same with two
  OpenMP threads, each bound to a processor.
- plain: the same as one writes it first: YADE's own margin of neighbour lists (half the smallest radius), fallen beads left
  among the others, sides of triangles.
- LAMMPS on one rank, and on two.
"""

import argparse
import csv
import json
import os
import re
import statistics
import subprocess

import h5py

HOME = os.path.realpath(os.environ["SANDGLASS_HOME"])
BINARY = os.path.realpath(os.environ["SANDGLASS_BINARY"])
WORKFLOW = os.path.join(HOME, "workflows", "icy_erosion.yaml")
WINDOW = 0.05  # s

_words = argparse.ArgumentParser()
_words.add_argument("folder")
_words.add_argument("changed", nargs="*", metavar="NAME=VALUE")
_words.add_argument("--windows", type=int, default=3)
_words.add_argument("--rounds", type=int, default=3)
_words.add_argument("--specimen")
given = _words.parse_args()
FOLDER, WINDOWS = os.path.abspath(given.folder), given.windows
CHANGED = dict(word.split("=", 1) for word in given.changed)

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


def workflow():
    """The erosion test, with the specimen that was given, if one was, in the place of one that is made."""
    if not given.specimen:
        return WORKFLOW
    with open(WORKFLOW) as file:
        text = file.read()
    copied = "  specimen: {run: command, command: [cp, '%s', specimen.h5], makes: [specimen.h5]}\n  start:\n" % os.path.abspath(given.specimen)
    path = os.path.join(FOLDER, "workflow.yaml")
    with open(path, "w") as file:
        file.write(re.sub(r"(?s)  specimen:\n.*?  start:\n", copied, text))
    return path


def orchestrated(name, **parameters):
    out = os.path.join(FOLDER, name)
    settings = {"scale": "small", "checkpoint_every": 0, "window": "%g s" % WINDOW, "end_time": "%g s" % (WINDOW * WINDOWS), **CHANGED, **parameters}
    words = [word for key, value in settings.items() for word in ("--set", "%s=%s" % (key, value))]
    if not os.path.exists(os.path.join(out, "result.json")):
        subprocess.run([BINARY, "run", workflow(), *words, "--out", out], check=True, cwd=FOLDER, stdout=subprocess.DEVNULL)
    with h5py.File(os.path.join(out, "record.h5")) as file:
        eroded = file["fields"]["eroded"][:WINDOWS, 0].astype(int).tolist()
        timings = {name: values[:WINDOWS] for name, values in file["timings"].items()}
    # From the begin of the first window to the end of the last: both solvers, exchange, record; not the solvers' start and end.
    return out, timings["ended"][-1] - timings["began"][0], timings["grains"].sum(), eroded


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


def single(name, out, replaced, threads=1):
    answer = os.path.join(FOLDER, name + ".json")
    with open(os.path.join(out, "workflow.json")) as file:
        cells = json.load(file)["parameters"]
    path = os.path.join(FOLDER, name + ".py")
    with open(path, "w") as file:
        file.write(SINGLE.format(folder=FOLDER, scripts=script(out, "The coarse-grid erosion test", "One coupling window of"), replaced=replaced,
                                 start=os.path.join(out, "stages", "start", "start.h5"), half=cells["cell_top"]["value"] / cells["cells"]["value"] / 2, windows=WINDOWS, window=WINDOW,
                                 answer=answer))
    environment = dict(os.environ, SANDGLASS_SCRIPT=path, SANDGLASS_THREADS=str(threads), PYTHONPATH=os.path.join(HOME, "templates", "python"),
                       OMP_NUM_THREADS=str(threads), OMP_PROC_BIND="true")
    environment.pop("SANDGLASS_COMMANDS", None)
    if not os.path.exists(answer):
        subprocess.run(["/usr/bin/python3", os.path.join(HOME, "templates", "yade", "resident.py")], check=True, env=environment,
                       cwd=FOLDER, stdout=subprocess.DEVNULL)
    with open(answer) as file:
        return json.load(file)


WAYS = ["plain YADE script, one process", "this YADE script, one process", "the same, two threads", "orchestrated, YADE", "orchestrated, LAMMPS, one rank",
        "orchestrated, LAMMPS, two ranks"]


def one_round(number):
    """Seconds of every way, beads fallen through in each, and the share of what is not the beads' work. Ways take turns, so that a
    machine that becomes slower does so for all."""
    if number % 2 == 0:  # neither of the two that are compared most closely always comes first
        single("one-process-%d" % number, os.path.join(FOLDER, "yade-1"), [])
    out, whole, grains, eroded = orchestrated("yade-%d" % number, dem="yade")
    alone = single("one-process-%d" % number, out, [])
    # Heads in Python and in FreeFEM differ by rounding, which beads that jostle soon feel: the same within counting scatter.
    if abs(sum(alone["eroded"]) - sum(eroded)) > 3 * (sum(alone["eroded"]) + sum(eroded) + 1) ** 0.5:
        raise SystemExit("one process is not the same physics: %s beads fell through, orchestrated %s" % (alone["eroded"], eroded))
    plain = single("plain-%d" % number, out, PLAIN)
    threads = single("two-threads-%d" % number, out, [], 2)
    seconds = [plain["seconds"], alone["seconds"], threads["seconds"], whole]
    fallen = [plain["eroded"], alone["eroded"], threads["eroded"], eroded]
    for ranks in (1, 2):
        _, took, _, fell = orchestrated("lammps-%d-%d" % (ranks, number), dem="lammps", ranks=ranks)
        seconds.append(took)
        fallen.append(fell)
    return alone["steps"], seconds, fallen, (whole - grains) / whole


def median_of(values, digits):
    """With the range, where there is one."""
    text = "%.*f" % (digits, statistics.median(values))
    return text if len(values) == 1 else text + " (%.*f to %.*f)" % (digits, min(values), digits, max(values))


def main():
    os.makedirs(FOLDER, exist_ok=True)
    rounds = [one_round(number) for number in range(1, given.rounds + 1)]
    steps = rounds[0][0]
    table = [("way", "steps/s", "over plain YADE", "beads fallen through")]
    for way, name in enumerate(WAYS):
        table.append((name, median_of([steps / seconds[way] for _, seconds, _, _ in rounds], 1),
                      median_of([seconds[0] / seconds[way] for _, seconds, _, _ in rounds], 2), " ".join(map(str, rounds[0][2][way]))))
    table.append(("orchestrated over one process, YADE, seconds", "", median_of([seconds[3] / seconds[1] for _, seconds, _, _ in rounds], 3), ""))
    table.append(("FreeFEM, exchange and record over the whole window", "", median_of([share for *_, share in rounds], 4), ""))
    table.append(("two ranks over one, LAMMPS", "", median_of([seconds[4] / seconds[5] for _, seconds, _, _ in rounds], 2), ""))
    with open(os.path.join(FOLDER, "benchmark.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(table)
    for row in table:
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
