# Building block: the file of a specimen of the erosion test, whichever engine made it. It needs, as names: position,
# velocity, spin (of the beads kept, the coarse ones first), fallen (time and count), coarse_beads, coarse_top,
# wall_height, reached, met_coarse, lost_at_porosity, preparation_time, resting_time, section, density, coarse_diameter, fine_diameter.
x, y, z = position[coarse_beads:].T
near = numpy.minimum.reduce([x, section - x, y, section - y]) < 0.5e-3
mass = math.pi / 6 * fine_diameter**3 * density
fallen = numpy.array(fallen, dtype=float)
last = fallen[fallen[:, 0] >= fallen[-1, 0] - 0.1]  # s
rate = (last[-1, 1] - last[0, 1]) * mass / (last[-1, 0] - last[0, 0]) if len(last) > 1 else 0.0
with h5py.File('specimen.h5', 'w') as file:
    for name, values, unit in (('position', position, 'm'), ('velocity', velocity, 'm/s'), ('spin', spin, 'rad/s'),
                               ('radius', numpy.repeat([coarse_diameter / 2, fine_diameter / 2],
                                                       [coarse_beads, len(position) - coarse_beads]), 'm')):
        file[name] = values
        file[name].attrs['unit'] = unit
    file['fallen'] = fallen
    file['fallen'].attrs['meaning'] = 'time since the fine beads were let go (s), beads fallen through until then'
    for name, value in dict(
            seed={{seed}}, section=section, density=density, coarse_top=coarse_top, wall_height=wall_height,
            porosity_fine=reached, met_coarse=met_coarse, fines_lost=int(fallen[-1, 1]), fines_lost_at_porosity=lost_at_porosity,
            mass_per_fine=mass, fall_rate=rate, preparation_time=preparation_time, resting_time=resting_time,
            wall_share_in_coarse=near[z < coarse_top].mean() if (z < coarse_top).any() else 0.0).items():
        file.attrs[name] = value
if met_coarse:
    print('the wall met a coarse bead before the layer had the porosity that was asked for')
print('%d coarse beads up to %.4g mm; %d fine ones, porosity %.4g; %d fell through in %.3g s, at the end %.3g g/s'
      % (coarse_beads, coarse_top * 1e3, len(z), reached, fallen[-1, 1], fallen[-1, 0], rate * 1e3))
