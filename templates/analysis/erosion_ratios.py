# The erosion test for several ratios of grain sizes: how much of the fine layer passes, how fast at the end, and what the
# experiments found at the same ratios.
import csv
import math

import numpy

import sandglass_analysis as sandglass

points = [point for point in sandglass.open_study() if point.exit_code == 0]
if not points:
    raise SystemExit('no point has ended well')


def ratio_of(point):
    return round(point.parameters['coarse_diameter'] / point.parameters['fine_diameter'], 1)


class Course:
    """Passages over the fine beads of the specimen, against time; their rate in the last third of the time, 1/s."""

    def __init__(self, point):
        self.time, eroded = point.counted('eroded')
        self.share = numpy.append(0.0, numpy.cumsum(eroded)) / point.quantities['beads_total']
        last = self.time >= 2 / 3 * self.time[-1]
        span = self.time[last][-1] - self.time[last][0]
        self.rate = (self.share[last][-1] - self.share[last][0]) / span if span > 0 else math.nan


# A ratio is of nominal diameters; the tests name the ratio of sieve sizes, which is the same to a tenth.
families = {}
for point in points:
    families.setdefault((point.set, ratio_of(point)), []).append((point, Course(point)))

shares, rates, courses = [], [], []
for set_name in dict.fromkeys(point.set for point in points):
    rows = [(ratio, [course for _, course in members]) for (name, ratio), members in sorted(families.items()) if name == set_name]
    short = set_name.replace(' ', '_')
    for what, names, unit in (('share', shares, '1'), ('rate', rates, 'Hz')):
        values = [[course.share[-1] if what == 'share' else course.rate for course in group] for _, group in rows]
        names.append(sandglass.curve('%s_%s' % (what, short), [ratio for ratio, _ in rows], [numpy.mean(one) for one in values],
                                     x_unit='1', y_unit=unit, x_name='size ratio', y_name=what, label=set_name, kind='computed', points=True,
                                     y_error=[numpy.std(one, ddof=1) if len(one) > 1 else 0.0 for one in values]))
    panel = []
    for ratio, group in rows:
        panel.append(sandglass.curve('course_%s_%s' % (short, ('%.1f' % ratio).replace('.', '_')), group[0].time,
                                     numpy.mean([course.share for course in group], axis=0), x_unit='s', y_unit='1', y_name='share',
                                     label='%.1f' % ratio, kind='computed'))
    courses.append(dict(title=set_name, y='passages over fine beads', curves=panel))

gradients = {}
with open({{tests}}, newline='') as file:
    for row in csv.DictReader(line for line in file if not line.startswith('#')):
        if float(row['confining pressure [Pa]']) == 1e5 and row['critical gradient [1]']:
            gradients.setdefault(float(row['size ratio [1]']), []).append(max(map(float, row['critical gradient [1]'].split('|'))))
measured = sandglass.curve('critical_gradient', sorted(gradients), [max(gradients[ratio]) for ratio in sorted(gradients)], x_unit='1', y_unit='1',
                           x_name='size ratio', y_name='critical gradient', label='experiments, 100 kPa, head raised slowly', kind='measured',
                           points=True, source='Tomlinson (1997), Table 2, Figures 13 and 14')

sandglass.figure('ratios', title='Ratios of grain sizes', panels=[
    dict(title='passages at the end', x='coarse over fine diameter', y='passages over fine beads', curves=shares),
    dict(title='rate in the last third', x='coarse over fine diameter', y='passages over fine beads, per second', y_unit='s-1', curves=rates),
    dict(title='experiments', x='coarse over fine diameter', y='critical gradient', curves=[measured])],
    caption='Bars: standard deviation over seeds. In the experiments 7.3 did not pipe under any gradient, 12.3 under none. The '
            'specimens here are small, without confinement, and seconds old.')
sandglass.figure('courses', title='Passages against time', panels=courses, caption='Means over seeds; the numbers are ratios of diameters.')
sandglass.table('ratios', 'Ratios of grain sizes', ['points', 'ratio', 'head in m', 'seeds', 'passages over fine beads', 'rate at the end in 1/s',
                                                    'lost in preparation'],
                [[name, '%.1f' % ratio, members[0][0].parameters['head'] if name != 'no flow' else '-', len(members),
                  '%.4f' % numpy.mean([course.share[-1] for _, course in members]), '%.4f' % numpy.mean([course.rate for _, course in members]),
                  '%.0f' % numpy.mean([point.quantities['fines_lost_initial'] for point, _ in members])]
                 for (name, ratio), members in sorted(families.items())])
sandglass.quantity('beads_unaccounted_max', max(point.quantities['beads_unaccounted'] for point in points), '1', 'of all points')
sandglass.quantity('ratios', sorted({ratio for _, ratio in families}), '1', 'coarse over fine diameter')
sandglass.finish()
