"""What the flow needs before the first window: porosity and specific surface of the cells of the specimen, and the head
against time, on which the flow interpolates linearly (start.h5)."""

import csv

import h5py
import numpy

from sandglass_column import Column

cells, cell_top = {{cells}}, {{cell_top}}  # 1, m
head = {{head}}                            # m
{{#head_history.constant}}
history = [(0.0, head)]
{{/head_history.constant}}
{{#head_history.ramp}}
history = [(0.0, {{ramp_from}}), ({{ramp_time}}, head)]
{{/head_history.ramp}}
{{#head_history.test_971121}}
with open({{measured_head}}, newline="") as file:
    rows = [row for row in csv.reader(line for line in file if not line.startswith("#"))][1:]
history = [(float(row[0]), float(row[1])) for row in rows]  # s, m
{{/head_history.test_971121}}

with h5py.File({{specimen}}, "r", locking=False) as file:
    z, radius = file["position"][:, 2], file["radius"][...]
    area, density = file.attrs["section"] ** 2, file.attrs["density"]
column = Column(numpy.linspace(0, cell_top, cells + 1), area, density, cut={{cell_borders}} == "cut")
porosity, specific_surface = column.contents(z, radius)
if not (porosity > 0).all():
    raise SystemExit("a cell of the specimen has the porosity %g" % porosity.min())
with h5py.File("start.h5", "w") as file:
    file["porosity"], file["specific_surface"] = porosity, specific_surface  # 1, m2/kg
    file["head_time"], file["head"] = numpy.array(history).T                 # s, m
print("porosity of the cells, from below:", porosity.round(4))
