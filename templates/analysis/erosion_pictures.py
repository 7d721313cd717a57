# Building block: profiles over the height at some times, where beads fall, and pictures of the beads. It needs, as names:
# record, specimen, radius, start_position, start_porosity, cells, cell_top, share (of the head, or None), eroded, area.
# Read once: the record has room for more beads than there are.
places_of_beads = record['position'][:, : len(radius)].copy() if 'position' in record else None  # [windows, beads, 3], m
centres = (numpy.arange(cells) + 0.5) * cell_top / cells  # m
shown = sorted({int(round(part * record.windows)) for part in (0, 0.25, 0.5, 0.75, 1)})  # windows done


def profiles(name, rows, times, x_name):
    return [curve('%s_profile_%d' % (name, number), row, centres, '1', 'm', '%.3g s' % when, 'computed', x_name=x_name, y_name='height')
            for number, (row, when) in enumerate(zip(rows, times))]


states = numpy.vstack((start_porosity, record['porosity']))
panels = [dict(x='porosity', y='height', y_unit='mm', curves=profiles('porosity', states[shown], time[shown], 'porosity'))]
if share is not None:
    begun = sorted({min(one, record.windows - 1) for one in shown})
    panels.append(dict(x='share of the head', y='height', y_unit='mm',
                       curves=profiles('head_share', share[begun], record.begin[begun], 'share of the head')))
sandglass.figure('profiles', title='Profiles', panels=panels,
                 caption='At the centres of cells. Porosity at the end of a window, the head lost in a cell at the begin of one; the rest is lost in the '
                         'fine layer above.')

# Within 0.5 mm of a side, and the rest: beads fallen through over the part of the section, and, where places are known, the
# share of such fine beads among those that lie within the coarse layer.
beside = record['eroded_at_sides'][:, 0]
beside_area = area * (1 - (1 - 2 * 0.5e-3 / specimen['section']) ** 2)  # m2
places = [curve('eroded_' + name, time, numpy.append(0.0, numpy.cumsum(beads)) * bead_mass / part, 's', 'kg/m2', label, 'computed',
                y_name='eroded mass over its area')
          for name, label, beads, part in (('beside_sides', 'within 0.5 mm of a side', beside, beside_area),
                                           ('in_core', 'elsewhere', eroded - beside, area - beside_area))]
panels = [dict(title='below the plate', y='eroded mass over its area', y_unit='g/cm2', curves=places)]


def share_at_sides(position):
    x, y, z = position[(radius < radius.max()) & (position[:, 2] > 0) & (position[:, 2] < specimen['coarse_top'])].T
    near = numpy.minimum.reduce([x, specimen['section'] - x, y, specimen['section'] - y]) < 0.5e-3
    return near.mean() if len(near) else numpy.nan


quantity('fines_at_sides_share_initial', share_at_sides(start_position), '1', 'within 0.5 mm of a side, of the fine beads in the coarse layer')
if places_of_beads is not None:
    within = [share_at_sides(position) for position in [start_position, *places_of_beads]]
    quantity('fines_at_sides_share_final', within[-1], '1', 'the same in the end')
    panels.append(dict(title='in the coarse layer', y='share of the fine beads', curves=[
        curve('fines_at_sides_share', time, within, 's', '1', 'within 0.5 mm of a side', 'computed', y_name='share')],
        marks=[dict(axis='y', value=beside_area / area, label='of the section')]))
sandglass.figure('where', title='Where beads fall', panels=panels,
                 caption='Below the plate each over its own part of the section: as many near the sides as elsewhere would be one line. Half a bar '
                         'of the plate runs along each side, so what comes down along one leaves further in.')


# For ParaView: points with their radii, to be shown as spheres; one file a state, and beads.pvd with their times.
def write_beads(name, position):
    meshio.write(name, meshio.Mesh(position, [('vertex', numpy.arange(len(position))[:, None])], point_data={'radius': radius}))


def draw_beads(name, position, title):
    """A slice one fine bead thick through the middle: coarse beads as they are cut, fine ones whole."""
    fine, middle, width = radius.min(), specimen['section'] / 2, specimen['section']
    away = abs(position[:, 1] - middle)
    cut = numpy.where(radius > fine * 1.01, numpy.sqrt(numpy.clip(radius**2 - away**2, 0, None)), radius * (away < fine))
    there = (cut > 0) & (position[:, 2] > -2e-3)
    if not there.any():
        return
    top = (position[:, 2] + cut)[there].max() + fine
    tall = 3.6 * (top + 2e-3) / width  # inches, where the section is 3.6 wide
    figure = Figure(figsize=(4.5, tall + 1), dpi=120)
    axes = figure.add_axes((0.16, 0.6 / (tall + 1), 0.8, tall / (tall + 1)))
    for kind, colour in ((radius > fine * 1.01, '#8a96a3'), (radius <= fine * 1.01, '#d55e00')):
        mine = there & kind
        axes.add_collection(EllipseCollection(2e3 * cut[mine], 2e3 * cut[mine], numpy.zeros(mine.sum()), units='xy',
                                              offsets=1e3 * position[mine][:, [0, 2]], transOffset=axes.transData, facecolor=colour,
                                              edgecolor='white', linewidth=0.2))
    for height in numpy.linspace(0, cell_top, cells + 1):
        axes.axhline(1e3 * height, color='#0072b2', linewidth=0.7, dashes=(4, 3))
    axes.set(xlim=(0, 1e3 * width), ylim=(-2, 1e3 * top), aspect='equal', xlabel='x (mm)', ylabel='height (mm)', title=title)
    FigureCanvasAgg(figure).print_png(name)


write_beads('specimen.vtu', start_position)
draw_beads('specimen.png', start_position, 'specimen, seed %d' % specimen.get('seed', 0))
if places_of_beads is not None:
    files = [('beads_%06d.vtu' % 0, 0.0)]
    write_beads(files[0][0], start_position)
    for number, end in enumerate(record.time, 1):
        files.append(('beads_%06d.vtu' % number, end))
        write_beads(files[-1][0], places_of_beads[number - 1])
    with open('beads.pvd', 'w') as file:
        file.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n<Collection>\n')
        for name, when in files:
            file.write('<DataSet timestep="%r" part="0" file="%s"/>\n' % (float(when), name))
        file.write('</Collection>\n</VTKFile>\n')
    draw_beads('beads_at_the_end.png', places_of_beads[-1], 'after %.3g s' % record.time[-1])
