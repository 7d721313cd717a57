"""The coupling of ICY's erosion test where it is stiff or extreme: limits of the window, clogged cells, high heads, real glass.

The limits are shown on one cell with a prescribed law (washed_cell.yaml), coupled to the scene's own head solver; the rest on
the scene itself with few beads.
"""

import math
import os
import sys
import unittest

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration"))

from case import DONE, HOME, UNSTABLE, Case, sets, together

CELL = os.path.join(HOME, "workflows", "washed_cell.yaml")
SCENE = os.path.join(HOME, "workflows", "icy_erosion.yaml")


def contents(fine, coarse=0.61):
    """Conductivity of ICY's cell with this fraction of fine beads, m/s, written down a second time."""
    n = 1 - coarse - fine
    surface = 6 * (coarse / 3e-3 + fine / 0.346e-3) / (2500 * (1 - n))  # m2/kg
    void = n / (1 - n)
    return math.sqrt(10) * void**3 / (2.5**2 * surface**2 * (1 + void))


def share(fine):
    return 7.4e-3 / contents(fine) / (7.4e-3 / contents(fine) + 19e-3 / 0.00134)


class WashedCell(Case):
    def runs(self, *points):
        return together(*(lambda number=number, point=point: self.sandglass("run", CELL, *sets(**point), out="run%d-%d" % (
            len(points), number)) for number, point in enumerate(points)))

    def growth(self, window, exponent):
        """Of a disturbance of one window's map, by central differences of the map itself: no formula of the theory."""
        speed = 2e-4 / 0.05

        def after(fine):
            rate = speed * (share(fine) / share(0.05)) ** exponent / 7.4e-3
            return fine * math.exp(-rate * window) + 2e-4 / 7.4e-3 / rate * (1 - math.exp(-rate * window))

        self.assertAlmostEqual(after(0.05), 0.05, delta=1e-15)
        return (after(0.05 + 1e-6) - after(0.05 - 1e-6)) / 2e-6

    def test_fines_washed_through(self):
        calm, oscillating, growing = self.runs(dict(window="0.5 s"), dict(window="2.5 s"), dict(window="5 s"))
        self.assert_code(calm, DONE)
        self.assert_code(oscillating, DONE)
        self.assert_code(growing, UNSTABLE)
        self.assert_said(growing, "diverges", "alternating sign", "shorter window")
        self.assertFalse(any("oscillat" in note["text"] for note in calm.result.get("notes", [])))
        self.assertTrue(any("oscillat" in note["text"] for note in oscillating.result["notes"]))
        for ended, window in ((calm, 0.5), (oscillating, 2.5)):
            # The difference quotient is good to 1e-8; the run has distances up to 1e-4 of the fine fraction.
            self.assertAlmostEqual(ended.quantity("growth_per_window"), self.growth(window, 1), delta=1e-5)
        self.assertLess(self.growth(5, 1), -1)
        self.assertTrue(numpy.isfinite(growing.record["porosity"]).all())
        # The two limits, where the growth of the map is 0 and -1.
        for limit, growth in (("oscillates_beyond", 0), ("grows_beyond", -1)):
            window = calm.quantity(limit) / calm.quantity("window_ratio") * 0.5
            self.assertAlmostEqual(self.growth(window, 1), growth, delta=1e-7)

    def test_drag_by_relative_velocity(self):
        layer = dict(law="relative", coarse_fraction=0, fine_fraction=0.63, end_time="0.1 s")
        below, beyond = self.runs(dict(layer, window="1.1 ms"), dict(layer, window="1.25 ms"))
        self.assert_code(below, DONE)
        self.assert_code(beyond, UNSTABLE)
        relaxation = contents(0.63, 0) * 0.63 * 2500 / (0.37 * 9806.65)
        self.assertAlmostEqual(2 * relaxation, 1.17e-3, delta=0.01e-3)  # three digits, of stability.md iii-a in the issue
        self.assertAlmostEqual(below.quantity("growth_per_window"), 1 - 1.1e-3 / relaxation, delta=1e-7)


class Extremes(Case):
    """The scene with few beads in a layer so loose that the wall stops at once."""

    FEW = dict(scale="small", fine_beads=600, layer_porosity=0.95)

    def assert_sound(self, ended):
        self.assert_code(ended, DONE)
        for name, values in ended.record.fields.items():
            self.assertTrue(numpy.isfinite(values).all(), name)
        self.assertEqual(ended.quantity("beads_unaccounted"), 0)
        self.assertLess(ended.quantity("darcy_residual_max"), 1e-12)
        self.assertLess(ended.quantity("drag_balance_error_max"), 1e-10)

    def test_head_of_a_metre_and_cells_without_beads(self):
        # Coarse beads reach 10.9 mm: of ten cells up to 40 mm the upper ones hold falling beads or nothing at all.
        high, empty = together(
            lambda: self.sandglass("run", SCENE, *sets(head="1 m", window="0.02 s", end_time="0.04 s", **self.FEW), out="high", seconds=600),
            lambda: self.sandglass("run", SCENE, *sets(cells=10, cell_top="40 mm", window="0.02 s", end_time="0.04 s", **self.FEW),
                                   out="empty", seconds=600))
        self.assert_sound(high)
        self.assert_sound(empty)
        self.assertEqual(empty.record["porosity"][:, -1].tolist(), [1.0, 1.0])
        self.assertTrue(any("has no beads" in note["text"] for note in empty.result["notes"]))

    def test_real_glass(self):
        # 60 GPa instead of 0.01: the step is 77 times shorter.
        ended = self.sandglass("run", SCENE, *sets(young="60 GPa", window="0.2 ms", end_time="0.4 ms",
                                                        **dict(self.FEW, fine_beads=200)), out="glass", seconds=600)
        self.assert_sound(ended)


if __name__ == "__main__":
    unittest.main()
