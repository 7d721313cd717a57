"""How strong the flow is in a specimen before any bead moves: strength.py SPECIMEN.h5 [CELL_TOP in mm...]

Head 23 cm, five cells, conductivity linear between their centres, ICY's fine layer above. For every top of the cells (default: 37, 40.6
and the highest point of a coarse bead): the head lost in the cells, and the drag of each over the buoyant weight of its beads.
"""

import os
import sys

import h5py
import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "templates", "python"))
from sandglass_column import Column, kozeny_carman  # noqa: E402

HEAD, CELLS, FINE_LAYER = 0.23, 5, 19e-3 / 0.00134  # m, 1, s


def strength(place, radius, area, density, top):
    """Head lost in the cells, m, and drag over buoyant weight of each, from below."""
    column = Column(numpy.linspace(0, top, CELLS + 1), area, density)
    porosity, surface = column.contents(place, radius)
    height = top / CELLS
    parts = 4000  # of a cell; the resistance by the midpoint rule
    z = (numpy.arange(CELLS * parts) + 0.5) * height / parts
    conductivity = numpy.interp(z, (numpy.arange(CELLS) + 0.5) * height, kozeny_carman(porosity, surface, density))
    resistance = (height / parts / conductivity).reshape(CELLS, parts).sum(axis=1)
    loss = HEAD * resistance / (resistance.sum() + FINE_LAYER)
    return loss.sum(), loss / height / ((1 - porosity) * (density / 1000 - 1))


def main(path, *tops):
    with h5py.File(path, "r", locking=False) as file:
        place, radius = file["position"][:, 2], file["radius"][...]
        area, density, highest = file.attrs["section"] ** 2, file.attrs["density"], file.attrs["coarse_top"]
    for top in [float(one) * 1e-3 for one in tops] or [37e-3, 40.6e-3, highest]:
        loss, drag = strength(place, radius, area, density, top)
        print("cells up to %.1f mm: %.1f mm of %.0f lost in them; drag over buoyant weight, from below: %s"
              % (1e3 * top, 1e3 * loss, 1e3 * HEAD, ", ".join("%.2f" % one for one in drag)))


if __name__ == "__main__":
    main(*sys.argv[1:])
