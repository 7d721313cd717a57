# All points of the washed cell: growth per window from the records against theory, the verdicts of the stability watch
# against theory, and the map of what is stable.
import os

import h5py

import sandglass_analysis as sandglass

{{> analysis/washed_cell_theory.py}}


class Point:
    """One run with its theory."""

    def __init__(self, point):
        self.point, p = point, point.parameters
        with h5py.File(os.path.join(point.run, 'stages', 'start', 'start.h5'), 'r', locking=False) as file:
            start = dict(file.attrs)
        self.cell = Cell(start, *(p[name] for name in ('law', 'exponent', 'throughput', 'window', 'density', 'cell_height')))
        self.growth = self.cell.measured(point.record())

    @property
    def outcome(self):
        if self.point.exit_code == 5:
            return 'unstable'
        return 'oscillating' if any('oscillat' in note for note in self.point.notes) else 'stable'

    @property
    def difference(self):
        return None if self.growth is None else abs(self.growth - self.cell.growth) / max(1, abs(self.cell.growth))

    @property
    def against_theory(self):
        expected = self.cell.outcome
        if expected == 'oscillating':  # the watch notes it only while it is far above rounding
            return self.outcome == 'unstable'
        return expected is not None and self.outcome != expected


points = [Point(point) for point in sandglass.open_study() if point.exit_code in (0, 5, 6)]
washed = [one for one in points if one.cell.law == 'washed']
relative = [one for one in points if one.cell.law == 'relative']
measured = [one for one in points if one.difference is not None]
worst = max(measured, key=lambda one: one.difference)
sandglass.quantity('growth_difference_max', worst.difference, '1',
                   'largest |G measured - G theory|, over max(1, |G|), of all points: ' + worst.point.label)
sandglass.quantity('growths_measured', len(measured), '1', 'points whose growth per window could be measured')
wrong = [one.point.label for one in points if one.against_theory]
sandglass.quantity('verdicts_against_theory', len(wrong), '1',
                   'points that ended otherwise than theory says' + (': ' + '; '.join(wrong[:5]) if wrong else ''))
sandglass.quantity('verdicts_checked', sum(one.cell.outcome is not None for one in points), '1',
                   'points far enough from the limits for theory to say how they end')

# ---- the map: window against feedback

axes = dict(x_unit='1', y_unit='1', x_name='C', y_name='Gamma')
curves = []
for outcome in ('stable', 'oscillating', 'unstable'):
    mine = [one.cell for one in washed if one.outcome == outcome]
    if mine:
        curves.append(sandglass.curve('map_' + outcome, [cell.ratio for cell in mine], [cell.gamma for cell in mine],
                                      label=outcome, kind='computed', points=True, **axes))
gamma = numpy.geomspace(0.3, 8, 400)
curves.append(sandglass.curve('map_oscillates', numpy.log1p(1 / gamma), gamma, label='theory: oscillates beyond', kind='analytic', **axes))
gamma = gamma[gamma > 1.03]
curves.append(sandglass.curve('map_grows', numpy.log((gamma + 1) / (gamma - 1)), gamma, label='theory: grows beyond', kind='analytic',
                              **axes))
sandglass.figure('map', title='Fines washed through a cell: what is stable', panels=[
    dict(x='way of a fine bead in a window over the cell, C', y='feedback of the flow, Gamma', x_scale='log', y_scale='log', curves=curves)],
    caption="Each mark is one coupled run with FreeFEM's head, judged by the stability watch: unstable ended with exit status 5. "
            "ICY's cell and window are C = 0.27, Gamma = 1.25 for a speed that goes as the gradient.")

# ---- growth per window

for name, title, mine, label in (
        ('growth_washed', 'Fines washed through a cell', washed, lambda cell: 'Gamma = %.3g' % cell.gamma),
        ('growth_relative', 'Drag by relative velocity', relative, lambda cell: 'window / tau')):
    panel, families = [], {}
    for one in mine:
        if one.growth is not None:
            families.setdefault(label(one.cell), []).append(one)
    for number, (family, members) in enumerate(sorted(families.items())):
        members.sort(key=lambda one: one.cell.ratio)
        x = [one.cell.ratio for one in members]
        axes = dict(x_unit='1', y_unit='1', x_name='C' if mine is washed else 'window / tau', y_name='G')
        panel.append(sandglass.curve('%s_%d' % (name, number), x, [one.growth for one in members], label=family, kind='computed',
                                     points=True, **axes))
        ratio = numpy.geomspace(0.05, 4.5, 200)
        cell = members[0].cell
        theory = (numpy.exp(-ratio) - (1 - numpy.exp(-ratio)) * cell.gamma) if mine is washed else 1 - ratio
        inside = theory > -4
        panel.append(sandglass.curve('%s_theory_%d' % (name, number), ratio[inside], theory[inside], label='theory, ' + family,
                                     kind='analytic', **axes))
    sandglass.figure(name, title=title, panels=[dict(
        x='way of a fine bead in a window over the cell, C' if mine is washed else 'window over tau', y='growth per window G', curves=panel,
        marks=[dict(axis='y', value=0.0, label='oscillates below'), dict(axis='y', value=-1.0, label='grows below')])])

rows = [[one.point.set, one.point.parameters['window'], one.cell.ratio, '-' if one.cell.gamma is None else '%.4f' % one.cell.gamma,
         '%.4f' % one.cell.oscillates, '%.4f' % one.cell.grows, '-' if one.growth is None else '%.8f' % one.growth,
         '%.8f' % one.cell.growth, one.outcome] for one in points]
sandglass.table('points', 'Growth per window', ['points', 'window in s', 'C, or window / tau', 'Gamma', 'oscillates beyond', 'grows beyond',
                                                'G measured', 'G theory', 'run'], rows)
sandglass.finish()
