"""What a sphere settling in creeping flow must do, from the formulas alone: nothing here comes from the program.

Velocities are positive downward. SI throughout.
"""

import math

import numpy

GRAVITY = 9.80665  # m/s2, standard gravity

# The scene's own sphere and fluid (ICY, section 3.2; density from the authors' files).
PAPER = dict(diameter=1e-4, density=2650.0, viscosity=1e-3, fluid_density=1000.0)


def relaxation_time(diameter, density, viscosity, fluid_density=0.0):
    return density * diameter**2 / (18 * viscosity)


def terminal_velocity(diameter, density, viscosity, fluid_density):
    """Stokes (1851): weight less buoyancy equals 3 pi viscosity diameter velocity."""
    return (density - fluid_density) * GRAVITY * diameter**2 / (18 * viscosity)


def stokes_drag(velocity, diameter, viscosity):
    return 3 * math.pi * viscosity * diameter * velocity


def stokes_velocity(time, **sphere):
    return terminal_velocity(**sphere) * -numpy.expm1(-numpy.asarray(time) / relaxation_time(**sphere))


def serial_velocity(windows, window, damping=0.0, **sphere):
    """v_1 ... v_n of the serial-explicit scheme with one step a window: the drag of the velocity at its begin acts.

    The distance from the terminal velocity shrinks by 1 - window/tau. Numerical damping takes its share of every
    acceleration as long as nothing overshoots.
    """
    factor = 1 - window / relaxation_time(**sphere) * (1 - damping)
    assert damping == 0 or factor >= 0
    return terminal_velocity(**sphere) * (1 - factor ** numpy.arange(1, windows + 1))


def parallel_velocity(windows, window, **sphere):
    """The same, parallel-explicit: in window n acts the drag of the velocity at the begin of window n - 1.

    v_n = v_{n-1} + lambda (v_t - v_{n-2}); nothing is known of a drag in the first window.
    """
    ratio, terminal = window / relaxation_time(**sphere), terminal_velocity(**sphere)
    velocity = [0.0]
    acting = 0.0
    for _ in range(windows):
        computed = velocity[-1]
        velocity.append(velocity[-1] + ratio * (terminal - acting))
        acting = computed
    return numpy.array(velocity[1:])


def reynolds_number(velocity, diameter, viscosity, fluid_density, **_):
    return fluid_density * abs(velocity) * diameter / viscosity


def schiller_naumann(reynolds):
    """Drag over Stokes' drag, Schiller and Naumann (1933), for Reynolds numbers up to 800; scatter about 5 %."""
    return 1 + 0.15 * reynolds**0.687
