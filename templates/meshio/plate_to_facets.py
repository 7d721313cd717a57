"""Turns the mesh of gmsh/erosion_plate.geo into what the grains need: triangles with their corners (plate.h5), and a
file that ParaView opens (plate.vtu)."""

import h5py
import meshio
import numpy

section, hole = {{section}}, {{hole}}  # m
mesh = meshio.read({{mesh}})
triangles = mesh.points[mesh.get_cells_type("triangle")]  # [triangles, corners, 3], m

area = numpy.linalg.norm(numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1).sum() / 2
holes = round((section**2 - area) / hole**2)
if holes < 1 or abs(section**2 - holes * hole**2 - area) > 1e-9 * section**2:
    raise SystemExit("the triangles cover %g m2, which is not the plate less a whole number of holes" % area)
with h5py.File("plate.h5", "w") as file:
    file["triangles"] = triangles
    file["triangles"].attrs["unit"] = "m"
meshio.write("plate.vtu", meshio.Mesh(mesh.points, [("triangle", mesh.get_cells_type("triangle"))]))
print("%d triangles around %d holes, %.4g %% open" % (len(triangles), holes, 100 * (1 - area / section**2)))
