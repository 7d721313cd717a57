"""The worked example of workflows/README.md, 'Adding a scene': real YADE and FreeFEM on a scene that is YAML and templates.

The exact solution is computed here a second time, so that the analysis is tested as well.
"""

import math
import os
import re
import shutil
import unittest

import numpy

from case import DONE, HOME, MISMATCH, PARTICIPANT, REFUSED, Case, change, copy_of_home, read, sets

WORKFLOW = os.path.join(HOME, "workflows", "sphere_on_membrane.yaml")
STIFFNESS_ERROR = 1e-6  # of the finite elements, as the workflow promises
DEFAULT = dict(diameter=10e-3, density=7850, gravity=9.80665, tension=100, contact_radius=2e-3, rim_radius=0.1, window=2.5e-3)


def theory(diameter, density, gravity, tension, contact_radius, rim_radius, window):
    """Stiffness (N/m), static depth (m), and leapfrog's phase per window (rad)."""
    mass = density * 4 / 3 * math.pi * (diameter / 2) ** 3
    stiffness = 2 * math.pi * tension / math.log(rim_radius / contact_radius)
    return stiffness, mass * gravity / stiffness, 2 * math.asin(math.sqrt(stiffness / mass) * window / 2)


class WorkedExample(Case):
    def assert_exact(self, ended, parameters):
        self.assert_code(ended, DONE)
        stiffness, static_depth, phase = theory(**parameters)
        frequency = phase / parameters["window"] / (2 * math.pi)
        for name, value in (("stiffness", stiffness), ("static_depth", static_depth), ("frequency", frequency)):
            self.assertAlmostEqual(ended.quantity(name) / value, 1, delta=STIFFNESS_ERROR, msg=name)
            self.assertAlmostEqual(ended.quantity(name + "_theory") / value, 1, delta=1e-12, msg=name + "_theory")
        self.assertLess(ended.quantity("amplitude_drift"), 1e-9)
        self.assertEqual([one["passed"] for one in ended.result["comparisons"]], [True] * 4)

        record = ended.record
        depth, reaction = record["depth"][:, 0], record["reaction"][:, 0]
        turns = phase * numpy.arange(1, record.windows + 1)
        # An error e of the stiffness changes the depth by e and the phase by e/2.
        allowed = static_depth * STIFFNESS_ERROR * (2 + turns[-1] / 2)
        self.assertLess(numpy.abs(depth - static_depth * (1 - numpy.cos(turns))).max(), allowed)
        numpy.testing.assert_allclose(reaction, stiffness * depth, rtol=STIFFNESS_ERROR)

    def test_as_committed(self):
        ended = self.sandglass("run", WORKFLOW, out="committed")
        self.assert_exact(ended, DEFAULT)
        self.assertEqual(ended.result["windows"], 40)
        self.assertTrue(os.path.exists(ended.path("figures", "depth.svg")))

    def test_references_follow_the_parameters(self):
        other = dict(DEFAULT, diameter=20e-3, density=2000, tension=400, rim_radius=0.05, window=1e-3)
        ended = self.sandglass("run", WORKFLOW, *sets(**other), out="other")
        self.assert_exact(ended, other)

    def test_another_tension_in_freefem_only_is_a_mismatch(self):
        path = shutil.copy(WORKFLOW, self.place.join("tension.yaml"))
        change(path, ("given: [tension, contact_radius, rim_radius, elements]",
                      "given: [{tension: 101 N/m}, contact_radius, rim_radius, elements]"))
        ended = self.sandglass("run", path, out="tension")
        self.assert_failed(ended, MISMATCH, "mismatch", windows=40)
        passed = {one["name"]: one["passed"] for one in ended.result["comparisons"]}
        self.assertEqual(passed, {"stiffness of the membrane": False, "static depth": False, "frequency": False,
                                  "amplitude drift": True})
        self.assertAlmostEqual(ended.quantity("stiffness") / theory(**DEFAULT)[0], 1.01, delta=2 * STIFFNESS_ERROR)

    def test_a_window_that_is_too_long_is_a_mismatch(self):
        ended = self.sandglass("run", WORKFLOW, *sets(window="12 ms"), out="unstable")  # 2 sqrt(m/k) is 10.1 ms
        self.assert_failed(ended, MISMATCH, "mismatch")
        self.assertFalse(ended.comparison("frequency")["passed"])
        self.assertIsNone(ended.quantity("frequency"))


class Misspelt(Case):
    """What workflows/README.md shows of errors is what the program says."""

    def setUp(self):
        home = copy_of_home(self.place, self.id())
        os.mkdir(os.path.join(home, "workflows"))
        shutil.copy(WORKFLOW, os.path.join(home, "workflows"))
        self.home = home
        readme = read(os.path.join(HOME, "workflows", "README.md"))
        section = readme.split("### When a name is misspelt")[1].split("\n## ")[0]
        self.shown = re.findall(r"(?m)^ {4,}(.+)$", section)

    def said(self, verb, code, path, *replacements, out=None):
        change(os.path.join(self.home, *path.split("/")), *replacements)
        ended = self.sandglass(verb, "workflows/sphere_on_membrane.yaml", home=self.home, directory=self.home, out=out)
        self.assert_code(ended, code)
        # The name of a rendered script depends on what is in it.
        return [re.sub(r" \(\S+/(scripts/\w+)-\w+\.py", r" (\1-....py", line) for line in (ended.err + ended.out).splitlines()]

    def assert_shown(self, lines):
        self.assertTrue(lines)
        for line in lines:
            self.assertIn(line.strip(), self.shown, "workflows/README.md does not show this line")

    def test_in_the_workflow(self):
        self.assert_shown(self.said(
            "check", REFUSED, "workflows/sphere_on_membrane.yaml", ("source: steel", "sorce: steel"),
            ("end: $end_time", "end: $end_tme"), ("to: membrane", "to: membran")))

    def test_in_a_template(self):
        self.assert_shown(self.said("check", REFUSED, "templates/freefem/membrane.edp", ("{{tension}}", "{{tention}}")))

    def test_a_field_in_a_script(self):
        lines = self.said("run", PARTICIPANT, "templates/yade/sphere_on_membrane_window.py",
                          ("receive('reaction')", "receive('raection')"), out="field")
        self.assert_shown([line for line in lines if line.startswith("sandglass: ")])

    def test_a_quantity_in_the_analysis(self):
        lines = self.said("run", PARTICIPANT, "templates/analysis/sphere_on_membrane.py",
                          ("quantity('stiffness'", "quantity('stifness'"), out="quantity")
        self.assert_shown([line for line in lines if line.startswith("sandglass: ")])

    def test_the_physics(self):
        lines = self.said("run", MISMATCH, "workflows/sphere_on_membrane.yaml",
                          ("given: [tension, contact", "given: [{tension: 101 N/m}, contact"), out="physics")
        self.assert_shown([line for line in lines if line.startswith("  OUTSIDE")])


if __name__ == "__main__":
    unittest.main()
