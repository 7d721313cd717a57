class SmoothWall:
    """A polyline (cells of two points) or triangulated surface (three), and its point next to a given one."""

    def __init__(self, points, cells):
        self.rest = [tuple(float(c) for c in point) for point in points]  # m, undeformed
        self.cells = [tuple(cell) for cell in cells]

    def nearest(self, center, displacement):
        """(cell, weights, foot, distance): the point of the displaced wall next to `center`, weights of the cell's points."""
        best = None
        for cell in self.cells:
            corners = [[r + d for r, d in zip(self.rest[i], displacement[i])] for i in cell]
            weights = weights_on_segment(center, *corners) if len(cell) == 2 else weights_on_triangle(center, *corners)
            foot = [sum(w * corner[k] for w, corner in zip(weights, corners)) for k in range(3)]
            square = sum((c - f) ** 2 for c, f in zip(center, foot))
            if best is None or square < best[3]:
                best = (cell, weights, foot, square)
        return best[0], best[1], best[2], best[3] ** 0.5


def weights_on_segment(p, a, b):
    """Weights of a and b for the point of the segment next to p."""
    along = [y - x for x, y in zip(a, b)]
    share = sum((z - x) * d for x, z, d in zip(a, p, along)) / sum(d * d for d in along)
    share = min(max(share, 0.0), 1.0)
    return (1 - share, share)


def weights_on_triangle(p, a, b, c):
    """Weights of a, b and c for the point of the triangle next to p (C. Ericson, Real-Time Collision Detection, 5.1.5)."""
    def dot(x, y):
        return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]

    ab, ac = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
    ap, bp, cp = ([y - x for x, y in zip(o, p)] for o in (a, b, c))
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
