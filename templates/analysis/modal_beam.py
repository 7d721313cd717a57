# A sphere that strikes a simply supported beam at any point, by modal superposition: Euler-Bernoulli or Timoshenko
# theory, Hertz contact, no friction, no gravity. Independent of every solver that Sandglass couples.
#
# Modes move exactly (a rotation in phase space), the sphere drifts, contact kicks both: Strang splitting, second order
# in the time step, no limit by the highest mode. What the modes left out would give way statically is added as a spring
# in series with the contact, so that few modes suffice.
#
# Euler-Bernoulli: w_n = (n pi/L)^2 sqrt(EI/rho A). Timoshenko: both frequencies per n of
#   (rho^2 I / k G) w^4 - (rho A + rho I q^2 + rho A E I q^2 / (k G A)) w^2 + E I q^4 = 0,  q = n pi / L,
# with deflection and rotation in the ratio that the equation of shear gives (S. Timoshenko, Phil. Mag. 41, 1921, 744).
import math

import numpy


class Beam:
    """Modes of a simply supported beam of rectangular section, as seen from one point of its axis."""

    def __init__(self, length, width, height, young, poisson, density, point, theory, modes, shear_factor=None):
        """`theory` is 'timoshenko' or 'euler_bernoulli'; `point` is the loaded point, m from the left support.

        `shear_factor`: 10 (1 + nu) / (12 + 11 nu) unless given (G. R. Cowper, J. Appl. Mech. 33, 1966, 335).
        """
        area, inertia = width * height, width * height**3 / 12
        q = numpy.arange(1, modes + 1) * math.pi / length
        shape = numpy.sin(q * point)
        bending = young * inertia
        if theory == "euler_bernoulli":
            omega = q**2 * math.sqrt(bending / (density * area))
            mass = numpy.full(modes, density * area * length / 2)
            compliance = point**2 * (length - point) ** 2 / (3 * bending * length)
        else:
            factor = shear_factor or 10 * (1 + poisson) / (12 + 11 * poisson)
            shear = factor * young / (2 * (1 + poisson)) * area
            a = density * area * density * inertia / shear
            b = density * area + density * inertia * q**2 + density * area * bending * q**2 / shear
            root = numpy.sqrt(b**2 - 4 * a * bending * q**4)
            # The smaller root without cancellation.
            squares = numpy.concatenate([2 * bending * q**4 / (b + root), (b + root) / (2 * a)])
            q, shape = numpy.tile(q, 2), numpy.tile(shape, 2)
            rotation = q - density * area * squares / (shear * q)  # per unit deflection
            omega = numpy.sqrt(squares)
            mass = (density * area + density * inertia * rotation**2) * length / 2
            compliance = point**2 * (length - point) ** 2 / (3 * bending * length)
            compliance += point * (length - point) / (length * shear)
        keep = abs(shape) > 1e-12  # modes that have a node here are never excited
        self.omega = omega[keep]  # rad/s
        self.weight = shape[keep] / numpy.sqrt(mass[keep])  # deflection here per unit modal coordinate, kg^-1/2
        self.compliance = compliance  # m/N, static, of this point
        self.rest = max(0.0, compliance - float(numpy.sum((self.weight / self.omega) ** 2)))  # of the modes left out


def hertz_stiffness(radius, young, poisson, young_2, poisson_2):
    """K of F = K depth^1.5 for a sphere on a flat (Hertz, 1882): 4/3 E* sqrt(R), in N/m^1.5."""
    return 4 / 3 / ((1 - poisson**2) / young + (1 - poisson_2**2) / young_2) * math.sqrt(radius)


def impact(beam, stiffness, mass, velocity, end_time, step, gap=0.0):
    """Sphere of this mass and velocity (m/s, towards the beam) against the beam, from `gap` above it.

    Returns a dict of arrays over time [steps + 1]: time, force (N), sphere and deflection (m, towards the beam), and
    sphere_velocity; and `energy`, the largest relative change of the total energy at any step.
    """
    steps = int(math.ceil(end_time / step - 1e-9))
    c, s = numpy.cos(beam.omega * step), numpy.sin(beam.omega * step)
    along, across = s / beam.omega, s * beam.omega
    q, p = numpy.zeros_like(beam.omega), numpy.zeros_like(beam.omega)
    x, v = -gap, velocity
    result = {name: numpy.zeros(steps + 1) for name in ("force", "sphere", "deflection", "sphere_velocity")}
    energy = numpy.zeros(steps + 1)
    force = 0.0

    def contact(overlap, force):
        """Force of Hertz's spring in series with the spring of the modes left out."""
        if overlap <= 0:
            return 0.0
        if beam.rest == 0:
            return stiffness * overlap**1.5
        # overlap = (F/K)^(2/3) + rest F, by Newton's method in the depth d = (F/K)^(2/3)
        d = min(overlap, (force / stiffness) ** (2 / 3) if force > 0 else overlap)
        for _ in range(50):
            change = (overlap - d - beam.rest * stiffness * d**1.5) / (1 + 1.5 * beam.rest * stiffness * math.sqrt(d))
            d = max(d + change, 0.0)
            if abs(change) <= 1e-15 * overlap:
                break
        return stiffness * d**1.5

    for n in range(steps + 1):
        if n > 0:
            x += step * v
            q, p = c * q + along * p, c * p - across * q
        deflection = float(beam.weight @ q)
        force = contact(x - deflection, force)
        kick = force * step / 2
        if n > 0:
            v -= kick / mass
            p += kick * beam.weight
        result["force"][n], result["sphere"][n], result["sphere_velocity"][n] = force, x, v
        result["deflection"][n] = deflection + beam.rest * force
        spring = 0.4 * stiffness * (force / stiffness) ** (5 / 3) + 0.5 * beam.rest * force**2
        energy[n] = 0.5 * mass * v * v + 0.5 * float(p @ p + (beam.omega * q) @ (beam.omega * q)) + spring
        v -= kick / mass
        p += kick * beam.weight
    result["time"] = numpy.arange(steps + 1) * step
    result["energy"] = float(max(abs(energy / energy[0] - 1)))
    return result


def converged_impact(beam, stiffness, mass, velocity, end_time, step, gap=0.0, drift=1e-3, most=400_000):
    """`impact` with the step halved until the total energy keeps within `drift`; None where that takes more than `most` steps.

    A heavy sphere stays so long, and presses so hard, that steps which resolve its contact are too long for light modes.
    """
    while end_time / step <= most:
        try:
            run = impact(beam, stiffness, mass, velocity, end_time, step, gap)
        except OverflowError:
            run = {"energy": math.inf}
        if run["energy"] <= drift:
            return run
        step /= 2
    return None


def modes_for(length, width, height, young, density, duration, least=100):
    """As many modes as have a period of a tenth of this duration or more (Euler-Bernoulli), within reason."""
    q = (2 * math.pi * 10 / duration) ** 0.5 * (12 * density / (young * height**2)) ** 0.25
    return min(max(least, math.ceil(length / math.pi * q)), 4000)


def contacts(time, force, part=0.1):
    """Contact intervals [(begin, end)] in s and their peak forces [N] from sampled forces.

    Ends are where force^(2/3), which goes as the depth, would vanish. Contacts less than `part` of the length of the
    first one apart are one: a contact may dip, and touch again at once. A contact that is not over ends at the last time.
    """
    touching = numpy.concatenate([[False], force > 0, [False]]).astype(int)
    begins, ends = numpy.flatnonzero(numpy.diff(touching) == 1), numpy.flatnonzero(numpy.diff(touching) == -1) - 1
    depth = numpy.maximum(force, 0) ** (2 / 3)

    def vanishes(index, inner, outer):
        if not 0 <= outer < len(time):
            return float(time[index])
        slope = depth[inner] - depth[index]
        share = depth[index] / slope if slope > 0 else 1.0
        return float(time[index] + min(share, 1.0) * (time[outer] - time[index]))

    found = []
    for begin, end in zip(begins, ends):
        interval = [vanishes(begin, min(begin + 1, end), begin - 1), vanishes(end, max(end - 1, begin), end + 1)]
        peak = float(force[begin : end + 1].max())
        if found and interval[0] - found[-1][1] < part * (found[0][1] - found[0][0]):
            found[-1][1], found[-1][2] = interval[1], max(found[-1][2], peak)
        else:
            found.append([*interval, peak])
    return [one[:2] for one in found], [one[2] for one in found]
