"""Beam theory of an impact: a step and modes that suffice, whatever the sphere and the beam."""

import math
import os
import unittest

from stand_in import TEMPLATES

with open(os.path.join(TEMPLATES, "analysis", "modal_beam.py"), encoding="utf-8") as file:
    exec(file.read())

YOUNG, POISSON, DENSITY, SIDE, VELOCITY = 215.7463e9, 0.289, 7960.0, 0.01, 0.01


def struck(radius, length=0.1535, end=2e-3, density=DENSITY, modes=None, step=None):
    mass = 4 / 3 * math.pi * radius**3 * density
    spring = hertz_stiffness(radius, YOUNG, POISSON, YOUNG, POISSON)
    contact = 2.94 * (1.25 * mass * VELOCITY**2 / spring) ** 0.4 / VELOCITY
    modes = modes or modes_for(length, SIDE, SIDE, YOUNG, DENSITY, contact)
    beam = Beam(length, SIDE, SIDE, YOUNG, POISSON, DENSITY, length / 2, "timoshenko", modes)
    step = step or min(contact / 1000, end / 100)
    return converged_impact(beam, spring, mass, VELOCITY, end, step), impact(beam, spring, mass, VELOCITY, end, step)


class ModalBeam(unittest.TestCase):
    def test_a_large_sphere_is_followed_in_shorter_steps(self):
        converged, once = struck(0.2, end=6e-3)
        self.assertGreater(once["energy"], 0.05, "the test would not see the step")
        self.assertLess(converged["energy"], 1e-3)
        finer, _ = struck(0.2, end=6e-3, step=(converged["time"][1] - converged["time"][0]) / 4)
        self.assertAlmostEqual(converged["force"].max() / finer["force"].max(), 1, delta=5e-3)

    def test_the_papers_sphere_needs_no_shorter_ones(self):
        converged, once = struck(0.01, end=1e-3)
        self.assertEqual(converged["force"].tobytes(), once["force"].tobytes())

    def test_what_would_take_too_long_is_not_defined(self):
        beam = Beam(0.1535, SIDE, SIDE, YOUNG, POISSON, DENSITY, 0.07, "timoshenko", 100)
        self.assertIsNone(converged_impact(beam, 1e12, 1e4, VELOCITY, 50e-3, 5e-4, most=2000))

    def test_a_long_beam_has_more_modes(self):
        few, _ = struck(0.01, length=10, end=0.3e-3, modes=100)
        chosen, _ = struck(0.01, length=10, end=0.3e-3)
        many, _ = struck(0.01, length=10, end=0.3e-3, modes=2000)
        self.assertGreater(abs(few["sphere_velocity"][-1] / many["sphere_velocity"][-1] - 1), 0.3)
        self.assertAlmostEqual(chosen["sphere_velocity"][-1] / many["sphere_velocity"][-1], 1, delta=1e-3)


if __name__ == "__main__":
    unittest.main()
