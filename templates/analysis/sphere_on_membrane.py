# The sphere on the membrane against the exact solutions of the oscillator and of the coupling scheme: YADE and FreeFEM
# together are leapfrog, which keeps the amplitude, is a little too fast, and is unstable (here: nan) beyond a window of
# 2 sqrt(m/k).
import math

import numpy

import sandglass_analysis as sandglass

diameter, density, gravity = {{diameter}}, {{density}}, {{gravity}}      # m, kg/m3, m/s2
tension, contact, rim = {{tension}}, {{contact_radius}}, {{rim_radius}}  # N/m, m, m
window = {{window}}                                                      # s

record = sandglass.open_record()
if record.windows < 3:
    raise SystemExit('an oscillation is seen in three windows or more; give a later end_time')
time = numpy.append(0.0, record.time)             # s, the start included
depth = numpy.append(0.0, record['depth'][:, 0])  # m
reaction = record['reaction'][:, 0]               # N, the answer to the depth of the same window

# Theory: m d'' = m g - k d from rest at d = 0, so d = (m g / k) (1 - cos(omega t)).
mass = math.pi / 6 * diameter**3 * density
stiffness = 2 * math.pi * tension / math.log(rim / contact)
static_depth = mass * gravity / stiffness
oscillator = math.sqrt(stiffness / mass)                       # omega, rad/s
leapfrog = 2 / window * numpy.arcsin(oscillator * window / 2)  # rad/s

# Measured: an oscillation about s, seen once per window, has d(n-1) + d(n+1) = 2 c d(n) + 2 (1 - c) s with
# c = cos(omega window), a straight line; and two windows that follow each other give its amplitude.
slope, offset = numpy.polyfit(depth[1:-1], depth[:-2] + depth[2:], 1)
phase = numpy.arccos(slope / 2)  # omega window
u = depth - offset / (2 - slope)
amplitude = numpy.sqrt(u[1:]**2 + u[:-1]**2 - slope * u[1:] * u[:-1]) / numpy.sin(phase)

sandglass.quantity('stiffness', reaction @ depth[1:] / (depth @ depth), 'N/m', 'reaction over depth, least squares')
sandglass.quantity('stiffness_theory', stiffness, 'N/m', 'k = 2 pi T / ln(R/a)')
sandglass.quantity('static_depth', offset / (2 - slope), 'm', 'depth about which the sphere oscillates')
sandglass.quantity('static_depth_theory', static_depth, 'm', 'm g / k')
sandglass.quantity('frequency', phase / window / (2 * math.pi), 'Hz', 'of the recorded depth')
sandglass.quantity('frequency_theory', leapfrog / (2 * math.pi), 'Hz', 'leapfrog: sin(omega dt/2) = sqrt(k/m) dt/2')
sandglass.quantity('frequency_shift', leapfrog / oscillator - 1, '1', "the scheme's own time error, from theory alone")
sandglass.quantity('amplitude_drift', max(abs(amplitude / amplitude[0] - 1)), '1', 'largest change of the amplitude')

dense = numpy.linspace(0, time[-1], 1000)
for name, t, values, label, kind in (
    ('depth', time, depth, 'YADE and FreeFEM', 'computed'),
    ('scheme', dense, static_depth * (1 - numpy.cos(leapfrog * dense)), 'scheme, exact', 'analytic'),
    ('oscillator', dense, static_depth * (1 - numpy.cos(oscillator * dense)), 'oscillator, exact', 'analytic'),
):
    sandglass.curve(name, t, values, x_unit='s', y_unit='m', y_name='depth', label=label, kind=kind)
sandglass.figure(
    'depth', title='Depth of a sphere that is let go on a membrane',
    panels=[dict(x_unit='ms', y_unit='mm', curves=['depth', 'scheme', 'oscillator'])],
    caption='One exchange every %g ms makes the oscillation %.2g %% too fast: the computed points lie on the exact '
            'solution of that scheme.' % (window * 1e3, 100 * (leapfrog / oscillator - 1)))
sandglass.finish()
