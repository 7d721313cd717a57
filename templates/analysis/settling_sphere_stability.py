# The coupling of the settling sphere against the theory of its stability: every point of the study, its growth per window
# measured from its record and predicted, and the map of what is stable.
#
# lambda = window / tau, tau = rho d^2 / (18 mu); with FreeFEM's own drag coefficient c instead of Stokes' 3 pi mu d it is
# c window / m. The distance from the terminal velocity, and with it every change from window to window, goes as the
# roots z of
#   serial-explicit                  z = 1 - lambda                                   unstable above 2
#   parallel-explicit                z^2 - z + lambda = 0                             unstable above 1
#   explicit, under-relaxed by w     z^2 - (2 - w - lambda w) z + (1 - w) = 0         unstable above 2 (2 - w)/w
#   serial-implicit, converged       z = 1/(1 + lambda)                               never; its iterations without
#     acceleration diverge above 1, with a constant factor w above 2/w - 1, with Aitken's not
# Measured z: the changes d of the velocity obey d(n+1) = a d(n) + b d(n-1) with z^2 - a z - b = 0 (one term where there is
# one root); a and b by least squares over the windows in which the changes are far above rounding.
import cmath
import math

import numpy

import sandglass_analysis as sandglass

tolerance = 1e-10  # of the iterations within a window, the workflow's
clear = 1e-5  # of the largest velocity: smaller changes are not far above the rounding of the velocity, 1e-16


class Case:
    """One point with its theory and its measurement."""

    def __init__(self, point):
        self.point = point
        p = point.parameters
        self.scheme, self.acceleration, self.w = p['scheme'], p['acceleration'], p['relaxation']
        self.mass = p['density'] * math.pi / 6 * p['diameter']**3
        self.stokes = 3 * math.pi * p['viscosity'] * p['diameter']
        self.ratio = self.stokes * p['window'] / self.mass  # lambda, with Stokes' drag
        self.implicit = self.scheme == 'serial-implicit'
        # What is left of the velocity when weight, buoyancy and drag have been taken from each other in doubles.
        self.rounding = 1.1e-16 * p['density'] / abs(p['density'] - p['fluid_density']) * (1 + self.ratio)
        self.relaxed = self.acceleration == 'constant' and not self.implicit
        self.two_roots = self.scheme == 'parallel-explicit' or self.relaxed
        self.measure(p['window'])

    @property
    def method(self):
        words = self.scheme
        if self.acceleration == 'constant':
            words += ', factor %g' % self.w
        elif self.acceleration == 'aitken':
            words += ', Aitken'
        return words

    @property
    def outcome(self):
        """By the run's own verdict: exit status 5, or what the stability watch noted."""
        if self.point.exit_code == 5:
            return 'unstable'
        if any('oscillat' in note for note in self.point.notes):
            return 'oscillating'
        return 'stable'

    def measure(self, window):
        self.root, self.theory, self.sent = None, None, None
        try:
            record = self.point.record()
        except (OSError, KeyError):
            return
        if record.windows < 2:
            return
        velocity = numpy.append(0.0, record['velocity'][:, 0])
        drag = record['drag'][:, 0]
        own = self.own_coefficient(velocity, drag)
        if own is None:
            return
        self.theory = self.largest_root(own * window / self.mass)
        changes = numpy.diff(velocity)
        self.root = self.fitted(changes, clear * numpy.max(numpy.abs(velocity)))

    def own_coefficient(self, velocity, drag):
        """FreeFEM's drag per velocity: creeping flow is linear, so any window tells it."""
        if self.implicit:
            received = velocity[1:]
        else:
            received = numpy.zeros(len(drag))
            for n in range(1, len(drag)):
                w = self.w if self.relaxed else 1.0
                received[n] = received[n - 1] + w * (velocity[n] - received[n - 1])
        known = (received != 0) & numpy.isfinite(drag)
        return float(numpy.median(drag[known] / received[known])) if known.any() else None

    def largest_root(self, ratio):
        if self.implicit:
            return 1 / (1 + ratio)
        if self.scheme == 'parallel-explicit' and not self.relaxed:
            return root_of(-1, ratio)
        if self.relaxed and self.scheme == 'serial-explicit':
            return root_of(-(2 - self.w - ratio * self.w), 1 - self.w)
        return 1 - ratio if self.scheme == 'serial-explicit' else None

    def fitted(self, changes, least):
        """The largest root of the recurrence that the changes obey; None with too few beyond `least`."""
        terms = 2 if self.two_roots else 1
        rows, right = [], []
        for n in range(terms, len(changes)):
            size = numpy.max(numpy.abs(changes[n - terms:n]))
            if size > least and numpy.isfinite(changes[n - terms:n + 1]).all():  # every window weighs the same
                rows.append(changes[n - terms:n][::-1] / size)
                right.append(changes[n] / size)
        if len(rows) < terms:
            return None
        factors = numpy.linalg.lstsq(numpy.array(rows), numpy.array(right), rcond=None)[0]
        return float(factors[0]) if terms == 1 else root_of(-factors[0], -factors[1])

    def predicted(self):
        """What the theory of the limits says, or None where it says nothing (within five percent in |z|)."""
        ratio = self.ratio
        if self.implicit and self.rounding > 10 * tolerance:
            return 'unstable'  # no iteration gets that far
        if self.implicit:
            limit = {'none': 1.0, 'constant': 2 / self.w - 1, 'aitken': math.inf}[self.acceleration]
            if 0.8 * limit < ratio < 1.1 * limit:
                return None  # near the limit the iterations converge, but need more than the workflow grants
            return 'unstable' if ratio > limit else 'stable'
        root = self.largest_root(ratio)
        if root is None or 0.95 < abs(root) < 1.05:
            return None if root is None or abs(root) > 0.95 and ratio > 0.05 else 'stable'
        if abs(root) > 1:
            return 'unstable'
        # The watch calls oscillating what alternates in sign and is seen before it is lost in rounding.
        return None if isinstance(root, complex) or root < 0 else 'stable'

    @property
    def difference(self):
        """|z measured - z theory| in units of the larger of 1 and |z|."""
        if self.root is None or self.theory is None:
            return None
        return min(abs(self.root - z) for z in (self.theory, numpy.conj(self.theory))) / max(1.0, abs(self.theory))


def root_of(b, c):
    """The root of z^2 + b z + c of the largest magnitude; real where it is."""
    split = cmath.sqrt(b * b - 4 * c)
    root = max(((-b + split) / 2, (-b - split) / 2), key=abs)
    return root.real if abs(root.imag) < 1e-300 else root


points = sandglass.open_study()
cases = [Case(point) for point in points if point.exit_code in (0, 5, 6)]
grid = [case for case in cases if case.point.set != 'extremes']
extremes = [case for case in cases if case.point.set == 'extremes']

# ---- quantities

measured = [case for case in cases if case.difference is not None]
worst = max(measured, key=lambda case: case.difference)
sandglass.quantity('growth_difference_max', worst.difference, '1',
                   'largest |z measured - z theory|, over max(1, |z|), of all points; theory with FreeFEM\'s own drag: %s'
                   % worst.point.label)
sandglass.quantity('growths_measured', len(measured), '1', 'points whose growth per window could be measured')


def against_theory(case):
    """A converged iteration leaves a remainder that may turn its sign: of implicit runs only the end is predicted."""
    predicted, outcome = case.predicted(), case.outcome
    if case.implicit and outcome == 'oscillating':
        outcome = 'stable'
    return predicted is not None and predicted != outcome


wrong = [case.point.label for case in cases if against_theory(case)]
sandglass.quantity('verdicts_against_theory', len(wrong), '1',
                   'points that ended otherwise than theory says%s' % (': ' + '; '.join(wrong[:5]) if wrong else ''))
sandglass.quantity('verdicts_checked', sum(case.predicted() is not None for case in cases), '1',
                   'points far enough from the limits for theory to say how they end')
sandglass.quantity('windows_over_tau_measured', sorted({round(case.ratio, 6) for case in grid}), '1',
                   'the windows of the map, in relaxation times')

# ---- the map

methods = []
for case in grid:
    if case.method not in methods:
        methods.append(case.method)
row_of = {method: len(methods) - n for n, method in enumerate(methods)}
curves = []
for outcome in ('stable', 'oscillating', 'unstable'):
    mine = [case for case in grid if case.outcome == outcome]
    if mine:
        curves.append(sandglass.curve('map_' + outcome, [case.ratio for case in mine], [row_of[case.method] for case in mine],
                                      x_unit='1', y_unit='1', x_name='window / relaxation time', y_name='scheme',
                                      label=outcome, kind='computed', points=True))


def limits_of(case):
    """Where theory sees the method begin to oscillate and to diverge."""
    if case.implicit:
        limit = {'none': 1.0, 'constant': 2 / case.w - 1, 'aitken': None}[case.acceleration]
        return None, limit
    if case.relaxed:
        w = case.w  # w < 1: complex roots beyond (1 - sqrt(1 - w))^2 / w; else the negative root is the larger one
        return (1 - math.sqrt(1 - w))**2 / w if w < 1 else (2 - w) / w, 2 * (2 - w) / w
    return (1.0, 2.0) if case.scheme == 'serial-explicit' else (0.25, 1.0)


for name, which, label in (('map_begin', 0, 'theory: begins to oscillate'), ('map_limit', 1, 'theory: limit of stability')):
    x, y = [], []
    for case in {case.method: case for case in grid}.values():
        limit = limits_of(case)[which]
        if limit is not None:
            x += [limit, limit, limit]
            y += [row_of[case.method] - 0.4, row_of[case.method] + 0.4, math.nan]
    if x:
        curves.append(sandglass.curve(name, x, y, x_unit='1', y_unit='1', x_name='window / relaxation time', y_name='scheme',
                                      label=label, kind='analytic'))
legend = '; '.join('%d %s' % (row_of[method], method) for method in methods)
sandglass.figure(
    'map', title='What is stable, by coupling scheme and window',
    panels=[dict(x='window / relaxation time', y='coupling scheme', x_scale='log', curves=curves,
                 y_names={str(row_of[method]): method for method in methods})],
    caption='Each mark is one coupled run of YADE and FreeFEM, judged by the stability watch: unstable ended with exit '
            'status 5, oscillating got its note. Serial-implicit runs are unstable where the iterations within a window do '
            'not converge. Rows: %s.' % legend)

# ---- growth per window, measured and predicted

panel = []
for number, method in enumerate(method for method in methods if not method.startswith('serial-implicit')):
    mine = sorted((case.ratio, abs(case.root)) for case in grid if case.method == method and case.root is not None)
    if not mine:
        continue
    panel.append(sandglass.curve('growth_%d' % number, *zip(*mine), x_unit='1', y_unit='1', x_name='window / relaxation time',
                                 y_name='|z|', label=method, kind='computed', points=True))
for number, method in enumerate(method for method in methods if not method.startswith('serial-implicit')):
    case = next(case for case in grid if case.method == method)
    ratio = numpy.geomspace(min(c.ratio for c in grid), max(c.ratio for c in grid), 300)
    panel.append(sandglass.curve('growth_theory_%d' % number, ratio, [abs(case.largest_root(r)) for r in ratio], x_unit='1',
                                 y_unit='1', x_name='window / relaxation time', y_name='|z|', label='theory, ' + method,
                                 kind='analytic'))
implicit = sorted((case.ratio, abs(case.root)) for case in grid if case.implicit and case.root is not None)
if implicit:
    panel.append(sandglass.curve('growth_implicit', *zip(*implicit), x_unit='1', y_unit='1', label='serial-implicit, all that '
                                 'converge', kind='computed', points=True, x_name='window / relaxation time', y_name='|z|'))
    panel.append(sandglass.curve('growth_theory_implicit', ratio, 1 / (1 + ratio), x_unit='1', y_unit='1', kind='analytic',
                                 label='theory, serial-implicit', x_name='window / relaxation time', y_name='|z|'))
sandglass.figure('growth', title='Growth per window, measured and predicted',
                 panels=[dict(x='window / relaxation time', y='growth per window |z|', x_scale='log', curves=panel,
                              marks=[dict(axis='y', value=1.0, label='limit of stability')])],
                 caption='|z| by the recurrence that the velocity obeys in the record of each run, also of those that were '
                         'ended as unstable. Theory: with Stokes\' drag. The largest difference, with FreeFEM\'s own drag, '
                         'is %.2g.' % worst.difference)

# ---- tables


def number(z):
    if z is None:
        return '-'
    return '%.9f' % z if not isinstance(z, complex) else '%.6f, |z| %.9f' % (z.real, abs(z))


columns = ['scheme', 'window / tau', 'z measured', 'z theory', 'difference', 'run', 'theory of the limits']
for name, title, mine in (('growths', 'Growth per window', grid), ('extremes', 'Extremes', extremes)):
    head = ['point'] if name == 'extremes' else []
    sandglass.table(name, title, head + columns, [
        ([case.point.label] if head else [])
        + [case.method, '%.4g' % case.ratio, number(case.root), number(case.theory),
           '-' if case.difference is None else '%.1e' % case.difference, case.outcome, case.predicted() or 'near a limit']
        for case in mine])
sandglass.finish()
