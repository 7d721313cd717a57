"""What the flow does to beads, and which of them are accounted for: python/erosion_flow.py, which both programs use."""

import os
import re
import sys
import tempfile
import unittest

import h5py
import numpy

from stand_in import PYTHON, TEMPLATES, write

sys.path.insert(0, PYTHON)
from sandglass_column import WATER_WEIGHT, Column  # noqa: E402

SECTION, FINE, COARSE = 6e-3, 0.346e-3, 3e-3


class FlowTest(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)
        # Well inside of two cells of 5 mm; the last fine bead is above them.
        self.position = numpy.array([[3e-3, 3e-3, 2.5e-3], [1e-3, 1e-3, 2e-3], [5e-3, 1e-3, 7e-3], [1e-3, 5e-3, 8e-3], [3e-3, 3e-3, 12e-3]])
        self.radii = numpy.array([COARSE, FINE, FINE, FINE, FINE]) / 2

    def names(self, drag, drag_split="volume", periodic=False):
        """The block's names, rendered for one drag; of sections with a choice the one of that name stays."""
        values = dict(cells=2, cell_top=10e-3, cell_borders="cut", drag_split=drag_split, fine_porosity=0.37,
                      start=os.path.join(self.place.name, "start.h5"))
        with open(os.path.join(TEMPLATES, "python", "erosion_flow.py")) as file:
            text = file.read()
        text = re.sub(r"\{\{#([\w.]+)\}\}\n(.*?)\{\{/\1\}\}\n", lambda match: match.group(2) if match.group(1) == "drag." + drag else "",
                      text, flags=re.DOTALL)
        text = re.sub(r"\{\{(\w+)\}\}", lambda match: repr(values[match.group(1)]), text)
        porosity, surface = Column([0, 5e-3, 10e-3], SECTION**2, 2500.0).contents(self.position[:, 2], self.radii)
        with h5py.File(values["start"], "w") as file:
            file["porosity"], file["specific_surface"] = porosity, surface
        path = write(os.path.join(self.place.name, "flow.py"), text)
        names = dict(numpy=numpy, h5py=h5py, Column=Column, WATER_WEIGHT=WATER_WEIGHT, density=2500.0, section=SECTION, periodic=periodic,
                     radii=self.radii, fine_diameter=0.4e-3, looser=None)
        with open(path) as file:
            exec(compile(file.read(), path, "exec"), names)
        return names

    def test_constant_drag_is_shared_by_volume_or_by_surface(self):
        for split, power in (("volume", 3), ("surface", 2)):
            force, total = self.names("constant", split)["drag_of"](self.position[:, 2], numpy.array([30.0, 20.0]), 0.0)
            self.assertAlmostEqual(total / (50.0 * SECTION**2), 1, delta=1e-12)
            self.assertEqual(force[-1], 0, "above the cells")
            self.assertAlmostEqual(force[0] / force[1] / (COARSE / FINE) ** power, 1, delta=1e-12)

    def test_constant_drag_acts_on_the_part_of_a_bead_that_lies_in_the_cells(self):
        drag_of = self.names("constant")["drag_of"]
        position = self.position.copy()
        inside, total = drag_of(position[:, 2], numpy.array([30.0, 20.0]), 0.0)
        position[0, 2] = 10e-3  # half of the coarse bead is above the cells
        half, less = drag_of(position[:, 2], numpy.array([30.0, 20.0]), 0.0)
        self.assertAlmostEqual(half[0] / inside[0], 0.5, delta=1e-12)
        numpy.testing.assert_array_equal(half[1:], inside[1:])
        self.assertAlmostEqual(less, half.sum(), delta=1e-12 * total)

    def test_who_left_beside_the_plate_is_not_accounted_for(self):
        for periodic, lost in ((False, 1), (True, 0)):
            names = self.names("none", periodic=periodic)
            inside = numpy.array([True, True, True, True, True])
            count = names["accounted_for"]
            self.assertEqual(count(self.position, inside, []), 4)
            inside[1] = False
            self.assertEqual(count(self.position, inside, [(1e-3, 1e-3, -3e-3)]), 3, "it fell through the plate")
            self.assertEqual(count(self.position, inside, [(-1e-4, 1e-3, -3e-3)]), 3 - lost, "it fell beside the plate")
            away = self.position.copy()
            away[2, 0] = SECTION + 1e-4
            self.assertEqual(count(away, inside, []), 3 - lost, "it is beside the column")


if __name__ == "__main__":
    unittest.main()
