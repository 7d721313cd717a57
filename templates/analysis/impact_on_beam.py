# A sphere that strikes a beam: contacts, rebound and energies of the coupled run, beside beam theory at the run's own
# parameters and beside what theory says of the energy that the coupling itself makes.
{{> analysis/modal_beam.py}}

import sandglass_analysis as sandglass

length, height, width = {{beam_length}}, {{beam_height}}, {{beam_width}}      # m
young, poisson, density = {{beam_young}}, {{beam_poisson}}, {{beam_density}}  # Pa, 1, kg/m3
radius, velocity, gap = {{sphere_radius}}, {{impact_velocity}}, {{gap}}       # m, m/s, m
place = length / 2 + {{impact_offset}}                                        # m, from the left support
window, scheme, predicted = {{time_step}}, {{scheme}}, {{wall_prediction}}    # s
continuum, integration, hold_force = {{continuum}}, {{integration}}, {{force_in_window}} == 'last'
grain_steps = {{grain_steps}}

mass = 4 / 3 * math.pi * radius**3 * {{sphere_density}}  # kg
stiffness = hertz_stiffness(radius, {{sphere_young}}, {{sphere_poisson}}, young, poisson)
initial = mass * velocity**2 / 2  # J

record = sandglass.open_record()
time = numpy.append(0.0, record.time)


def rows(name, column=0, first=0.0):
    """The column of a field over all times, the start included."""
    return numpy.append(first, record[name][:, column])


force, deflection = rows('contact_force'), rows('beam_deflection')
position, sphere_velocity = rows('sphere_position', first=-gap), rows('sphere_velocity', first=velocity)
energies = {'sphere': rows('sphere_energy', first=initial), 'contact': rows('sphere_energy', 1),
            'beam': rows('beam_energy') + rows('beam_energy', 1)}
total = sum(energies.values())
intervals, peaks = contacts(time, force)
touched = len(peaks) > 0
over = touched and force[-1] == 0
rising = len(peaks) == 1 and force[-1] == peaks[0]  # the run ends before the force is at its largest

sandglass.quantity('contact_force_peaks', peaks, 'N', 'largest force of every contact')
sandglass.quantity('contact_intervals', intervals, 's', 'begin and end of every contact')
sandglass.quantity('contacts', len(peaks), '1', 'how many')
sandglass.quantity('first_peak_force', peaks[0] if touched and not rising else None, 'N',
                   'largest force of the first contact')
sandglass.quantity('first_contact_length', intervals[0][1] - intervals[0][0] if over else None, 's',
                   'how long the first contact lasts')
sandglass.quantity('rebound_velocity', sphere_velocity[-1] if over else None, 'm/s',
                   'of the sphere at the end; negative: away from the beam')
sandglass.quantity('largest_deflection', deflection.max(), 'm', 'of the beam where it is struck')
gain = total[-1] / total[0] - 1
sandglass.quantity('coupling_energy_gain', gain, '1',
                   'change of the energy of sphere, beam and contact together, over the initial one')

# Beam theory at this run's own parameters, with a step that resolves the contact: on a rigid flat it would last 2.94
# times its greatest depth over the velocity (Hertz, 1882).
rigid_contact = 2.94 * (1.25 * mass * velocity**2 / stiffness) ** 0.4 / velocity
theory = {}
modes = modes_for(length, width, height, young, density, rigid_contact)
for name in ('timoshenko', 'euler_bernoulli'):
    beam = Beam(length, width, height, young, poisson, density, place, name, modes)
    theory[name] = converged_impact(beam, stiffness, mass, velocity, time[-1], min(rigid_contact / 1000, time[-1] / 100), gap)
    if theory[name] is None:  # it would take too long: nothing of it is defined
        theory[name] = {key: numpy.full(2, math.nan) for key in ('force', 'sphere', 'deflection', 'sphere_velocity')}
        theory[name]['time'] = numpy.array([0, time[-1]])
    known = numpy.isfinite(theory[name]['force'][0])
    periods, forces = contacts(theory[name]['time'], theory[name]['force'])
    parted = len(forces) > 0 and theory[name]['force'][-1] == 0
    sandglass.quantity(name + '_contact_force_peaks', forces if known else None, 'N', 'by theory')
    sandglass.quantity(name + '_contact_intervals', periods if known else None, 's', 'by theory')
    sandglass.quantity(name + '_contacts', len(forces) if known else None, '1', 'by theory')
    sandglass.quantity(name + '_peak_force', forces[0] if forces else None, 'N', 'of the first contact, by theory')
    sandglass.quantity(name + '_contact_length', periods[0][1] - periods[0][0] if parted else None, 's',
                       'of the first contact, by theory')
    rebound = theory[name]['sphere_velocity'][-1] if parted else None
    sandglass.quantity(name + '_rebound_velocity', rebound, 'm/s', 'by theory')
    same = len(forces) == len(peaks) > 0 and over and parted
    ends, theory_ends = numpy.ravel(intervals), numpy.ravel(periods)
    sandglass.quantity(name + '_times_difference',
                       max(abs(ends[1:] / theory_ends[1:] - 1)) if same else None, '1',
                       'largest relative difference of begins and ends of contacts; the first begin is the impact')
    sandglass.quantity(name + '_later_peaks_difference',
                       max(abs(numpy.divide(peaks, forces) - 1)[1:]) if same and len(peaks) > 1 else None, '1',
                       'largest relative difference of the peak forces after the first contact')
    once = over and parted and len(forces) == len(peaks) == 1  # a second contact hangs on details of the first
    sandglass.quantity(name + '_rebound_difference', (sphere_velocity[-1] - rebound) / velocity if once else None, '1',
                       'of rebound velocities, over the velocity of the impact')

# Energy that the coupling makes: a lag of l windows between both sides' view of the contact adds
# l * window * integral of force * acceleration of the beam's contact point.
def gain_rate(time, force, deflection):
    """Integral of force * acceleration of the point, by parts, over the initial energy."""
    velocity = numpy.gradient(deflection, time)
    return -numpy.trapz(numpy.gradient(force, time) * velocity, time) / initial


rate = gain_rate(*(theory['timoshenko'][key] for key in ('time', 'force', 'deflection')))
own_rate = gain_rate(time, force, deflection)
lag = {'serial-explicit': 1.0, 'parallel-explicit': 2.0, 'serial-implicit': 0.0}[scheme] - 0.5 * hold_force
if scheme != 'serial-implicit':
    # A wall that stands for a window of several steps is late by the mean of these steps.
    lag -= 1.0 if predicted else 0.5 * (1 - 1 / grain_steps)
    if continuum == 'mpm' and integration != 'implicit':
        lag -= 0.5  # the force moves the body at once: leapfrog
# First order in the window; and beside a wall that hardly moves there is nothing to measure.
resolved = touched and over and window <= rigid_contact / 300 and own_rate * window > 1e-4
sandglass.quantity('energy_gain_rate_theory', rate if known else None, '1/s', 'gain per window of lag and second of window, by beam theory')
sandglass.quantity('exchange_lag_theory', lag, '1', "windows between both sides' view of the contact, by the scheme")
sandglass.quantity('exchange_lag', gain / (own_rate * window) if resolved else None, '1',
                   'the same, from the measured gain, force and deflection')
sandglass.quantity('energy_gain_theory', lag * rate * window if known else None, '1', 'coupling_energy_gain by theory')

# Figures; some 500 points a curve.
thin = slice(None, None, max(1, len(time) // 500))


def curve(name, x, y, unit, label, kind, source=''):
    return sandglass.curve(name, x, y, x_unit='s', y_unit=unit, y_name=name, label=label, kind=kind, source=source)


solver = {'fem': 'YADE and FreeFEM', 'mpm': 'YADE and material points', 'kratos': 'YADE and Kratos'}[continuum]
curve('contact_force', time[thin], force[thin], 'N', solver, 'computed')
curve('sphere_displacement', time[thin], position[thin] + gap, 'm', 'sphere', 'computed')
curve('beam_displacement', time[thin], deflection[thin], 'm', 'beam', 'computed')
for name, label in (('timoshenko', "Timoshenko's beam"), ('euler_bernoulli', 'Euler-Bernoulli beam')):
    one = theory[name]
    part = slice(None, None, max(1, len(one['time']) // 500))
    for what, key, unit in (('force', 'force', 'N'), ('sphere', 'sphere', 'm'), ('beam', 'deflection', 'm')):
        values = one[key][part] + (gap if what == 'sphere' else 0)
        shown = label if what == 'force' else '%s, %s' % (what, label)
        curve(name + '_' + what, one['time'][part], values, unit, shown, 'analytic')
for name, values in energies.items():
    curve(name + '_energy', time[thin], values[thin] / initial, '1', name, 'computed')
curve('energy_change', time[thin], total[thin] / total[0] - 1, '1', 'sphere, beam and contact', 'computed')
curve('energy_change_theory', [0, time[-1]], [lag * rate * window] * 2, '1', 'gain by theory', 'analytic')

sandglass.figure('contact_force', title='Contact force', panels=[
    dict(x_unit='ms', y='contact force', curves=['contact_force', 'timoshenko_force', 'euler_bernoulli_force'])])
sandglass.figure('displacements', title='Displacement of sphere and beam', panels=[
    dict(x_unit='ms', y='displacement', y_unit='um',
         curves=['sphere_displacement', 'beam_displacement', 'timoshenko_sphere', 'timoshenko_beam'])],
    caption='Positive towards the beam; the beam where it is struck.')
sandglass.figure('energy', title='Energy', panels=[
    dict(x_unit='ms', y='energy over that of the impact', curves=['sphere_energy', 'beam_energy', 'contact_energy']),
    dict(x_unit='ms', y='change of their sum', curves=['energy_change', 'energy_change_theory'])],
    caption='The sum should not change: what it gains is made by the coupling (%.2g window%s of lag).' % (lag, '' if lag == 1 else 's'))
sandglass.finish()
