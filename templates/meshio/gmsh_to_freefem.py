"""Turns the mesh of gmsh/sphere_in_box.geo into one that FreeFEM reads (Medit), labels kept.

Edges are straight, so the sphere comes out as an inscribed polyhedron, a little too small. Its
corners are moved outward until it has the sphere's volume: the error in the drag falls from the
square of the element size to a higher order.
"""

import meshio
import numpy

SPHERE = 1

mesh = meshio.read({{mesh}})
triangles = mesh.get_cells_type("triangle")
triangle_labels = mesh.get_cell_data("gmsh:physical", "triangle")
tetrahedra = mesh.get_cells_type("tetra")

# The volume between the centre and the polyhedron's faces.
on_sphere = triangles[triangle_labels == SPHERE]
if len(on_sphere) == 0 or len(tetrahedra) == 0:
    raise SystemExit("the mesh has no sphere (label 1) or no tetrahedra")
a, b, c = (mesh.points[on_sphere[:, k]] for k in range(3))
volume = abs(numpy.einsum("ij,ij->i", a, numpy.cross(b, c))).sum() / 6
{{#quarter}}
volume *= 4
{{/quarter}}
factor = (4 / 3 * numpy.pi / volume) ** (1 / 3)
if not 1 <= factor < 1.1:
    raise SystemExit(f"the faces of the sphere enclose a volume of {volume:.6g}; a sphere of unit radius has 4.18879")
points = mesh.points.copy()
points[numpy.unique(on_sphere)] *= factor

meshio.write(
    "sphere_in_box.mesh",
    meshio.Mesh(
        points,
        [("triangle", triangles), ("tetra", tetrahedra)],
        cell_data={"medit:ref": [triangle_labels, numpy.ones(len(tetrahedra), dtype=int)]},
    ),
)
print(f"{len(points)} points, {len(tetrahedra)} tetrahedra, {len(on_sphere)} faces on the sphere")
print(f"the sphere's corners were moved from radius 1 to {factor:.6f}")
