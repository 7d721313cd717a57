# Error against run time over the points of a study: one line per method, the efficient frontier, the cheapest settings.
#
# Points that differ in seeds and repetitions only are samples of one setting: their medians are drawn, and error bars of
# one standard deviation where there are at least two samples.
import math
import statistics

import sandglass_analysis as sandglass

error_name = {{error}}                          # the quantity that is, or has, the error
reference_values = {{reference_values}}         # what it should be: one number, or none
reference_quantity = {{reference_quantity}}     # or another quantity, or ''
sets = {{sets}}                                 # names of the sets of points; none: all
method_parameters = {{method}}                  # what divides a set of points into methods
seconds_names = {{seconds}}                     # what counts as the price; none: the whole run


def error_of(point):
    """The size of the error, or None where it is not defined."""
    value = point.quantities.get(error_name)
    if not isinstance(value, (int, float)):
        return None
    if reference_values:
        reference = reference_values[0]
    elif reference_quantity:
        reference = point.quantities.get(reference_quantity)
        if not isinstance(reference, (int, float)):
            return None
    else:
        return abs(value)
    return abs(value - reference) / (abs(reference) or 1)


def seconds_of(point):
    """The price, or None when a part of it was not measured."""
    parts = [point.seconds.get(name) for name in seconds_names or ['run']]
    if seconds_names:  # a stage that a point does not have costs it nothing
        parts = [part for part in parts if part is not None]
    return sum(parts) if parts and None not in parts else None


def word_of(name, value):
    """A parameter as a part of a method's name: a switch by its own name where it is on, 'none' as nothing."""
    if isinstance(value, bool):
        return name.replace('_', ' ') if value else ''
    return '' if value in (None, 'none') else '%s' % value


def method_of(point):
    words = [point.set] + [word_of(name, point.parameters.get(name)) for name in method_parameters]
    return ', '.join(word for word in words if word) or 'all points'


points = [point for point in sandglass.open_study() if not sets or point.set in sets]
samples = {}
left_out = []
for point in points:
    error, seconds = error_of(point), seconds_of(point)
    if point.good and error is not None and seconds is not None and math.isfinite(error) and seconds > 0:
        samples.setdefault((method_of(point), point.sample_of), []).append((seconds, error))
    else:
        left_out.append(point.label)
if not samples:
    raise SystemExit('no point has both the quantity %s and its seconds' % error_name)


def spread(values):
    return statistics.stdev(values) if len(values) > 1 else 0.0


rows = []  # (seconds, error, method, setting, spread of seconds, spread of error, samples)
for (method, setting), pairs in samples.items():
    seconds, errors = zip(*pairs)
    rows.append((statistics.median(seconds), statistics.median(errors), method, setting, spread(seconds),
                 spread(errors), len(pairs)))

# Nobody is both faster and more accurate (a logarithmic axis has no place for an exact agreement).
frontier, best = [], math.inf
for row in sorted(rows):
    if row[1] < best:
        frontier.append(row)
        best = row[1]

# ---- curves and the figure

short = error_name if len(error_name) <= 60 else error_name[:60]
names = []
for number, method in enumerate(dict.fromkeys(row[2] for row in rows), 1):  # in the study's order, as its lines are
    mine = [row for row in rows if row[2] == method and row[1] > 0]
    if not mine:
        continue
    several = any(row[6] > 1 for row in mine)
    names.append(sandglass.curve(
        '%s_method_%d' % (short, number), [row[0] for row in mine], [row[1] for row in mine], x_unit='s', y_unit='1',
        x_name='run time', y_name='error', label=method, kind='computed',
        x_error=[row[4] for row in mine] if several else None, y_error=[row[5] for row in mine] if several else None))
drawn = [row for row in frontier if row[1] > 0]
if drawn:
    names.append(sandglass.curve(
        '%s_frontier' % short, [row[0] for row in drawn], [row[1] for row in drawn], x_unit='s', y_unit='1',
        x_name='run time', y_name='error', label='efficient frontier', kind='analytic'))

price = 'of ' + ', '.join(seconds_names) if seconds_names else 'of the whole run, from its start to its report'
counts = sorted({row[6] for row in rows})
caption = ('Error: %s%s. Seconds: %s;' % (
    error_name, ', relative to its reference' if reference_values or reference_quantity else '', price))
caption += ' medians and standard deviations of %s runs per point.' % ' to '.join(
    '%d' % n for n in sorted({counts[0], counts[-1]})) if counts[-1] > 1 else ' every point is a single run.'
caption += ' On the frontier nothing is both faster and more accurate.'
loads = sorted(point.load for point in points if point.load is not None)
if loads:
    caption += (' Load of the machine when runs ended: %.1f to %.1f waiting or running processes, the run itself among them.'
                % (loads[0], loads[-1]))
if left_out:
    caption += ' Without a result and not shown: %s.' % '; '.join(left_out[:10])
if names:
    sandglass.figure('precision_of_%s' % short, title='Error against run time: %s' % error_name.replace('_', ' '),
                     panels=[dict(x='run time', y='error', x_scale='log', y_scale='log', curves=names)],
                     caption=caption)

# ---- the cheapest setting for an error

table = []
worst, least = max(row[1] for row in rows), min(row[1] for row in rows)
if worst > 0:
    highest = math.floor(math.log10(worst))
    lowest = math.floor(math.log10(least)) + 1 if least > 0 else highest
    for power in range(highest, max(lowest, highest - 15) - 1, -1):
        enough = [row for row in rows if row[1] <= 10.0**power]
        if enough:
            cheapest = min(enough)
            table.append(['1e%d' % power, '%.3g' % cheapest[1], '%.3g s' % cheapest[0], cheapest[2], cheapest[3]])
sandglass.table('cheapest_%s' % short, 'Cheapest setting for an error: %s' % error_name.replace('_', ' '),
                ['error at most', 'its error', 'its time', 'method', 'setting'], table)

sandglass.quantity('least_error_of_%s' % short, least, '1', 'the smallest error of all points')
sandglass.quantity('seconds_of_least_error_of_%s' % short, min(row[0] for row in rows if row[1] == least), 's',
                   'what it took')
sandglass.finish()
