"""Beads in a vertical column of flow cells: porosity, specific surface, conductivity, and coarse-grid drag.

    column = Column(borders, area, density, cut=True)
    porosity, specific_surface = column.contents(z, radius)
    force = column.drag(z, radius, pressure_difference, split="volume")

Cell k lies between the horizontal planes borders[k] and borders[k + 1]. With `cut`, a bead that a plane cuts counts in
every cell with the part that lies there; otherwise all of it counts where its centre is. The same rule shares out the drag,
so the forces of a cell add up to its pressure difference times the area, to rounding. Overlaps at contacts count twice.
SI units throughout.
"""

import numpy

__all__ = ["Column", "kozeny_carman", "loose_places", "WATER_WEIGHT"]

WATER_WEIGHT = 9806.65  # N/m3, of water of 1000 kg/m3 under standard gravity


class Column:
    """Cells one above the other, of one horizontal area.

    borders: heights of the planes between the cells, rising [cells + 1], m. area: m2. density: of the beads, kg/m3.
    """

    def __init__(self, borders, area, density, cut=True):
        self.borders = numpy.asarray(borders, dtype=float)
        if len(self.borders) < 2 or not (numpy.diff(self.borders) > 0).all():
            raise ValueError("a column needs two borders or more, rising: %s" % self.borders)
        self.area, self.density, self.cut = area, density, cut
        self.heights = numpy.diff(self.borders)

    def parts(self, z, radius):
        """The volume (m3) and the surface (m2) that each bead has in each cell, [cells, beads]."""
        z, radius = numpy.asarray(z, dtype=float), numpy.asarray(radius, dtype=float)
        if self.cut:
            # Above a sphere's lowest point, up to x radii: volume pi R^3 (x^2 - x^3/3), surface 2 pi R^2 x (Archimedes).
            x = numpy.clip((self.borders[:, None] - z) / radius + 1, 0, 2)
            return (numpy.pi * radius**3 * numpy.diff(x**2 - x**3 / 3, axis=0),
                    2 * numpy.pi * radius**2 * numpy.diff(x, axis=0))
        below, above = self.borders[:-1, None], self.borders[1:, None]
        inside = (z >= below) & (z < above)
        return inside * (4 / 3 * numpy.pi * radius**3), inside * (4 * numpy.pi * radius**2)

    def contents(self, z, radius):
        """Porosity and specific surface (grain surface over grain mass, m2/kg; 0 without beads) of each cell."""
        volume, surface = (part.sum(axis=1) for part in self.parts(z, radius))
        porosity = 1 - volume / (self.area * self.heights)
        full = volume > 0
        specific_surface = numpy.zeros(len(volume))
        specific_surface[full] = surface[full] / (self.density * volume[full])
        return porosity, specific_surface

    def drag(self, z, radius, pressure_difference, split="volume"):
        """The drag on each bead, N, positive where the pressure difference (Pa, top minus bottom, hydrostatic part
        taken off) of its cells is: ICY equation 11, dU V / ((1 - n) dz), or the same shared by surface.
        """
        volume, surface = self.parts(z, radius)
        part = {"volume": volume, "surface": surface}[split]
        total = part.sum(axis=1)
        share = numpy.divide(pressure_difference * self.area, total, out=numpy.zeros(len(total)), where=total > 0)
        return share @ part


def kozeny_carman(porosity, specific_surface, density):
    """Hydraulic conductivity in m/s (Chapuis and Aubertin 2003): sqrt(10) e^3 / (D^2 S^2 (1 + e)), with the void ratio
    e, the grains' density over that of water D, and the specific surface S in m2/kg.
    """
    return numpy.sqrt(10) * porosity**3 / ((1 - porosity) * density / 1000 * specific_surface) ** 2


def loose_places(count, radius, width, base, porosity, random):
    """Places for `count` beads of this radius between the sides of a square of this width (its corner at the origin),
    from the height `base` upward, m [count, 3]. Each bead has a box of its own, in which it lies anywhere, so none touch
    as long as `porosity`, of the whole cloud, is about 0.5 or more; in the last layer the boxes are taken at random.
    """
    diameter = 2 * radius
    volume = numpy.pi / 6 * diameter**3 / (1 - porosity)
    per_side = int(width / max(diameter, numpy.cbrt(volume)))
    if per_side < 1:
        raise ValueError("a bead of radius %g m does not fit on a width of %g m" % (radius, width))
    side = width / per_side
    box = numpy.array([side, side, max(diameter, volume / side**2)])
    layers = max(1, -(-count // per_side**2))
    sites = numpy.concatenate([layer * per_side**2 + random.permutation(per_side**2) for layer in range(layers)])[:count]
    layer, site = numpy.divmod(sites, per_side**2)
    corners = numpy.column_stack((site % per_side, site // per_side, layer)) * box
    return corners + radius + random.random((count, 3)) * (box - diameter) + [0, 0, base]
