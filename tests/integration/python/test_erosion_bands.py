"""The erosion test over seeds: bands, what flow adds, and clogging, on runs made up here."""

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

from stand_in import PYTHON, render, write

WINDOW = 0.5  # s
UNIT = 0.25   # kg/m2 of one passage


class BandsTest(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)
        self.rows = []

    def add(self, drag, seed, eroded, exit_code=0, planned=None, dem="lammps", flow=None, reinsertion_seed=0):
        """`planned`: how many windows it was to have, where it ended before them. `flow`: porosities and pressure differences."""
        run = "%s-%s-%d-%d" % (dem, drag, seed, reinsertion_seed)
        folder = os.path.join(self.place.name, "points", run)
        os.makedirs(folder)
        windows = len(eroded)
        with h5py.File(os.path.join(folder, "record.h5"), "w") as file:
            file.attrs["filetype"] = "sandglass record"
            file.attrs["version"] = numpy.array([1, 0])
            file["windows"] = numpy.array([windows])
            file["time"] = WINDOW * numpy.array([[n, n + 1] for n in range(windows)])
            file["fields/eroded"] = numpy.array(eroded, dtype=float)[:, None]
            cells = ([[0.4] * 5] * windows, [[1.0] * 5] * windows) if flow is None else flow
            for name, values in zip(("porosity", "pressure_difference"), cells):
                file["fields/" + name] = numpy.array(values)
        self.rows.append({
            "name": run, "set": "", "label": run, "sample_of": drag, "repetition": 1, "expect": "done", "good": exit_code == 0,
            "run": os.path.join("..", "points", run), "exit_code": exit_code,
            "parameters": {"drag": drag, "seed": seed, "reinsertion_seed": reinsertion_seed, "dem": dem, "cells": 5, "cell_top": 0.05,
                           "density": 2500.0, "fluid_density": 1000.0, "gravity": 10.0, "window": WINDOW, "end_time": WINDOW * (planned or windows)},
            "quantities": {"eroded_mass_per_area": sum(eroded) * UNIT, "beads_unaccounted": 0.0}})

    def analyse(self, control_of="drag", control="none"):
        work = os.path.join(self.place.name, "summary", "stages", "bands")
        os.makedirs(work)
        write(os.path.join(self.place.name, "summary", "points.json"), json.dumps({"points": self.rows}))
        script = write(os.path.join(work, "bands.py"),
                       render("analysis/erosion_bands.py", {"control_of": control_of, "control": control,
                                                                  "clogged_below": 0.1, "clogged_for": 1.0}))
        done = subprocess.run([sys.executable, "-W", "error", script], cwd=work, env=dict(os.environ, PYTHONPATH=PYTHON),
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(work, "analysis.json")) as file:
            return json.load(file)

    def test_what_flow_adds_is_taken_seed_by_seed(self):
        # Seeds differ by far more than flow and no flow of one seed do.
        for seed, base, more in ((1, 10, 1), (2, 100, 2), (3, 1000, 6)):
            self.add("none", seed, [base] * 8)
            self.add("coupled", seed, [base] * 7 + [base + more])
        result = self.analyse()
        extra = UNIT * numpy.array([1, 2, 6])
        self.assertAlmostEqual(result["quantities"]["added_by_coupling"]["value"], extra.mean(), delta=1e-12)
        self.assertAlmostEqual(result["quantities"]["added_by_coupling_error"]["value"], extra.std(ddof=1) / math.sqrt(3), delta=1e-12)
        low, high = (float(text) for text in result["tables"][1]["rows"][0][4].split(" to "))
        self.assertAlmostEqual(high - low, 2 * 4.303 * extra.std(ddof=1) / math.sqrt(3) / 10, delta=2e-4)  # in g/cm2, four digits
        curves = result["curves"]
        self.assertEqual([curves["no_flow_LAMMPS_" + what]["y"]["values"][1] for what in ("lowest", "median", "highest")],
                         [10 * UNIT, 100 * UNIT, 1000 * UNIT])
        self.assertEqual(curves["added_coupled_5_cells_LAMMPS"]["y"]["values"][:8], [0.0] * 8)

    def test_a_control_is_one_of_the_same_seed(self):
        self.add("none", 1, [10] * 8)
        self.add("coupled", 2, [10] * 8)
        self.assertIsNone(self.analyse()["quantities"]["added_by_coupling"]["value"])

    def test_courses_of_one_specimen_are_pairs_of_their_own(self):
        for course, more in ((0, 1), (1, 2), (2, 6)):
            self.add("none", 1, [10 + course] * 8, reinsertion_seed=course)
            self.add("coupled", 1, [10 + course] * 7 + [10 + course + more], reinsertion_seed=course)
        result = self.analyse()
        extra = UNIT * numpy.array([1, 2, 6])
        self.assertAlmostEqual(result["quantities"]["added_by_coupling"]["value"], extra.mean(), delta=1e-12)
        self.assertAlmostEqual(result["quantities"]["added_by_coupling_error"]["value"], extra.std(ddof=1) / math.sqrt(3), delta=1e-12)
        self.assertEqual(result["tables"][0]["rows"][0][4], "%.4f" % (8 * UNIT / 10))  # standard deviation, g/cm2

    def test_programs_are_compared_seed_by_seed(self):
        for seed, base, more in ((1, 10, 1), (2, 100, -2), (3, 1000, 6)):
            self.add("coupled", seed, [base] * 8)
            self.add("coupled", seed, [base] * 7 + [base + more], dem="yade")
        result = self.analyse("dem", "lammps")
        extra = numpy.array([1, -2, 6])
        self.assertAlmostEqual(result["quantities"]["engines_apart"]["value"],
                               extra.mean() / (4.303 * extra.std(ddof=1) / math.sqrt(3)), delta=1e-12)
        self.assertNotIn("added_by_coupling", result["quantities"])
        self.assertEqual(result["tables"][1]["rows"][0][:2], ["coupled, 5 cells (YADE)", "3"])

    def test_clogging_and_when(self):
        # Two windows are the time looked at: the fifth and the sixth have together a tenth of 20 less one.
        self.add("none", 1, [5, 10, 10, 8, 1, 0, 0, 0])
        self.add("none", 2, [5, 10, 10, 8, 1, 1, 3, 5])  # down to a tenth, not below
        self.add("none", 3, [10, 10, 10], 4)  # ended badly: not looked at
        result = self.analyse()
        self.assertEqual(result["tables"][0]["rows"][0][-2:], ["1 of 2", "2.0"])
        self.assertEqual(result["quantities"]["clogged_share"]["value"], 0.5)
        self.assertEqual(result["curves"]["going_no_flow_LAMMPS"]["y"]["values"], [1] * 4 + [0.5] * 5)

    def test_a_run_that_came_to_rest_stays_as_it_is(self):
        self.add("none", 1, [10] * 8)
        self.add("coupled", 1, [10, 10, 10, 0, 0], planned=8)
        result = self.analyse()
        self.assertEqual(result["curves"]["coupled_5_cells_LAMMPS_median"]["y"]["values"], [UNIT * n for n in (0, 10, 20, 30, 30, 30, 30, 30, 30)])
        self.assertEqual(result["quantities"]["added_by_coupling"]["value"], -50 * UNIT)
        self.assertEqual(result["tables"][0]["rows"][1][-2:], ["1 of 1", "1.5"])

    def test_drag_over_weight_of_the_strongest_cell(self):
        # Cells of 10 mm under 10 m/s2 with a porosity of 0.4: 90 Pa of buoyant weight. A cell without beads has no drag to speak of.
        self.add("none", 1, [10] * 4)
        self.add("coupled", 1, [10, 10, 10], planned=4, flow=(
            [[0.4, 0.4, 0.4, 0.4, 1.0], [0.4, 0.7, 0.4, 0.4, 1.0], [0.1] * 5],
            [[9e9] * 5, [9.0, 45.0, 18.0, 9.0, 9e9], [45.0, 45.0, 9.0, 9.0, 9e9]]))
        curve = self.analyse()["curves"]["drag_coupled_5_cells_LAMMPS_median"]
        self.assertEqual(curve["x"]["values"], [0.5, 1.0, 1.5])
        for value, wanted in zip(curve["y"]["values"], [0.5, 1.0, 1.0]):  # the last window is one that the run did not need
            self.assertAlmostEqual(value, wanted, delta=1e-12)

    def test_too_short_to_tell(self):
        self.add("none", 1, [10, 0, 0])
        result = self.analyse()
        self.assertIsNone(result["quantities"]["clogged_share"]["value"])
        self.assertEqual(result["tables"][0]["rows"][0][-2], "too short to tell")


if __name__ == "__main__":
    unittest.main()
