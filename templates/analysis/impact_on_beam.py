{{> analysis/modal_beam.py}}

import sandglass_analysis as sandglass

length, height, width = {{beam_length}}, {{beam_height}}, {{beam_width}}          # m
young, poisson, density = {{beam_young}}, {{beam_poisson}}, {{beam_density}}      # Pa, 1, kg/m3
radius, velocity, gap = {{sphere_radius}}, {{impact_velocity}}, {{gap}}           # m, m/s, m
place = length / 2 + {{impact_offset}}                                            # m, from the left support
window, scheme, predicted = {{time_step}}, {{scheme}}, {{wall_prediction}}        # s
continuum, hold_force = {{continuum}}, {{force_in_window}} == 'last'

mass = 4 / 3 * math.pi * radius**3 * {{sphere_density}}  # kg
stiffness = hertz_stiffness(radius, {{sphere_young}}, {{sphere_poisson}}, young, poisson)

record = sandglass.open_record()
time = numpy.append(0.0, record.time)


def rows(name, column=0, first=0.0):
    return numpy.append(first, record[name][:, column])


force = rows('contact_force')
kinetic = rows('sphere_energy', first=mass * velocity**2 / 2)
energies = {'sphere': kinetic, 'contact': rows('sphere_energy', 1),
            'beam_kinetic': rows('beam_energy'), 'beam_elastic': rows('beam_energy', 1)}
total = sum(energies.values())
intervals, peaks = contacts(time, force)
over = force[-1] == 0 and len(peaks) > 0
sphere_velocity = rows('sphere_velocity', first=velocity)

sandglass.quantity('contact_force_peaks', peaks, 'N', 'largest force of every contact')
sandglass.quantity('contact_intervals', intervals, 's', 'begin and end of every contact')
sandglass.quantity('contacts', len(peaks), '1', 'how many')
sandglass.quantity('first_peak_force', peaks[0] if peaks else None, 'N', 'largest force of the first contact')
sandglass.quantity('first_contact_end', intervals[0][1] if intervals and over else None, 's', 'end of the first contact')
sandglass.quantity('rebound_velocity', sphere_velocity[-1] if over else None, 'm/s',
                   'of the sphere at the end; negative: away from the beam')
sandglass.quantity('coupling_energy_gain', total[-1] / total[0] - 1, '1',
                   'change of the energy of sphere, beam and contact together, over the initial one')
sandglass.quantity('largest_deflection', rows('beam_deflection').max(), 'm', 'of the beam where it is struck')

# Theory at this run's own parameters.
theory = {}
for name in ('timoshenko', 'euler_bernoulli'):
    beam = Beam(length, width, height, young, poisson, density, place, name, modes=100)
    # A step that resolves the contact: the duration on a rigid flat is 2.94 depth / velocity (Hertz).
    depth = (1.25 * mass * velocity**2 / stiffness) ** 0.4
    reference = impact(beam, stiffness, mass, velocity, time[-1], min(2.94 * depth / velocity / 1000, time[-1] / 100), gap)
    theory[name] = reference
    begin_end, forces = contacts(reference['time'], reference['force'])
    sandglass.quantity(name + '_peak_force', forces[0] if forces else None, 'N', 'first peak by theory')
    sandglass.quantity(name + '_contact_force_peaks', forces, 'N', 'peaks by theory')
    sandglass.quantity(name + '_contact_intervals', begin_end, 's', 'contacts by theory')
    sandglass.quantity(name + '_rebound_velocity', reference['sphere_velocity'][-1] if reference['force'][-1] == 0 else None,
                       'm/s', 'by theory')
sandglass.finish()
