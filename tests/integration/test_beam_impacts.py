"""The beam impacts with real YADE and FreeFEM, at larger windows and shorter than as published.

Reference numbers: modal superposition for Timoshenko's beam (data/beam_impact/make.py), Hertz (1882) in closed form, and
the energy that an exchange with a lag makes, which is first order in the window.
"""

import functools
import math
import os
import subprocess
import sys
import tempfile
import unittest

import numpy

from case import DONE, ENVIRONMENT, HOME, MISMATCH, PARTICIPANT, REFUSED, UNSTABLE, Case, change, copy_of_home, sets, together

SINGLE = os.path.join(HOME, "workflows", "beam_single_impact.yaml")
MULTIPLE = os.path.join(HOME, "workflows", "beam_multiple_impacts.yaml")
PEAK, CONTACT, REBOUND = 4.92213, 0.158851e-3, -2.98979e-3  # N, s, m/s: Timoshenko's beam
SHORT = dict(time_step="4e-7 s", end_time="0.2 ms")  # 500 windows; the contact lasts 0.159 ms


class SingleImpact(Case):
    """Runs that differ in one thing each."""

    VARIANTS = {
        "paper": {},
        "predicted": dict(wall_prediction="true"),
        "held": dict(force_in_window="last"),
        "parallel": dict(scheme="parallel-explicit"),
        "aitken": dict(scheme="serial-implicit", acceleration="aitken"),
        "iqn": dict(scheme="serial-implicit", acceleration="iqn-ils"),
        "solid": dict(dimension="3"),
        "solid_coarse": dict(dimension="3", wall_points=21, wall_points_across=7, time_step="8e-7 s"),
        "points": dict(continuum="mpm"),
        "subcycled": dict(time_step="8e-7 s", grain_steps=8, beam_steps=2, wall_prediction="true"),
        "short": dict(beam_length="120 mm", sphere_radius="8 mm", impact_velocity="50 mm/s"),
    }

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        calls = [functools.partial(cls.place.sandglass, "run", SINGLE, *sets(**{**SHORT, **variant}), out=name)
                 for name, variant in cls.VARIANTS.items()]
        calls += [functools.partial(cls.place.sandglass, "run", SINGLE, *sets(**{**SHORT, **cls.VARIANTS[name]}), "--no-prune",
                                    out=name + "_whole") for name in cls.WHOLE]
        cls.runs = dict(zip([*cls.VARIANTS, *(name + "_whole" for name in cls.WHOLE)], together(*calls)))

    # run once more with nothing left out
    WHOLE = ("paper", "points", "solid_coarse")  # of a solid with few points of the wall: YADE moves all of them in Python

    def assert_impact(self, name, force, contact, rebound):
        """One contact; relative tolerances of force and of the contact's end, and of the rebound over the impact."""
        run = self.runs[name]
        self.assert_code(run, DONE)
        peaks, intervals = run.quantity("contact_force_peaks"), run.quantity("contact_intervals")
        self.assertEqual((len(peaks), len(intervals)), (1, 1))
        self.assertAlmostEqual(peaks[0] / PEAK, 1, delta=force)
        self.assertLess(abs(intervals[0][0]), 1e-9)
        self.assertAlmostEqual(intervals[0][1] / CONTACT, 1, delta=contact)
        self.assertAlmostEqual(run.quantity("rebound_velocity"), REBOUND, delta=rebound * 0.01)

    def test_one_contact_as_theory_has_it(self):
        # At 400 ns the lag of one window adds 0.35 % to the force (measured); without it 0.1 % is left.
        self.assert_impact("paper", 0.01, 0.015, 0.005)
        self.assert_impact("predicted", 0.002, 0.002, 0.002)
        self.assert_impact("subcycled", 0.002, 0.002, 0.002)
        self.assert_impact("solid", 0.02, 0.015, 0.01)

    def test_material_points(self):
        # Linear quadrilaterals of the paper's size are 1.3 % too stiff in the first frequency.
        self.assert_impact("points", 0.01, 0.015, 0.01)

    def test_another_beam_and_sphere(self):
        run = self.runs["short"]
        self.assert_code(run, DONE)
        compared = [one["name"] for one in run.result["comparisons"] if one["passed"]]
        self.assertIn("peak force, Timoshenko's beam", compared)
        self.assertIn("contacts", compared)

    def test_the_energy_made_tells_the_lag(self):
        for name, lag in (("paper", 1), ("held", 0.5), ("parallel", 2)):
            self.assert_code(self.runs[name], DONE)
            self.assertAlmostEqual(self.runs[name].quantity("exchange_lag"), lag, delta=0.05, msg=name)
            # 1.052e4 per second and window of lag by Euler-Bernoulli's beam.
            gain = self.runs[name].quantity("coupling_energy_gain")
            self.assertAlmostEqual(gain / (1.052e4 * lag * 4e-7), 1, delta=0.1, msg=name)
        for name in ("predicted", "aitken", "iqn"):
            self.assert_code(self.runs[name], DONE)
            self.assertLess(abs(self.runs[name].quantity("coupling_energy_gain")), 1e-4, name)

    def test_iterated_windows_agree_however_they_are_accelerated(self):
        forces = [self.runs[name].record["contact_force"] for name in ("aitken", "iqn")]
        numpy.testing.assert_allclose(*forces, atol=1e-6)
        self.assertGreater(self.runs["iqn"].record.iterations.max(), 1)

    def test_what_is_left_out_changes_nothing(self):
        for name in self.WHOLE:
            with self.subTest(name):
                pruned, whole = self.runs[name], self.runs[name + "_whole"]
                self.assert_code(whole, DONE)
                for field, values in pruned.record.fields.items():
                    numpy.testing.assert_array_equal(values, whole.record[field], field)
                self.assertEqual({one["name"] for one in pruned.result["left_out"]}, {"far_contact", "far_wall", "idle_beam"})
                self.assertEqual(whole.result["left_out"], [])

    def test_energies_are_recorded(self):
        record = self.runs["predicted"].record
        total = record["sphere_energy"].sum(1) + record["beam_energy"].sum(1)
        mass = 4 / 3 * math.pi * 0.01**3 * 7960
        # During the contact its energy is that of the wall as predicted: first order in the window, 0.35 % measured.
        numpy.testing.assert_allclose(total, mass * 0.01**2 / 2, rtol=5e-3)
        numpy.testing.assert_allclose(total[-50:], mass * 0.01**2 / 2, rtol=1e-4)
        self.assertGreater(record["sphere_energy"][:, 1].max(), 0.1 * total[0])


class Contact(Case):
    """YADE's contact with a wall that all but stands still: a beam a thousand million times denser."""

    def test_hertz_on_a_flat_wherever_the_sphere_strikes(self):
        rigid = dict(SHORT, beam_density=7.96e12)
        # On a node of the wall, which two of its segments share; between nodes; and next to one.
        runs = together(*(functools.partial(self.sandglass, "run", SINGLE, *sets(**rigid, impact_offset=offset), out="at" + str(i))
                          for i, offset in enumerate(("0 mm", "1.279 mm", "0.001 mm"))))
        mass, stiffness = 4 / 3 * math.pi * 0.01**3 * 7960, 4 / 3 * 2.157463e11 / (2 * (1 - 0.289**2)) * math.sqrt(0.01)
        depth = (1.25 * mass * 0.01**2 / stiffness) ** 0.4
        self.assertAlmostEqual(stiffness * depth**1.5, 7.083, delta=0.001)
        forces = [run.record["contact_force"][:, 0] for run in runs]
        # A sample up to half a step beside the peak lacks up to 3/16 a dt^2 / depth (a the largest deceleration), and the
        # integrator's own energy, E - dt^2/24 F^2/m where the sphere turns, adds 1/16 of the same: 1.4e-5 together.
        slack = stiffness * depth**1.5 / mass * 4e-7**2 / (4 * depth)
        for run, force in zip(runs, forces):
            self.assertAlmostEqual(force.max() / (stiffness * depth**1.5), 1, delta=slack)
            # Contact time 2.9432 depth / velocity (Hertz), found between samples.
            self.assertAlmostEqual(run.quantity("contact_intervals")[0][1] / (2.94317 * depth / 0.01), 1, delta=2e-4)
            self.assertAlmostEqual(run.quantity("rebound_velocity"), -0.01, delta=1e-6)
            numpy.testing.assert_allclose(force, forces[0], atol=1e-5)


class Extremes(Case):
    """Each ends with the right answer, or says what is wrong."""

    RIGHT = {
        "a sphere 1000 times stiffer": dict(sphere_young="215746.3 GPa"),
        "an impact at 100 metres a second": dict(impact_velocity="100 m/s", time_step="2e-8 s", end_time="0.03 ms"),
        "a rubber beam": dict(beam_young="5 MPa", beam_density=1100, beam_poisson=0.45, time_step="40 us", end_time="60 ms"),
        "a sphere 1000 times denser": dict(sphere_density=7.96e6, time_step="3.2 us", end_time="15 ms"),
        "a wide solid beam": dict(dimension=3, beam_width="30 mm", time_step="8e-7 s", end_time="0.3 ms"),
        "a thick beam and a small sphere": dict(beam_length="40 mm", beam_height="20 mm", sphere_radius="5 mm",
                                                time_step="2e-7 s", end_time="0.1 ms", elements_along=20, elements_through=8),
        # the beam's top lies 0.1 mm beyond nodes of the grid, its last points 0.013 mm
        "an all but empty cell": dict(continuum="mpm", spread_load="false", grid_height="25.48 mm", time_step="2e-7 s"),
        "material points of a solid": dict(continuum="mpm", dimension=3, grid_along=30, grid_through=7, grid_across=5,
                                           points_along=120, points_through=16, points_across=8, time_step="2.5e-7 s"),
        "material points of a low beam": dict(continuum="mpm", beam_height="5 mm", time_step="1e-6 s", end_time="0.3 ms"),
        "material points in triangles": dict(continuum="mpm", grid="triangular", time_step="2e-7 s"),
    }

    def test_right_answers(self):
        runs = together(*(functools.partial(self.sandglass, "run", SINGLE, out=name.replace(" ", "_"),
                                            *sets(**{**SHORT, "wall_prediction": "true", **changed}))
                          for name, changed in self.RIGHT.items()))
        for name, run in zip(self.RIGHT, runs):
            with self.subTest(name):
                self.assert_code(run, DONE)  # the workflow's own tolerances, beside beam theory
                self.assertEqual(run.quantity("contacts"), run.quantity("timoshenko_contacts"))
                self.assertLess(abs(run.quantity("coupling_energy_gain")), 2e-3)

    def test_a_lasting_contact_with_a_lag_is_ended(self):
        # By theory an oscillation of the contact grows by exp(43) while it lasts; 190 of 1172 windows were measured.
        run = self.sandglass("run", SINGLE, *sets(sphere_density=7.96e6, time_step="12.8 us", end_time="15 ms"), out="lasting")
        self.assert_code(run, UNSTABLE)
        self.assertRegex(run.err, r"window \d+: the coupling makes energy: the sum of field 'sphere_energy' and 'beam_energy' "
                                  r"is 2\.\d+ times its first value, 0\.\d+ % more in every window")
        self.assertLess(run.result["windows"], 400)

    def test_iterated_it_is_held_whatever_the_window(self):
        run = self.sandglass("run", SINGLE, *sets(sphere_density=7.96e6, time_step="51.2 us", end_time="15 ms",
                                                  scheme="serial-implicit", acceleration="iqn-ils"), out="held")
        self.assertIn(run.code, (DONE, MISMATCH))  # accuracy is another matter
        self.assertEqual(run.quantity("contacts"), 1)
        self.assertLess(abs(run.quantity("coupling_energy_gain")), 0.01)

    def test_material_points_take_the_steps_that_are_stable(self):
        # A window of 1 us is beyond the limit of an explicit step: sound crosses a cell of 30/13 mm in 0.424 us.
        run = self.sandglass("run", SINGLE, *sets(**{**SHORT, "continuum": "mpm", "time_step": "1e-6 s"}, wall_prediction="true"),
                             out="beyond", seconds=300)
        self.assert_code(run, DONE)
        self.assertIn("the beam takes 3 steps in every window", " ".join(note["text"] for note in run.result["notes"]))
        self.assertLess(abs(run.quantity("coupling_energy_gain")), 2e-3)

    def test_material_points_say_what_went_wrong(self):
        for name, changed, words in (
                ("threes", dict(points_along=483), "material points come in fours: 483 along"),
                ("empty", dict(spread_load="false", grid_height="25.948 mm"), "has a node without mass next to it"),
                ("leaves", dict(impact_velocity="200 m/s", grid_height="10.1 mm", grid_through=5, time_step="1e-7 s"),
                 "is outside the grid")):
            run = self.sandglass("run", SINGLE, *sets(**{**SHORT, "continuum": "mpm", **changed}), out=name)
            with self.subTest(name):
                self.assert_code(run, PARTICIPANT)
                self.assert_said(run, "point", words)


class MultipleImpacts(Case):
    def test_three_contacts(self):
        run = self.sandglass("run", MULTIPLE, *sets(time_step="8e-7 s", wall_prediction="true"), out="multiple")
        self.assert_code(run, DONE)
        intervals = numpy.array(run.quantity("contact_intervals"))
        expected = 1e-3 * numpy.array([[0, 0.44017], [1.33680, 1.79145], [2.80710, 3.25802]])
        self.assertEqual(intervals.shape, (3, 2))
        numpy.testing.assert_allclose(intervals, expected, rtol=0.02, atol=1e-6)
        peaks = run.quantity("contact_force_peaks")
        self.assertAlmostEqual(peaks[0] / 8.8708, 1, delta=0.02)
        numpy.testing.assert_allclose(peaks[1:], [11.6308, 6.6380], rtol=0.2)


class Kratos(Case):
    """The paper's own code, as another participant of the same workflow."""

    @unittest.skipUnless(os.path.exists(os.path.join(HOME, ".build", "solvers", "kratos", "bin", "python")),
                         "optional: ./sandglass setup kratos")
    def test_kratos_and_our_material_points_agree(self):
        same = dict(time_step="1e-6 s", end_time="20 us", points_along=240, points_through=16)
        kratos, ours = together(*(functools.partial(self.sandglass, "run", SINGLE, *sets(**same, **one), out=one["continuum"])
                                  for one in (dict(continuum="kratos"), dict(continuum="mpm", integration="implicit"))))
        self.assert_code(kratos, DONE)
        self.assert_code(ours, DONE)
        for field in ("contact_force", "beam_deflection"):
            values = ours.record[field]
            numpy.testing.assert_allclose(kratos.record[field], values, atol=1e-4 * abs(values).max(), err_msg=field)

    @unittest.skipIf(os.path.exists(os.path.join(HOME, ".build", "solvers", "kratos", "bin", "python")), "it is installed")
    def test_without_kratos_the_command_to_install_it_is_told(self):
        run = self.sandglass("run", SINGLE, *sets(**SHORT, continuum="kratos"), out="missing")
        self.assert_code(run, ENVIRONMENT)
        self.assert_said(run, "the optional solver 'kratos' is not installed", "./sandglass setup kratos")


class BadInput(Case):
    def test_geometry_that_cannot_be_is_refused_before_any_solver_starts(self):
        for wrong, words in ((dict(gap="-0.1 mm"), "'gap' is -0.1 mm"),
                             (dict(continuum="mpm", beam_height="40 mm"), "'beam_height', which is 40 mm"),
                             (dict(continuum="mpm", dimension=3, grid_beside="-1 mm"), "'grid_beside' is -1 mm")):
            run = self.sandglass("run", SINGLE, *sets(**wrong), out="refused")
            self.assert_code(run, REFUSED)
            self.assert_said(run, words)
            self.assertFalse(os.path.exists(run.path("logs")))

    def test_a_sphere_that_misses_the_beam(self):
        run = self.sandglass("run", SINGLE, *sets(**SHORT, impact_offset="100 mm"), out="missed")
        self.assert_failed(run, PARTICIPANT, "failed", windows=0)
        self.assert_said(run, "impact_offset 0.1 m: the sphere would miss the beam")

    def test_another_number_of_points_than_promised(self):
        home = copy_of_home(self.place, "points")
        change(os.path.join(home, "templates", "yade", "impact_on_wall_window.py"),
               ("sandglass.send('force', loads)", "sandglass.send('force', loads[:3])"))
        run = self.sandglass("run", SINGLE, *sets(**SHORT), out="fewer", home=home)
        self.assert_failed(run, PARTICIPANT, "failed", windows=0)
        self.assert_said(run, "field 'force' has 3 points, the beam exchanges 5")

    def test_a_force_that_is_not_a_number(self):
        home = copy_of_home(self.place, "nan")
        change(os.path.join(home, "templates", "yade", "impact_on_wall_window.py"),
               ("sandglass.send('force', loads)",
                "sandglass.send('force', [[float('nan')] * 3] * 5 if index == 7 else loads)"))
        run = self.sandglass("run", SINGLE, *sets(**SHORT), out="nan-run", home=home)
        self.assert_failed(run, UNSTABLE, "unstable", windows=6)
        self.assert_said(run, "participant grains, window 7", "field 'force'", "not a number")


class Reference(unittest.TestCase):
    def test_the_stored_curves_are_what_the_program_makes(self):
        folder = os.path.join(HOME, "data", "beam_impact")
        with tempfile.TemporaryDirectory() as made:
            said = subprocess.run([sys.executable, "-B", os.path.join(folder, "make.py"), made], check=True,
                                  capture_output=True, text=True).stdout
            names = sorted(name for name in os.listdir(folder) if name.endswith(".csv"))
            self.assertEqual(sorted(os.listdir(made)), names)
            for name in names:
                ours, stored = (numpy.loadtxt(os.path.join(where, name), delimiter=",", skiprows=2)
                                for where in (made, folder))
                size = abs(stored).max(axis=0)
                numpy.testing.assert_allclose(ours / size, stored / size, atol=1e-6, err_msg=name)
        for printed in ("4.92214", "0.158851", "-2.98979", "8.87081", "1.79145", "3.25802"):
            self.assertIn(printed, said)


if __name__ == "__main__":
    unittest.main()
