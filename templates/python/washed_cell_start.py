"""The state of one flow cell from which as many fines leave as enter, disturbed a little (start.h5)."""

import h5py
import numpy

from sandglass_column import kozeny_carman

coarse, fine = {{coarse_fraction}}, {{fine_fraction}}  # volume over that of the cell
coarse_diameter, fine_diameter = {{coarse_diameter}}, {{fine_diameter}}  # m
density, height, head = {{density}}, {{cell_height}}, {{head}}  # kg/m3, m, m
if coarse + fine >= 1:
    raise SystemExit("coarse_fraction and fine_fraction leave no room for the water: %g and %g" % (coarse, fine))


def contents(fine):
    """Porosity, and specific surface in m2/kg."""
    return 1 - coarse - fine, 6 * (coarse / coarse_diameter + fine / fine_diameter) / (density * (coarse + fine))


porosity, specific_surface = contents(fine)
resistance = height / kozeny_carman(porosity, specific_surface, density)  # s
share = resistance / (resistance + {{fine_thickness}} / {{fine_conductivity}})
# -d ln K / d(fine fraction): less room, and, with other sizes than the coarse ones, more surface.
slope = (3 - porosity) / (porosity * (1 - porosity)) + 2 * (
    (1 / fine_diameter) / (coarse / coarse_diameter + fine / fine_diameter) - 1 / (coarse + fine))

first = fine * (1 + {{disturbance}})
with h5py.File("start.h5", "w") as file:
    file["porosity"], file["specific_surface"] = [numpy.atleast_1d(one) for one in contents(first)]
    file["head_time"], file["head"] = [0.0], [head]
    file.attrs.update(fine=fine, first=first, gradient=head * share / height, share=share, slope=slope, porosity=porosity,
                      conductivity=height / resistance)
print("head share %.4g, gradient %.4g, -dlnK/dphi %.4g" % (share, head * share / height, slope))
