#!/usr/bin/env python3
"""The full-size curves side by side, from the runs that are kept beside this file: /usr/bin/python3 reports/icy_erosion/curves.py

Draws curves.png and curves.svg (eroded mass beside what ICY printed and what was measured; the drag of every cell over the
buoyant weight of the beads in it) and writes curves.csv, a table of the same masses every 2.5 s. Where a run ended because nothing
fell through any more, its line goes on dotted.
"""

import csv
import json
import os

import matplotlib
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

HERE = os.path.dirname(os.path.abspath(__file__))
CASES = {"coupled": "five cells", "none": "no flow", "constant": "constant drag", "two_cells": "two cells"}
STYLES = ["-", "--", "-."]  # by seed
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"]
GRAM_PER_CM2 = 10.0  # kg/m2


def curve(run, name):
    path = os.path.join(HERE, run, "stages", "analyse", name + ".csv")
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(line for line in file if not line.startswith("#"))][1:]
    return numpy.array(rows, dtype=float).T


def read(run, name):
    with open(os.path.join(HERE, run, name), encoding="utf-8") as file:
        return json.load(file)


def stopped(run):
    """Whether nothing fell through any more in its last windows, as many as end a run."""
    quiet = read(run, "workflow.json")["coupling"]["rest"]["windows"]
    mass = curve(run, "eroded_mass_per_area")[1]
    return len(mass) > quiet and mass[-1] == mass[-1 - quiet]


def strength(run):
    """Times, and for every cell its drag over the buoyant weight of its beads, both at the begin of a window."""
    given = {name: one["value"] for name, one in read(run, "workflow.json")["parameters"].items()}
    thickness = given["cell_top"] / given["cells"]  # m
    for cell in range(1, given["cells"] + 1):
        time, share = curve(run, "head_share_%d" % cell)
        ended, porosity = curve(run, "porosity_%d" % cell)
        count = min(len(time) - 1, len(ended))  # the first window began with the specimen's porosity, which is not among these
        loss = share[1 : count + 1] * given["head"]  # m of water
        excess = given["density"] / given["fluid_density"] - 1
        yield time[1 : count + 1], loss / ((1 - porosity[:count]) * thickness * excess)


def main():
    # The first seed's folders have the names of their cases.
    runs = {case if seed == 0 else "%s_%d" % (case, seed + 1): (case, seed) for case in CASES for seed in range(len(STYLES))}
    runs = {run: which for run, which in runs.items() if os.path.exists(os.path.join(HERE, run, "result.json"))}
    labels = {run: "%s, seed %d" % (CASES[case], seed + 1) for run, (case, seed) in runs.items()}
    matplotlib.rcParams["svg.hashsalt"] = "curves"  # the same names in the file whenever it is drawn
    figure = Figure(figsize=(11, 4.4), dpi=125, layout="constrained")
    mass, drag = figure.subplots(1, 2)
    masses = {}
    for run, (case, seed) in runs.items():
        colour = COLOURS[list(CASES).index(case)]
        masses[run] = curve(run, "eroded_mass_per_area")
        time, value = masses[run][0], masses[run][1] / GRAM_PER_CM2
        mass.plot(time, value, color=colour, linestyle=STYLES[seed], linewidth=2, label=labels[run])
        if stopped(run):
            mass.plot([time[-1], 48], [value[-1]] * 2, color=colour, linestyle=":", linewidth=1)
            mass.plot(time[-1], value[-1], "|", color=colour, markersize=9, markeredgewidth=2)
    first = next(iter(runs))
    for name, marker, label in (("icy_five_cells", "o", "ICY, five cells (printed end)"), ("icy_two_cells", "s", "ICY, two cells (printed end)"),
                                ("icy_constant_drag", "D", "ICY, constant drag (printed stop)")):
        time, value = curve(first, name)
        mass.plot(time, value / GRAM_PER_CM2, marker, color="#3b4650", fillstyle="none", label=label)
    time, value = curve(first, "experiment_settlement")
    near = time <= 62
    mass.plot(time[near], value[near] / GRAM_PER_CM2, ".", color="#8a96a3", label="test 971121, by settlement")
    mass.set(xlabel="time (s)", ylabel="eroded mass per area (g/cm²)", xlim=(0, 60), ylim=(0, None))
    if "coupled" in runs:
        for cell, ((time, ratio), colour) in enumerate(zip(strength("coupled"), COLOURS), 1):
            drag.plot(time, ratio, color=colour, linewidth=2, label="cell %d" % cell)
        drag.axhline(1, color="#8a96a3", linewidth=1, linestyle=":")
        drag.set(xlabel="time (s)", ylabel="drag over buoyant weight, five cells, seed 1", ylim=(0, None), xlim=(0, None))
    for axes in (mass, drag):
        axes.grid(color="#e6eaee")
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
    FigureCanvasAgg(figure).print_png(os.path.join(HERE, "curves.png"))
    figure.savefig(os.path.join(HERE, "curves.svg"), metadata={"Date": None})

    last = max(values[0][-1] for values in masses.values())
    with open(os.path.join(HERE, "curves.csv"), "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time (s)"] + ["%s (g/cm2)" % label for label in labels.values()])
        for when in numpy.arange(2.5, last + 1e-9, 2.5):
            row = ["%.4f" % (numpy.interp(when, *masses[run]) / GRAM_PER_CM2) if when <= masses[run][0][-1] + 1e-9 or stopped(run) else ""
                   for run in runs]
            table.writerow(["%g" % when] + row)


if __name__ == "__main__":
    main()
