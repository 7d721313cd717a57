# What every setting of the erosion test changes, and (where timed) its run time: eroded mass per area of each setting against
# that of the reference over the same length of time, with bars over seeds. Seeds that both have are compared one by one.
import math
import statistics

import sandglass_analysis as sandglass

points = [point for point in sandglass.open_study() if point.exit_code == 0]
references, settings = {}, {}
for point in points:
    length = point.parameters['end_time']
    if point.set.startswith('reference'):
        references.setdefault(length, {})[point.parameters['seed']] = point
    settings.setdefault((point.set, point.sample_of), []).append(point)
if not references:
    raise SystemExit('no point of a set called reference has ended well')


def mass(point):
    return point.quantities['eroded_mass_per_area']  # kg/m2


def seconds(point):
    """Of the coupled part: specimens are made once for many points."""
    return sum(point.seconds.get(name) or 0.0 for name in ('grains', 'water', 'orchestrator'))


def mean_and_error(values):
    return statistics.mean(values), statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.nan


rows, scatters = [], []
for (set_name, label), members in settings.items():
    reference = references.get(members[0].parameters['end_time'])
    if reference is None:
        continue
    whole, scatter = mean_and_error([mass(point) for point in reference.values()])
    paired = [mass(point) / mass(reference[point.parameters['seed']]) - 1 for point in members if point.parameters['seed'] in reference]
    difference, error = mean_and_error(paired) if paired else (math.nan, math.nan)
    if set_name.startswith('reference'):  # its own scatter
        difference, error = 0.0, scatter / whole
    elif len(paired) > 1:
        scatters.append((len(paired) - 1, statistics.variance(paired)))
    halves = [point.quantities.get('half_time') for point in members]
    rows.append((set_name, label, len(members), statistics.mean(map(mass, members)), difference, error, statistics.median(map(seconds, members)),
                 statistics.mean(halves) if None not in halves else None, len(paired)))

# The scatter of a difference from one pair of seeds to the next, from all settings together: two or three pairs of one setting
# say little about it. The median of their variances, each over what the median of such variances is where the true one is 1 (chi
# squared over its degrees of freedom, by Wilson and Hilferty), because a setting that makes other packings scatters far more.
medians = [variance / (1 - 2 / (9 * count)) ** 3 for count, variance in scatters]
pair_scatter = math.sqrt(statistics.median(medians)) if medians else math.nan


def over_scatter(row):
    """The difference over the standard error that the scatter of all settings gives it."""
    return '-' if row[0].startswith('reference') or math.isnan(pair_scatter) else '%+.1f' % (row[4] * math.sqrt(row[8]) / pair_scatter)


{{#timed}}
curves = {}
for set_name in dict.fromkeys(row[0] for row in rows):
    mine = [row for row in rows if row[0] == set_name]
    short = ''.join(letter if letter.isalnum() else '_' for letter in set_name)
    curves[set_name] = sandglass.curve('difference_' + short, [row[6] for row in mine], [row[4] for row in mine], x_unit='s', y_unit='1',
                                       x_name='run time', y_name='difference', label=set_name, kind='computed', points=True,
                                       y_error=[row[5] for row in mine])
sandglass.figure('error_vs_time', title='What a setting changes, and what it costs', panels=[dict(
    x='run time of the coupled part', y='eroded mass per area over that of the reference, less 1', x_scale='log', curves=list(curves.values()),
    marks=[dict(axis='y', value=0.0, label='as it is')])],
    caption='Each mark is one setting; bars are standard errors over seeds, each seed held against the same seed of the reference (none: one seed). '
            'Where specimens differ (section, layers, sides, stiffness, step) the same seed is another packing.')
{{/timed}}

order = {row[1] + row[0]: len(rows) - number for number, row in enumerate(rows)}
sandglass.curve('by_setting', [row[4] for row in rows], [order[row[1] + row[0]] for row in rows], x_unit='1', y_unit='1', x_name='difference',
                y_name='setting', label='difference from the reference', kind='computed', points=True, x_error=[row[5] for row in rows])
sandglass.figure('by_setting', title='By setting', panels=[dict(
    x='eroded mass per area over that of the reference, less 1', y='', curves=['by_setting'], marks=[dict(axis='x', value=0.0, label='as it is')],
    y_names={order[row[1] + row[0]]: '%s: %s' % (row[0], row[1].replace('end_time=1s', '').strip(',') or 'as it is') for row in rows})],
    caption='Bars: standard errors over seeds.')

sandglass.table('settings', 'Settings', ['set', 'setting', 'seeds', 'eroded in g/cm2', 'difference', 'standard error',
                                           'over the common one', {{#timed}}'seconds', {{/timed}}'half time in s'],
                [[row[0], row[1] or 'as it is', row[2], '%.5f' % (row[3] / 10), '%+.3f' % row[4], '-' if math.isnan(row[5]) else '%.3f' % row[5],
                  over_scatter(row), {{#timed}}'%.1f' % row[6], {{/timed}}'-' if row[7] is None else '%.2f' % row[7]] for row in rows],
                caption='The common standard error comes from the median scatter of all settings\' pairs of seeds.')
sandglass.quantity('beads_unaccounted_max', max(point.quantities['beads_unaccounted'] for point in points), '1', 'of all points')
first = references[min(references)]
whole, scatter = mean_and_error([mass(point) for point in first.values()])
sandglass.quantity('eroded_mass_per_area_reference', whole, 'kg/m2', 'mean over the seeds of the reference')
sandglass.quantity('seed_scatter', None if math.isnan(scatter) else scatter * math.sqrt(len(first)) / whole, '1', 'standard deviation over seeds, over the mean')
sandglass.quantity('pair_scatter', None if math.isnan(pair_scatter) else pair_scatter, '1',
                   'standard deviation of the relative difference of a setting from one seed to the next, median of all settings')
sandglass.finish()
