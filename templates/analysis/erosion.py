# The erosion test: eroded mass against time beside what ICY printed and what was measured, the books of beads and forces,
# and the cells' porosity and share of the head.
import csv

import h5py
import meshio
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

import sandglass_analysis as sandglass
from sandglass_column import WATER_WEIGHT, kozeny_carman

cells, cell_top = {{cells}}, {{cell_top}}                                         # 1, m
fine_thickness, fine_conductivity = {{fine_thickness}}, {{fine_conductivity}}     # m, m/s
window = {{window}}                                                               # s
GRAM_PER_CM2 = 10.0                                                               # kg/m2

record = sandglass.open_record()
with h5py.File({{specimen}}, 'r', locking=False) as file:
    specimen = dict(file.attrs)
    radius = file['radius'][...]
    fallen = file['fallen'][...]
    start_position = file['position'][...]
area = specimen['section'] ** 2                         # m2
bead_mass = specimen['mass_per_fine']                   # kg
beads_total = int((radius < radius.max()).sum())
eroded = record['eroded'][:, 0].astype(int)             # passages in each window
passed = numpy.cumsum(eroded)
time = numpy.append(0.0, record.time)
mass = numpy.append(0.0, passed * bead_mass)

quantity = sandglass.quantity
quantity('eroded_mass', mass[-1], 'kg', 'passages through the plate times the unscaled mass of a fine bead')
quantity('eroded_mass_per_area', mass[-1] / area, 'kg/m2', 'the same over the section; 1 g/cm2 is 10 kg/m2')
quantity('beads_total', beads_total, '1', 'fine beads of the specimen, without those that fell through beforehand')
quantity('beads_eroded', passed[-1], '1', 'passages through the plate')
aside = record['fines_aside'][:, 0]
{{#reinsertion}}
fallen_and_not_put_back = numpy.zeros(record.windows)
{{/reinsertion}}
{{^reinsertion}}
fallen_and_not_put_back = passed
{{/reinsertion}}
unaccounted = numpy.maximum(abs(beads_total - record['fines_inside'][:, 0] - aside), abs(aside - fallen_and_not_put_back))
quantity('beads_unaccounted', unaccounted.max(), '1',
         'fine beads that are neither over the section nor in the container, or there without having been counted, at most in any window')
quantity('porosity_fine_initial', specimen['porosity_fine'], '1', 'of the layer below the wall, when the wall stopped')
quantity('fines_lost_initial', specimen['fines_lost'], '1', 'fine beads that fell through during preparation')
quantity('fines_lost_initial_mass', specimen['fines_lost'] * bead_mass, 'kg', 'their mass')
quantity('fall_rate_initial', specimen['fall_rate'], 'kg/s', 'falling through in the last 0.1 s of the preparation')
quantity('coarse_top', specimen['coarse_top'], 'm', 'the highest point of a coarse bead')
at_sides = record['eroded_at_sides'][:, 0].sum()
quantity('eroded_at_sides_share', at_sides / passed[-1] if passed[-1] else None, '1',
         'passages within 0.5 mm of a side')
quantity('area_at_sides_share', 1 - (1 - 2 * 0.5e-3 / specimen['section']) ** 2, '1', 'of the section, within 0.5 mm of a side')
last = eroded[-max(1, len(eroded) // 10):]
quantity('erosion_rate_final', last.mean() * bead_mass / window, 'kg/s', 'mean over the last tenth of the windows')
half = numpy.searchsorted(passed, beads_total / 2)
quantity('half_time', record.time[half] if half < len(passed) else None, 's',
         'when as many passages as half of the fine beads had happened, to the window')

residual = balance = share = None
with h5py.File({{start}}, 'r', locking=False) as file:
    start_porosity, start_surface = file['porosity'][...], file['specific_surface'][...]
if 'pressure_difference' in record:
    difference = record['pressure_difference']          # Pa [windows, cells]
    head = record['head'][:, 0]                         # m
    porosity = numpy.vstack((start_porosity, record['porosity'][:-1]))
    surface = numpy.vstack((start_surface, record['specific_surface'][:-1]))
{{#drag.constant}}
    in_cells = ((1 - porosity) * {'volume': 1, 'surface': surface}[{{drag_split}}]).sum(axis=1)  # of the size that drag is shared by
    porosity, surface = porosity[:1].repeat(record.windows, 0), surface[:1].repeat(record.windows, 0)
{{/drag.constant}}
    empty = porosity >= 1  # a cell without beads: freefem/darcy_column.edp says what it is taken for
    conductivity = numpy.full(porosity.shape, 1e6 * fine_conductivity)
    conductivity[~empty] = kozeny_carman(porosity[~empty], surface[~empty], specimen['density'])

    # Resistances in series. Where K is linear from a to b over L, the resistance is L ln(b/a) / (b - a).
    def resistance(a, b, length):
        u = (b - a) / a
        small = abs(u) < 1e-3
        safe = numpy.where(small, 1.0, u)
        return length / a * numpy.where(small, 1 - u / 2 + u**2 / 3 - u**3 / 4 + u**4 / 5 - u**5 / 6,
                                        numpy.log1p(safe) / safe)

    length = cell_top / cells / 2
{{#conductivity_profile.linear}}
    border = numpy.hstack((conductivity[:, :1], (conductivity[:, 1:] + conductivity[:, :-1]) / 2, conductivity[:, -1:]))
{{/conductivity_profile.linear}}
{{#conductivity_profile.constant}}
    border = None
{{/conductivity_profile.constant}}
    series = (2 * length / conductivity if border is None else
              resistance(border[:, :-1], conductivity, length) + resistance(conductivity, border[:, 1:], length))
    total = series.sum(axis=1) + fine_thickness / fine_conductivity
    exact = WATER_WEIGHT * head[:, None] * series / total[:, None]
    applied = head > 0
    if applied.any():
        residual = (abs(difference - exact)[applied] / (WATER_WEIGHT * head[applied, None])).max()
{{#drag.coupled}}
        wanted = numpy.where(empty, 0, difference).sum(axis=1) * area  # where no bead is, the water pushes none
{{/drag.coupled}}
{{#drag.constant}}
        wanted = difference.sum(axis=1) * area * in_cells / (in_cells[0] or 1)  # it goes with the beads
{{/drag.constant}}
        wanted, got = wanted[applied], record['drag_total'][applied, 0]
        balance = (abs(got - wanted) / numpy.where(wanted > 0, wanted, 1)).max()  # of a column without beads: its drag itself, 0 N
    share = difference / WATER_WEIGHT / numpy.where(applied, head, 1)[:, None]
    quantity('head_share_of_cells', share[-1], '1', 'head loss of each cell over the whole head, from below, last window')
    quantity('flux_final', record['flux'][-1, 0], 'm/s', 'Darcy flux of the last window')
quantity('darcy_residual_max', residual, '1',
         'pressure differences against exact resistances in series, over the whole head')
quantity('drag_balance_error_max', balance, '1', "sum of the beads' drag against head loss x area x weight of water")
quantity('porosity_of_cells', record['porosity'][-1], '1', 'of each cell, from below, last window')

curve = sandglass.curve
curve('eroded_mass', time, mass, 's', 'kg', 'this run', 'computed')
per_area = [curve('eroded_mass_per_area', time, mass / area, 's', 'kg/m2', 'this run', 'computed')]
curve('fallen_in_preparation', fallen[:, 0], fallen[:, 1] * bead_mass, 's', 'kg', 'preparation', 'computed')

# What ICY printed of its Figure 7, for 1 cm2, and what was measured.
printed = 'ICY, section 5'
for name, points, label in (('icy_five_cells', [(48, 2.41)], 'ICY, five cells (printed end)'),
                            ('icy_two_cells', [(58, 2.41)], 'ICY, two cells (printed end)'),
                            ('icy_constant_drag', [(7, 0.39)], 'ICY, constant drag (printed stop)')):
    x, y = numpy.array(points, dtype=float).T
    per_area.append(curve(name, x, y * GRAM_PER_CM2, 's', 'kg/m2', label, 'published', y_name='eroded_mass_per_area',
                          source=printed))


def digitised(path):
    with open(path, newline='') as file:
        rows = [row for row in csv.reader(line for line in file if not line.startswith('#'))][1:]
    return numpy.array([[float(one) for one in row[:2]] for row in rows]).T


# The settlement says when, the weighed masses how much; what had fallen before the flow is taken off.
test, test_area = {{test}}, 78.54e-4                     # name, m2
settled_at, settled = digitised({{settlement}})          # s, m
weighed_at, weighed = digitised({{weighed}})             # s, kg
before = weighed[0] if weighed_at[0] == 0 else 0.0       # kg
net = (weighed - before) / test_area                     # kg/m2
until = settled_at <= max(4 * time[-1], 180 if test == '971121' else 0)  # s; the test may have taken hours
source = 'Tomlinson (1997); data/tomlinson_vaid/%s_*.csv' % test
experiment = [curve('experiment_settlement', settled_at, settled / settled[-1] * net[-1], 's', 'kg/m2', 'test %s, by settlement' % test,
                    'measured', y_name='eroded_mass_per_area', source=source),
              curve('experiment_weighed', weighed_at, net, 's', 'kg/m2', 'test %s, weighed' % test, 'measured', y_name='eroded_mass_per_area',
                    source=source, points=True)]
if until.any():
    per_area.append(curve('experiment_begin', settled_at[until], (settled / settled[-1] * net[-1])[until], 's', 'kg/m2',
                          'test %s, by settlement' % test, 'measured', y_name='eroded_mass_per_area', source=source))
sandglass.figure('experiment', title='Test %s' % test, panels=[
    dict(y='eroded mass per area', y_unit='g/cm2', x_unit='min', curves=experiment + per_area[:1])],
    caption='The whole test. By settlement: scaled to the mass weighed at the end. Times of weighed masses are nominal.')
sandglass.figure('figure_7', title='Eroded mass', panels=[
    dict(title='all', y='eroded mass per area', y_unit='g/cm2', curves=per_area),
    dict(title='this run', y='eroded mass per area', y_unit='g/cm2', curves=per_area[:1])],
    caption='The curve of the measured test is its settlement, scaled to the mass that was weighed in the end '
            '(971121: 2.48 g/cm2, nothing in between). ICY printed the ends of its curves, not the curves.')

names = []
for k in range(cells):
    names.append(curve('porosity_%d' % (k + 1), record.time, record['porosity'][:, k], 's', '1', 'cell %d' % (k + 1), 'computed',
                       y_name='porosity'))
panels = [dict(y='porosity', curves=names)]
if 'pressure_difference' in record:
    panels.append(dict(y='share of the head', curves=[
        curve('head_share_%d' % (k + 1), record.begin, share[:, k], 's', '1', 'cell %d' % (k + 1), 'computed',
              y_name='head_share') for k in range(cells)]))
sandglass.figure('cells', title='Cells, from below', panels=panels)

{{> analysis/erosion_pictures.py}}

sandglass.finish()
