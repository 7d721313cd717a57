"""YADE and LAMMPS on single beads of ICY's erosion test: the same contact law, friction, damping and step.

Both are leapfrog. A specimen's velocity is to YADE that of half a step before its positions, to LAMMPS that of the same
time: here LAMMPS is given the one that YADE will have. Local damping looks at the sign of force times velocity; YADE takes
the velocity in the middle of the step to come, LAMMPS half a step earlier, so they differ in the steps in which it turns.
"""

import math
import os
import re
import unittest

import h5py
import numpy

from case import DONE, HOME, Case, read, sets, together

WORKFLOW = os.path.join(HOME, "workflows", "icy_erosion.yaml")
INSTALLED = os.path.exists(os.path.join(HOME, ".build", "solvers", "lammps", "installed"))
HANG = 600.0  # s, of programs that other work on the machine holds up
FINE, COARSE = 0.173e-3, 1.5e-3
WEIGHT = 9.80665 * (1 - 1000 / 2500)  # m/s2, less buoyancy
STEP = FINE * math.sqrt(2500 * 100 / 1e7)


@unittest.skipUnless(INSTALLED, "LAMMPS is not installed: ./sandglass setup lammps")
class SingleBeads(Case):
    def trajectories(self, name, beads, windows, acceleration=(0, 0, -WEIGHT), damping=0.0, friction="17.19 deg",
                     section=6e-3, sides="walls"):
        """Positions [windows, beads, 3] by both engines, one step a window. beads: place and velocity of fine ones; a
        coarse one rests far away, because the scene has one."""

        def run(dem):
            # The acceleration of the first step, by which the two ideas of the first velocity differ.
            ahead = numpy.array(acceleration) * STEP / 2 if dem == "lammps" else 0
            with h5py.File(self.place.join("%s-%s.h5" % (name, dem)), "w") as file:
                file["position"] = [(4e-3, 4e-3, 20e-3)] + [place for place, velocity in beads]
                file["velocity"] = [numpy.zeros(3)] + [numpy.array(velocity, dtype=float) + ahead for place, velocity in beads]
                file["spin"] = numpy.zeros((len(beads) + 1, 3))
                file["radius"] = [COARSE] + [FINE] * len(beads)
                file["fallen"] = numpy.zeros((1, 2))
                file.attrs.update(section=section, density=2500.0, mass_per_fine=4 / 3 * math.pi * FINE**3 * 2500, porosity_fine=0.5,
                                  fines_lost=0, fall_rate=0.0, coarse_top=21.5e-3)
            text = re.sub(r"(?s)  specimen:\n.*?  start:\n", "  specimen: {run: command, command: [cp, '%s', specimen.h5], "
                          "makes: [specimen.h5]}\n  start:\n" % file_path(self, name, dem), read(WORKFLOW))
            return self.run_workflow(text, *sets(
                scale="small", dem=dem, drag="none", damping=damping, friction_angle=friction, window=repr(STEP),
                end_time=repr(windows * STEP), record_positions="true", reinsertion="false",
                section=repr(section), sides=sides), name=name + "-" + dem, seconds=HANG)

        answers = []
        for ended in together(lambda: run("yade"), lambda: run("lammps")):
            self.assert_code(ended, DONE)
            answers.append(ended.record["position"][:, 1 : len(beads) + 1])
        return answers

    def assert_alike(self, yade, lammps, tolerance=1e-9):
        moved = abs(yade - yade[0]).max()
        self.assertGreater(moved, 1e-6, "nothing moved: the test says nothing")
        self.assertLess(abs(yade - lammps).max() / moved, tolerance)

    def test_a_bead_falls(self):
        # Damped weight: 0.6 of it, all the way down.
        yade, lammps = self.trajectories("fall", [((3e-3, 3e-3, 15e-3), (0, 0, 0))], 60,
                                         acceleration=(0, 0, -0.6 * WEIGHT), damping=0.4)
        self.assert_alike(yade, lammps)
        time = STEP * numpy.arange(1, 61)
        numpy.testing.assert_allclose(yade[:, 0, 2], 15e-3 - 0.6 * WEIGHT * (time**2 + time * STEP) / 2, rtol=1e-12)

    def test_two_beads_meet(self):
        yade, lammps = self.trajectories("meet", [((2.8e-3, 3e-3, 15e-3), (0.1, 0, 0)),
                                                  ((3.2e-3, 3.1e-3, 15.05e-3), (-0.1, 0, 0))], 90, friction="0 deg")
        self.assert_alike(yade, lammps)
        self.assertLess(abs(yade[-1, 0, 0] - yade[-2, 0, 0]), 0.09 * STEP, "they met")

    def test_a_bead_meets_a_side_wall(self):
        yade, lammps = self.trajectories("side", [((0.25e-3, 3e-3, 15e-3), (-0.1, 0.05, 0.0))], 90, friction="0 deg")
        self.assert_alike(yade, lammps)
        self.assertGreater(yade[-1, 0, 0], yade[:, 0, 0].min() + 1e-6, "it came back")

    def test_two_beads_meet_over_a_periodic_side(self):
        # YADE needs a section of more than two coarse beads; its beads go on through their copies, so places are taken into one.
        yade, lammps = self.trajectories("periodic", [((0.1e-3, 3e-3, 15e-3), (-0.1, 0.02, 0)), ((7.6e-3, 3e-3, 15e-3), (0.1, 0, 0))], 120,
                                         friction="0 deg", section=8e-3, sides="periodic")
        moved = [(place[..., 0] - place[0, :, 0] + 4e-3) % 8e-3 - 4e-3 for place in (yade, lammps)]
        self.assert_alike(moved[0], moved[1])
        numpy.testing.assert_allclose(yade[..., 1:], lammps[..., 1:], rtol=0, atol=1e-9 * abs(moved[0]).max())
        self.assertGreater(moved[0][-1, 0], moved[0][:, 0].min() + 1e-6, "they met, and the first one came back")

    def test_friction_differs_by_the_overlap_over_the_radius(self):
        # YADE lets friction turn a bead about the middle of the overlap, LAMMPS about the undeformed surface.
        mass = 4 / 3 * math.pi * FINE**3 * 2500 * 100
        for name, speed in (("fast", 0.1), ("slow", 0.02)):
            gap = 2 * speed * STEP  # one step of two before they touch
            yade, lammps = self.trajectories("friction_" + name, [((FINE + gap, 3e-3, 15e-3), (-speed, speed / 2, 0.0))], 90)
            overlap = speed * math.sqrt(mass / (1e7 * FINE))
            self.assert_alike(yade, lammps, tolerance=overlap / FINE / 2)
            self.assertGreater(abs(yade - lammps).max() / abs(yade - yade[0]).max(), 1e-9, "the explanation is not needed")

    def test_a_bead_meets_the_plate(self):
        # Away from the borders between facets, over which YADE counts a contact twice.
        probe = self.trajectories("probe", [((3e-3, 3e-3, 15e-3), (0, 0, 0))], 1)
        self.assertEqual(len(probe), 2)
        with h5py.File(self.place.join("probe-yade-run", "stages", "plate", "plate.h5")) as file:
            triangles = file["triangles"][..., :2]
        x = numpy.linspace(2.5e-3, 3.5e-3, 41)
        points = numpy.column_stack((numpy.repeat(x, 3), numpy.tile([1.9e-3, 2e-3, 2.1e-3], 41)))
        place = max(points, key=lambda point: distance_to_edges(point, triangles))
        self.assertGreater(distance_to_edges(place, triangles), 0.07e-3)
        yade, lammps = self.trajectories("plate", [((*place, 0.25e-3), (0, 0, -0.1))], 60, friction="0 deg")
        self.assert_alike(yade, lammps)
        self.assertGreater(yade[-1, 0, 2], yade[:, 0, 2].min() + 1e-6, "it came back")

    def test_damping_differs_only_where_the_velocity_turns(self):
        yade, lammps = self.trajectories("damped", [((0.25e-3, 3e-3, 15e-3), (-0.1, 0.0, 0.0))], 90, damping=0.4,
                                         acceleration=(0, 0, -0.6 * WEIGHT))
        turns = int(yade[:, 0, 0].argmin())
        self.assert_alike(yade[: turns - 1], lammps[: turns - 1])
        # One step of damping in another direction: twice 0.4 of the largest acceleration, for one step.
        softest = abs(numpy.diff(yade[:, 0, 0], 2)).max() / STEP**2
        allowed = 2 * 0.4 * softest * STEP * STEP * (90 - turns + 1)
        self.assertLess(abs(yade - lammps).max(), allowed)


def distance_to_edges(point, triangles):
    """The shortest distance of a point from any side of any triangle, all in a plane."""
    begin, along = triangles, numpy.roll(triangles, -1, axis=1) - triangles
    part = numpy.clip(((point - begin) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return numpy.linalg.norm(point - begin - part[..., None] * along, axis=-1).min()


def file_path(case, name, dem):
    return case.place.join("%s-%s.h5" % (name, dem))


if __name__ == "__main__":
    unittest.main()
