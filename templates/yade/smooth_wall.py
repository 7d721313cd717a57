def difference(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class SmoothWall:
    """A polyline (cells of two points, in a plane z = const) or triangulated surface (three), made smooth.

    Displacements are small against the cells: the place next to a sphere is looked for at rest, and moves with the points
    of its cell. The normal there is interpolated between those of the points, which are the means over their cells: it
    does not jump where a sphere slides over a point or an edge, nor where the bent wall has a kink.
    """

    def __init__(self, points, cells):
        self.rest = [tuple(float(c) for c in point) for point in points]  # m, undeformed
        self.cells = [tuple(cell) for cell in cells]
        self.around = [[cell for cell in self.cells if i in cell] for i in range(len(self.rest))]

    def next_to(self, center):
        """(cell, weights of its points) of the place at rest that is next to `center`."""
        best = None
        for cell in self.cells:
            corners = [self.rest[i] for i in cell]
            weights = weights_on_segment(center, *corners) if len(cell) == 2 else weights_on_triangle(center, *corners)
            away = difference(center, combined(weights, corners))
            if best is None or dot(away, away) < best[2]:
                best = (cell, weights, dot(away, away))
        return best[:2]

    def moved(self, i, displacement):
        return [r + d for r, d in zip(self.rest[i], displacement[i])]

    def tangent(self, cell, weights, displacement):
        """(foot, unit normal) of the displaced wall."""
        foot = combined(weights, [self.moved(i, displacement) for i in cell])
        normal = combined(weights, [self._normal_at(i, displacement) for i in cell])
        length = dot(normal, normal) ** 0.5
        return foot, [component / length for component in normal]

    def _normal_at(self, i, displacement):
        """Mean of the normals of the cells around a point, by their size; up is y."""
        total = [0.0, 0.0, 0.0]
        for cell in self.around[i]:
            a, b = (self.moved(k, displacement) for k in cell[:2])
            u = difference(b, a)
            v = difference(self.moved(cell[2], displacement), a) if len(cell) == 3 else (0.0, 0.0, -1.0)
            one = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            sign = 1.0 if one[1] > 0 else -1.0
            total = [t + sign * component for t, component in zip(total, one)]
        length = dot(total, total) ** 0.5
        return [component / length for component in total]


def combined(weights, vectors):
    """Sum of weight times vector."""
    return [sum(w * vector[k] for w, vector in zip(weights, vectors)) for k in range(3)]


def weights_on_segment(p, a, b):
    """Weights of a and b for the point of the segment next to p."""
    along = difference(b, a)
    share = min(max(dot(difference(p, a), along) / dot(along, along), 0.0), 1.0)
    return (1 - share, share)


def weights_on_triangle(p, a, b, c):
    """Weights of a, b and c for the point of the triangle next to p (C. Ericson, Real-Time Collision Detection, 5.1.5)."""
    ab, ac = difference(b, a), difference(c, a)
    ap, bp, cp = (difference(p, corner) for corner in (a, b, c))
    d1, d2, d3, d4, d5, d6 = dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp)
    if d1 <= 0 and d2 <= 0:
        return (1.0, 0.0, 0.0)
    if d3 >= 0 and d4 <= d3:
        return (0.0, 1.0, 0.0)
    if d6 >= 0 and d5 <= d6:
        return (0.0, 0.0, 1.0)
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        return (1 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0)
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        return (1 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6))
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        share = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return (0.0, 1 - share, share)
    total = va + vb + vc
    return (va / total, vb / total, vc / total)
