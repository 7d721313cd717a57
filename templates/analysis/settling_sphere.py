# The settling sphere against theory and against the published figure (ICY, section 3, Figure 2).
#
# Positive is downward. The exact solution is Stokes' (drag 3 pi mu d v, no inertia of the fluid). A coupled run cannot
# follow it exactly: the drag is that of an earlier window and stays frozen, so what the run should follow to rounding
# is the exact solution of that scheme. Both differences are reported: the first is the scheme's own time error, the
# second must be small.
import math

import numpy

import sandglass_analysis as sandglass

diameter = {{diameter}}                    # m
density = {{density}}                      # kg/m3
viscosity = {{viscosity}}                  # Pa s
fluid_density = {{fluid_density}}          # kg/m3
gravity = {{gravity}}                      # m/s2
numerical_damping = {{numerical_damping}}  # YADE's local damping, 0: none
window = {{window}}                        # s, one exchange per window
grain_steps = {{grain_steps}}              # steps of the grain solver in a window
scheme = {{scheme}}                        # when the drag acts: scheme_velocity says it
acceleration = {{acceleration}}            # none, constant or aitken
relaxation = {{relaxation}}                # factor of the constant one
fluid = {{fluid}}                          # axisymmetric, box, navier_stokes

record = sandglass.open_record()
windows = record.windows
velocity = numpy.append(0.0, record['velocity'][:, 0])  # m/s, at the end of each window, the start included
drag = record['drag'][:, 0]                              # N, what the fluid solver sent in each window
time = numpy.append(0.0, record.time)                    # s
numpy.seterr(all='ignore')  # an unstable run overflows: its results are not finite, and no comparison passes with them

# ---- Stokes' law

volume = math.pi / 6 * diameter**3
mass = density * volume
submerged_weight = (density - fluid_density) * volume * gravity
stokes_coefficient = 3 * math.pi * viscosity * diameter  # N s/m: drag per velocity


def relaxation_time(rho):
    return rho * diameter**2 / (18 * viscosity)


def terminal_velocity(rho):
    return (rho - fluid_density) * gravity * diameter**2 / (18 * viscosity)


def stokes_velocity(t, rho):
    """m dv/dt = submerged weight - 3 pi mu d v from rest: v = v_t (1 - exp(-t/tau))."""
    return -terminal_velocity(rho) * numpy.expm1(-t / relaxation_time(rho))


def stokes_acceleration(t, rho):
    return (1 - fluid_density / rho) * gravity * numpy.exp(-t / relaxation_time(rho))


# ---- the coupling scheme, solved exactly


def after_window(v, force):
    """Velocity after one window of YADE steps under a constant force, numerical damping included.

    YADE's NewtonIntegrator multiplies the acceleration a by 1 - damping sign(a (v + a dt/2)) (Cundall's non-viscous
    damping at mid-step): it is smaller along the motion and larger against it. Under a constant force the sign changes
    at most once in a window, so the steps before and after are taken in one go.
    """
    a = force / mass
    step = window / grain_steps
    if a * step == 0 or not math.isfinite(a * v):
        return v + a * window
    turn = (-v - a * step / 2) / (a * step * (1 + numerical_damping))  # steps until v + a dt/2 = 0
    against = 0 if turn < 0 else min(math.floor(min(turn, grain_steps)) + 1, grain_steps)
    along = grain_steps - against
    return v + a * step * ((1 + numerical_damping) * against + (1 - numerical_damping) * along)


implicit = scheme == 'serial-implicit'
relaxed = acceleration == 'constant' and not implicit  # explicit under-relaxation, carried from window to window


def follow(previous, newest):
    """The velocity that the fluid solver receives after `previous`, when the grain's is `newest`."""
    return previous + relaxation * (newest - previous) if relaxed else newest


def implicit_window(v, coefficient):
    """v1 = v + (W - c v1) dt/m. With numerical damping there is no such closed form: undefined."""
    if numerical_damping:
        return math.nan
    return (v + submerged_weight / mass * window) / (1 + coefficient / mass * window)


def scheme_velocity(coefficients):
    """The scheme from rest, where the drag computed in window n is coefficients[n] times the velocity received.

    Serial explicit: that of the window's begin, v -> v + (W - c v) dt/m, that is (1 - lambda) per window for the
    distance from the terminal velocity. Parallel: the drag acts one window later, z^2 - z + lambda = 0, lambda =
    window / tau. Under-relaxed: the received velocity follows the grain's by the factor w only. Serial implicit: that
    of the window's end, 1/(1 + lambda) per window.
    """
    v, received_last, sent = [0.0], 0.0, 0.0
    for coefficient in coefficients:
        if implicit:
            v.append(implicit_window(v[-1], coefficient))
            continue
        computed = coefficient * received_last
        acting = computed if scheme == 'serial-explicit' else sent
        v.append(after_window(v[-1], submerged_weight - acting))
        sent = computed
        received_last = follow(received_last, v[-1])
    return numpy.array(v)


# The velocity that the fluid solver had when it computed each drag.
if implicit:
    received = velocity[1:]
else:
    received = numpy.zeros(windows)
    for n in range(1, windows):
        received[n] = follow(received[n - 1], velocity[n])
own_coefficient = numpy.where(received != 0, drag / numpy.where(received != 0, received, 1), 0.0)

exponential = stokes_velocity(time, density)
exact_scheme = scheme_velocity([stokes_coefficient] * windows)
own_scheme = scheme_velocity(own_coefficient.tolist())

# ---- quantities


def largest(differences):
    """The largest magnitude; not finite as soon as one value is."""
    return float(numpy.max(numpy.abs(differences)))


def largest_of_scheme(differences):
    """The same of what hangs on the scheme's exact solution; undefined without one."""
    return None if implicit and numerical_damping else largest(differences)


tau = relaxation_time(density)
final_received = float(received[-1])
drag_ratio = float(drag[-1]) / (stokes_coefficient * final_received) if final_received else None
reynolds = fluid_density * diameter / viscosity * abs(float(velocity[-1]))
reynolds_received = fluid_density * diameter / viscosity * abs(final_received)

sandglass.quantity('terminal_velocity', velocity[-1], 'm/s', 'velocity at the end of the run, positive downward')
sandglass.quantity('stokes_terminal_velocity', terminal_velocity(density), 'm/s',
                   "(rho - rho_f) g d^2 / (18 mu), Stokes' law")
sandglass.quantity('drag_relative_error', None if drag_ratio is None else abs(drag_ratio - 1), '1',
                   '|F/(3 pi mu d V) - 1| in the last window, V the velocity that the fluid solver received; '
                   'undefined while that is zero')
sandglass.quantity('drag_coefficient_ratio', drag_ratio, '1', "drag of the last window in units of Stokes' drag")
sandglass.quantity('velocity_difference_exponential_max', largest(velocity - exponential), 'm/s',
                   "max |v - v_exact| over the windows: the explicit scheme's own time error and all others")
sandglass.quantity('velocity_difference_scheme_max', largest_of_scheme(velocity - exact_scheme), 'm/s',
                   "max |v - v_scheme|, the scheme solved exactly with Stokes' drag: what the solvers add to it")
sandglass.quantity('velocity_difference_scheme_own_drag_max', largest_of_scheme(velocity - own_scheme), 'm/s',
                   "the same with the fluid solver's own drag coefficients: exchange and rounding only")
sandglass.quantity('scheme_time_error_max', largest_of_scheme(exact_scheme - exponential), 'm/s',
                   "max |v_scheme - v_exact|, from theory alone (undamped serial scheme: |G^n - exp(-n lambda)| v_t, "
                   'G = 1 - lambda)')
# The same three as parts of the largest speed, so that one tolerance serves every sphere, fluid and window.
for name, difference, against in (
    ('velocity_difference_exponential_relative', velocity - exponential, 'Stokes\' law'),
    ('velocity_difference_scheme_relative', velocity - exact_scheme, 'the exact solution of the scheme'),
    ('velocity_difference_scheme_own_drag_relative', velocity - own_scheme, "the same with the solver's own drag"),
    ('scheme_time_error_relative', exact_scheme - exponential, "Stokes' law, of the exact scheme: theory alone"),
):
    speed = largest_of_scheme(exact_scheme)
    sandglass.quantity(name, largest(difference) / speed if speed else None, '1',
                       'largest difference from %s over the largest speed' % against)
sandglass.quantity('relaxation_time', tau, 's', 'rho d^2 / (18 mu)')
sandglass.quantity('window_over_relaxation_time', window / tau, '1',
                   'lambda; the serial scheme is monotone to 1 and unstable above 2, the parallel one above 1')
sandglass.quantity('reynolds_number', reynolds, '1', 'rho_f |v| d / mu at the end of the run')
sandglass.quantity('schiller_naumann_ratio', 1 + 0.15 * reynolds_received**0.687, '1',
                   "drag over Stokes' drag at this Reynolds number, correlation of Schiller and Naumann (1933)")


# A single factor describes the serial schemes only (the parallel and the relaxed ones have two modes), and with
# numerical damping only while nothing overshoots: damping then slows the way to the terminal velocity by 1 - damping.
effective = window / tau * (1 - numerical_damping)
if implicit:
    factor = None if numerical_damping else 1 / (1 + window / tau)
elif scheme == 'serial-explicit' and not relaxed and (numerical_damping == 0 or effective <= 1):
    factor = 1 - effective
else:
    factor = None


def growth():
    """Median of e(n+1)/e(n), e the distance from the terminal velocity; None where it is lost in rounding."""
    if factor is None or not own_coefficient[-1] or not submerged_weight:
        return None
    terminal = submerged_weight / own_coefficient[-1]
    distance = velocity - terminal
    clear = numpy.isfinite(distance) & (numpy.abs(distance) > 1e-6 * abs(terminal))
    pairs = clear[:-1] & clear[1:]
    return float(numpy.median(distance[1:][pairs] / distance[:-1][pairs])) if pairs.any() else None


sandglass.quantity('growth_per_window', growth(), '1',
                   'measured factor of the distance from the terminal velocity per window (median)')
sandglass.quantity('growth_per_window_theory', factor, '1',
                   "1 - lambda (1 - damping) for the serial explicit scheme with Stokes' drag, 1/(1 + lambda) implicit")

# ---- curves

curve_points = 400    # of an analytic curve
drawn_windows = 2000  # of a computed curve; quantities use all windows
dense = numpy.linspace(0.0, float(time[-1]), curve_points)
chosen = numpy.unique(numpy.linspace(0, windows, min(windows, drawn_windows) + 1).astype(int))
names = {'axisymmetric': 'Stokes flow, axisymmetric', 'box': 'Stokes flow in the box',
         'navier_stokes': 'Navier-Stokes, axisymmetric'}
computed = 'YADE and FreeFEM (%s)' % names.get(fluid, fluid)


def close(a, b, tolerance=1e-6):
    return abs(a - b) <= tolerance * abs(b)


# What the paper printed holds for its own sphere and water only (it rounds g to 9.806).
paper = (close(diameter, 1e-4) and close(viscosity, 1e-3) and close(fluid_density, 1000)
         and close(gravity, 9.80665, 1e-4) and (close(density, 2650) or close(density, 2500)))
densities = [density] + [rho for rho in (2650.0, 2500.0) if paper and not close(rho, density)]



def velocity_curve(name, t, values, label, kind, y_name='velocity', source=''):
    return sandglass.curve(name, t, values, x_unit='s', y_unit='m/s', y_name=y_name, label=label, kind=kind,
                           source=source)


def acceleration_curve(name, t, values, label, kind, source=''):
    return sandglass.curve(name, t, values, x_unit='s', y_unit='m/s2', y_name='acceleration', label=label, kind=kind,
                           source=source)


velocities = [velocity_curve('velocity', time[chosen], velocity[chosen], computed, 'computed')]
accelerations = []
if 'acceleration' in record:
    # The acceleration of window n acts from its begin on: that is its place on the axis (ICY, equations 4 and 5).
    begins = chosen[chosen < windows]
    values = record['acceleration'][:, 0][begins]
    accelerations.append(acceleration_curve('acceleration', time[begins], values, computed, 'computed'))
for rho in densities:
    suffix = '' if rho == density else '_%g' % rho
    label = "Stokes' law, %g kg/m3" % rho
    velocities.append(velocity_curve('stokes_velocity' + suffix, dense, stokes_velocity(dense, rho), label, 'analytic'))
    accelerations.append(
        acceleration_curve('stokes_acceleration' + suffix, dense, stokes_acceleration(dense, rho), label, 'analytic'))
velocities.append(
    velocity_curve('scheme_velocity', time[chosen], exact_scheme[chosen], '%s scheme, exact' % scheme, 'analytic'))
if paper:
    section = 'ICY, section 3.4'
    velocities += [
        velocity_curve('published_stokes_velocity', 0.022, 0.008989, "ICY: Stokes' law", 'published', source=section),
        velocity_curve('published_coupled_velocity', 0.022, 0.008990, 'ICY: COMSOL-YADE', 'published', source=section),
    ]
    accelerations.append(
        acceleration_curve('published_acceleration', 0.007, 0.0, 'ICY: "almost zero" (in words)', 'published', section))

errors = []
for name, difference, label, kind in (
    ('error_exponential', velocity - exponential, "computed - Stokes' law", 'computed'),
    ('error_scheme', velocity - exact_scheme, 'computed - exact scheme', 'computed'),
    ('error_scheme_own_drag', velocity - own_scheme, "computed - exact scheme with the solver's drag", 'computed'),
    ('error_theory', exact_scheme - exponential, "exact scheme - Stokes' law (theory)", 'analytic'),
):
    size = numpy.abs(difference)[chosen]
    shown = numpy.isfinite(size) & (size > 0)  # a logarithmic axis has no place for an exact agreement
    if shown.any():
        errors.append(velocity_curve(name, time[chosen][shown], size[shown], label, kind, 'velocity difference'))

# ---- figures

marks = [dict(axis='x', value=tau, label='relaxation time')] if tau <= time[-1] else []
about_the_paper = ''
if paper:
    printed_reynolds = fluid_density * 0.008989 * diameter / viscosity
    about_the_paper = (
        " Stokes' law is drawn for two densities because the paper contradicts itself: its text says 2500 kg/m3, which"
        " gives %.6f m/s; only 2650 kg/m3, as in the authors' own files, gives the printed 0.008989 m/s. That velocity"
        " means Re = %.2f, where inertia raises the drag by about %.0f %% over Stokes' (Schiller and Naumann): the"
        " paper says Navier-Stokes and prints Stokes' value."
        % (terminal_velocity(2500.0), printed_reynolds, 15 * printed_reynolds**0.687))
sandglass.figure(
    'figure_2', title='A sphere settling from rest: velocity and acceleration',
    panels=[dict(x='time', y='velocity', x_unit='ms', y_unit='mm/s', curves=velocities, marks=marks),
            dict(x='time', y='acceleration', x_unit='ms', y_unit='m/s2', curves=accelerations, marks=marks)],
    caption='Sphere of %g mm and %g kg/m3; positive downward; one exchange every %g ms. A computed acceleration stands '
            'at the begin of the window in which it acts.%s' % (diameter * 1e3, density, window * 1e3, about_the_paper))
if errors:
    sandglass.figure(
        'velocity_error', title='Where the velocity differs, and by how much',
        panels=[dict(x='time', y='|velocity difference|', x_unit='ms', y_unit='m/s', y_scale='log', curves=errors)],
        caption='What the explicit scheme itself costs is theory minus theory; only the difference from the exact '
                'solution of the scheme is the work of the solvers. Exact agreement has no place on this axis.')
sandglass.finish()
