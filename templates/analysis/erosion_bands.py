# The erosion test over seeds: bands of eroded mass per case, how far cases are from their control (no flow, or the other
# program) seed by seed, which runs clog, and when, and how strong the flow becomes in them.
import math
import statistics

import numpy

import sandglass_analysis as sandglass

clogged_below, clogged_for = {{clogged_below}}, {{clogged_for}}  # share of the largest rate before; s

# A control is a point with this value of this parameter, and with the same seeds and all else that tells cases apart.
control_of, control = {{control_of}}, {{control}}
control_name = {'none': 'no flow', 'lammps': 'LAMMPS', 'yade': 'YADE'}[control]

# Quantiles of Student's t for 95 %, both sides, by degrees of freedom; beyond them that of the normal distribution.
STUDENT = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101,
           2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042]

points = [point for point in sandglass.open_study() if point.exit_code == 0]
if not points:
    raise SystemExit('no point has ended well')


class Course:
    """One run, to its planned end: time (s), eroded mass per area (kg/m2), and when it clogged (s; None: not, NaN: too short to tell).

    drag: of the cell where it is largest, over the buoyant weight of the beads in it, when each window but the first begins;
    None where the flow does not follow the beads.
    """

    def __init__(self, point):
        record = point.record()
        self.point = point
        self.time, eroded = point.counted('eroded')
        passed = numpy.append(0.0, numpy.cumsum(eroded))
        self.mass = passed * point.quantities['eroded_mass_per_area'] / passed[-1] if passed[-1] else passed
        windows = max(1, round(clogged_for / point.parameters['window']))
        stretches = passed[windows:] - passed[:-windows]  # passages in the stretch that begins with each window
        self.clogged = math.nan
        if len(stretches) > windows:
            below = [k for k in range(windows, len(stretches)) if stretches[k] < clogged_below * stretches[: k - windows + 1].max()]
            self.clogged = self.time[below[0]] if below else None
        self.drag = None
        if point.parameters['drag'] == 'coupled' and record.windows > 1:
            drag = strongest_drag(record, point.parameters)
            self.drag = numpy.append(drag, numpy.full(len(self.time) - 2 - len(drag), drag[-1]))

    @property
    def control(self):
        """What a run must share with this one to be its control."""
        given = self.point.parameters
        seeds = (given['seed'], given['reinsertion_seed'])
        return seeds + (len(self.time),) + ((given['drag'], given['cells']) if control_of == 'dem' else (given['dem'],))


def strongest_drag(record, given):
    """The largest of the cells' drags over the buoyant weight of their beads, at the begin of every window but the first.

    What a cell's beads weigh then is what they weighed when the window before ended; before the first, only the specimen knows.
    """
    porosity = record['porosity'][:-1]
    volume = (1 - porosity) * given['cell_top'] / given['cells']                            # m3 per m2
    weight = volume * (given['density'] - given['fluid_density']) * given['gravity']        # Pa
    return (record['pressure_difference'][1:] / numpy.where(weight > 0, weight, math.inf)).max(axis=1)


def name_of(point):
    drag = {'coupled': 'coupled, %d cells' % point.parameters['cells'], 'constant': 'constant drag', 'none': 'no flow'}
    return '%s (%s)' % (drag[point.parameters['drag']], point.parameters['dem'].upper())


cases = {}
for point in points:
    cases.setdefault(name_of(point), []).append(Course(point))
controls = {course.control: course for courses in cases.values() for course in courses if course.point.parameters[control_of] == control}


def short(name):
    return '_'.join(''.join(letter if letter.isalnum() else ' ' for letter in name).split())


def band(name, case, time, values, unit, y_name):
    """Three curves: the lowest, the median and the highest of the values [seeds, times]."""
    return [sandglass.curve('%s_%s' % (name, what), time, of(values, axis=0), 's', unit, case, 'computed', y_name=y_name)
            for what, of in (('lowest', numpy.min), ('median', numpy.median), ('highest', numpy.max))]


bands, drags, ends, differences, going = [], [], [], [], []
for case, courses in cases.items():
    time = min((course.time for course in courses), key=len)
    masses = numpy.array([course.mass[: len(time)] for course in courses])
    bands += band(short(case), case, time, masses, 'kg/m2', 'eroded_mass_per_area')
    strengths = [course.drag[: len(time) - 2] for course in courses if course.drag is not None]
    if strengths:
        drags += band('drag_' + short(case), case, time[1:-1], numpy.array(strengths), '1', 'drag_over_weight')
    clogged = [course.clogged for course in courses]
    told = [when for when in clogged if when is None or not math.isnan(when)]
    when = sorted(when for when in told if when is not None)
    ends.append([case, len(courses), '%.4f' % (statistics.median(masses[:, -1]) / 10),
                 '%.4f to %.4f' % (masses[:, -1].min() / 10, masses[:, -1].max() / 10),
                 '%.4f' % (statistics.stdev(masses[:, -1]) / 10) if len(courses) > 1 else '-',
                 '%d of %d' % (len(when), len(told)) if told else 'too short to tell', ', '.join('%.1f' % one for one in when) or '-'])
    if told:
        going.append(sandglass.curve('going_' + short(case), time, [1 - sum(one <= now for one in when) / len(told) for now in time],
                                     's', '1', case, 'computed', y_name='share'))

    # Specimens of one seed are the same, so the difference is looked at seed by seed.
    pairs = [(course, controls[course.control]) for course in courses if course.control in controls and controls[course.control] is not course]
    if not pairs:
        continue
    extra = numpy.array([course.mass[: len(time)] - without.mass[: len(time)] for course, without in pairs])
    count = len(extra)
    error = extra.std(axis=0, ddof=1) / math.sqrt(count) if count > 1 else numpy.full(len(time), math.nan)
    mean = extra.mean(axis=0)
    # A band of many windows needs no bar at each of them.
    every = max(1, len(time) // 24)
    differences.append((case, sandglass.curve('added_' + short(case), time[::every], mean[::every], 's', 'kg/m2', case, 'computed',
                                              y_name='difference', y_error=error[::every]), mean[-1], error[-1], extra[:, -1],
                        statistics.mean(without.mass[-1] for _, without in pairs)))

# What ICY printed of its Figure 7, where the runs come near it.
printed = []
longest = max(course.time[-1] for courses in cases.values() for course in courses)
for name, x, y, label in (('icy_constant_drag', 7, 0.39, 'ICY, constant drag (printed stop)'), ('icy_five_cells', 48, 2.41, 'ICY, five cells (printed end)'),
                          ('icy_two_cells', 58, 2.41, 'ICY, two cells (printed end)')):
    if longest > x / 2:
        printed.append(sandglass.curve(name, [float(x)], [10 * y], 's', 'kg/m2', label, 'published', y_name='eroded_mass_per_area',
                                       source='ICY, section 5'))

panels = [dict(title='lowest, median and highest over seeds', y='eroded mass per area', y_unit='g/cm2', curves=bands + printed)]
if differences:
    panels.append(dict(title='less %s, seed by seed' % control_name, y='difference of eroded mass per area', y_unit='g/cm2',
                       curves=[one[1] for one in differences], marks=[dict(axis='y', value=0.0, label=control_name)]))
if drags:
    panels.append(dict(title='the cell where the drag is largest', y='drag over buoyant weight of its beads', curves=drags,
                       marks=[dict(axis='y', value=1.0, label='weight')]))
if any(row[-1] != '-' for row in ends):
    panels.append(dict(title='runs that have not clogged', y='share of the runs', curves=going))
sandglass.figure('bands', title='Eroded mass over seeds', panels=panels,
                 caption='Specimens of one seed are the same in all cases of one engine. Bars: standard error of the mean over seeds. A run has clogged '
                         'when in %g s less than %g %% fell through of the most that fell in as long a time before. A run that ended because nothing fell '
                         'through any more is drawn on as it was.' % (clogged_for, 100 * clogged_below))
sandglass.table('bands', 'Eroded mass at the end', ['case', 'seeds', 'median in g/cm2', 'lowest to highest',
                                                    'standard deviation', 'clogged', 'when in s'], ends)


def half_width(error, count):
    """Of the 95 % interval of the mean, from Student's distribution; NaN from one seed."""
    return error * (STUDENT[count - 2] if count - 2 < len(STUDENT) else 1.96) if count > 1 else math.nan


def interval(mean, error, count):
    half = half_width(error, count)
    return '-' if math.isnan(half) else '%+.4f to %+.4f' % ((mean - half) / 10, (mean + half) / 10)


if differences:
    sandglass.table('added', 'Less %s, seed by seed, at the end' % control_name,
                    ['case', 'pairs', 'difference in g/cm2', 'standard error', '95 % of the mean', 'over ' + control_name, 'pairs with more'],
                    [[case, len(extra), '%+.4f' % (mean / 10), '-' if math.isnan(error) else '%.4f' % (error / 10), interval(mean, error, len(extra)),
                      '%+.0f %%' % (100 * mean / without) if without else '-', '%d of %d' % ((extra > 0).sum(), len(extra))]
                     for case, _, mean, error, extra, without in differences])
if control_of == 'drag':
    coupled = [one for one in differences if one[0].startswith('coupled')]
    sandglass.quantity('added_by_coupling', coupled[0][2] if coupled else None, 'kg/m2',
                       'eroded mass per area of the first coupled case less that without flow, mean over seeds')
    sandglass.quantity('added_by_coupling_error', coupled[0][3] if coupled and not math.isnan(coupled[0][3]) else None, 'kg/m2', 'its standard error')
else:
    for case, _, mean, error, extra, _ in differences:
        half = half_width(error, len(extra))
        sandglass.quantity('engines_apart', None if math.isnan(half) or not half else abs(mean) / half, '1',
                           'mean difference of eroded mass over half its 95 %% interval, %s against %s: below 1 it cannot be told from none'
                           % (case, control_name))
told = [course.clogged for courses in cases.values() for course in courses if course.clogged is None or not math.isnan(course.clogged)]
sandglass.quantity('clogged_share', sum(one is not None for one in told) / len(told) if told else None, '1', 'of all runs long enough to tell')
sandglass.quantity('beads_unaccounted_max', max(point.quantities['beads_unaccounted'] for point in points), '1', 'of all points')
sandglass.finish()
