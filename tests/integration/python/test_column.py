"""Cells of a column: contents and drag against sums that are done in another way, and against closed forms."""

import os
import sys
import unittest

import numpy

HOME = os.environ.get("SANDGLASS_HOME") or os.path.join(os.path.dirname(__file__), "..", "..", "..")
sys.path.insert(0, os.path.join(HOME, "templates", "python"))

from sandglass_column import Column, kozeny_carman, loose_places  # noqa: E402

RANDOM = numpy.random.default_rng(5)
RADIUS = numpy.where(RANDOM.random(400) < 0.1, 1.5e-3, 0.173e-3)
Z = RANDOM.uniform(-5e-3, 45e-3, 400)
BORDERS = numpy.linspace(0, 37e-3, 6)


class Cells(unittest.TestCase):
    def test_a_bead_in_halves(self):
        volume, surface = Column([0, 1e-3, 2e-3], 1e-4, 2500).parts([1e-3], [0.5e-3])
        whole = numpy.pi / 6 * 1e-9
        numpy.testing.assert_allclose(volume[:, 0], [whole / 2, whole / 2], rtol=1e-14)
        numpy.testing.assert_allclose(surface[:, 0], [numpy.pi / 2 * 1e-6] * 2, rtol=1e-14)

    def test_parts_against_slices_summed_up(self):
        planes = numpy.linspace(0, 37e-3, 5 * 20000 + 1)
        middle = (planes[1:] + planes[:-1]) / 2
        for z, radius in ((7.4e-3, 1.5e-3), (0.5e-3, 1.5e-3), (36.9e-3, 0.173e-3), (-2e-3, 1.5e-3)):
            disc = numpy.pi * numpy.clip(radius**2 - (middle - z) ** 2, 0, None) * numpy.diff(planes)
            volume, surface = Column(BORDERS, 1e-4, 2500).parts([z], [radius])
            # Discs 0.37 um thick: the square of that over the radius, at most.
            numpy.testing.assert_allclose(volume[:, 0], disc.reshape(5, -1).sum(1), atol=1e-5 * 4 * radius**3)

    def test_what_lies_within_the_column_is_all_counted(self):
        inside = (Z - RADIUS > 0) & (Z + RADIUS < BORDERS[-1])
        for cut in (True, False):
            volume, surface = Column(BORDERS, 1e-4, 2500, cut=cut).parts(Z[inside], RADIUS[inside])
            numpy.testing.assert_allclose(volume.sum(0), 4 / 3 * numpy.pi * RADIUS[inside] ** 3, rtol=1e-12)
            numpy.testing.assert_allclose(surface.sum(0), 4 * numpy.pi * RADIUS[inside] ** 2, rtol=1e-12)

    def test_specific_surface_of_equal_beads(self):
        porosity, surface = Column([0, 1], 1, 2500, cut=False).contents([0.5] * 10, [0.01] * 10)
        self.assertAlmostEqual(surface[0], 6 / (2500 * 0.02), delta=1e-12)
        self.assertAlmostEqual(porosity[0], 1 - 10 * 4 / 3 * numpy.pi * 1e-6, delta=1e-15)

    def test_an_empty_cell_is_all_pore(self):
        porosity, surface = Column([0, 1, 2], 1, 2500).contents([0.5], [0.1])
        self.assertEqual((porosity[1], surface[1]), (1, 0))

    def test_the_drag_of_a_cell_adds_up(self):
        difference = numpy.array([1.0, 30.0, 2.0, 500.0, 0.1])
        for cut in (True, False):
            for split in ("volume", "surface"):
                force = Column(BORDERS, 1e-4, 2500, cut=cut).drag(Z, RADIUS, difference, split)
                self.assertAlmostEqual(force.sum() / (difference.sum() * 1e-4), 1, delta=1e-12)

    def test_drag_is_equation_11(self):
        column = Column(BORDERS, 1e-4, 2500, cut=False)
        porosity, _ = column.contents(Z, RADIUS)
        force = column.drag(Z, RADIUS, numpy.full(5, 7.0))
        cell = numpy.searchsorted(BORDERS, Z) - 1
        for bead in numpy.flatnonzero((Z > 0) & (Z < BORDERS[-1]))[:50]:
            expected = 7.0 / ((1 - porosity[cell[bead]]) * 7.4e-3) * 4 / 3 * numpy.pi * RADIUS[bead] ** 3
            self.assertAlmostEqual(force[bead] / expected, 1, delta=1e-12)
        self.assertEqual(force[(Z < 0) | (Z > BORDERS[-1])].sum(), 0)

    def test_conductivity_of_the_fine_layer_as_icy_has_it(self):
        # 0.00134 m/s for 0.346 mm at a porosity of 0.37; three printed digits.
        self.assertAlmostEqual(kozeny_carman(0.37, 6 / (2500 * 0.346e-3), 2500), 0.00134, delta=0.5e-5)

    def test_loose_places_do_not_touch(self):
        for count, porosity in ((7, 0.8), (900, 0.55), (1, 0.7), (0, 0.7)):
            places = loose_places(count, 0.173e-3, 6e-3, 2e-3, porosity, numpy.random.default_rng(1))
            self.assertEqual(places.shape, (count, 3))
            apart = numpy.linalg.norm(places[:, None] - places, axis=2)[~numpy.eye(count, dtype=bool)]
            self.assertTrue((apart >= 0.346e-3 * (1 - 1e-12)).all())
            self.assertTrue(((places[:, :2] >= 0.173e-3) & (places[:, :2] <= 6e-3 - 0.173e-3)).all())
            self.assertTrue((places[:, 2] >= 2.173e-3 - 1e-15).all())


if __name__ == "__main__":
    unittest.main()
