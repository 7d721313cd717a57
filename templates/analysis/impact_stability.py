# Spheres of several densities against a beam, in windows of several lengths and in all schemes: the energy that the coupling
# makes, which runs the stability watch ended, and theory beside both.
#
# An exchange with a lag of l windows of length dt makes, in one impact, the energy l dt * integral of force times the
# acceleration of the contact point, first order in dt (here by the motion of Timoshenko's beam). Besides, a mode of the beam
# of unit mass whose square at the contact point is g moves with the contact spring k; its amplitude grows in a window by
# l k g dt^2 / 2 over (1 + (w dt/2)^2)^2, and so by exp(l dt/2 * integral of k g ... dt) while the contact lasts.
{{> analysis/modal_beam.py}}

import sandglass_analysis as sandglass

right = 0.01  # of the initial energy: what a run may gain or lose at its end and still be called right


class Theory:
    """What beam theory says of one sphere, whatever the coupling."""

    def __init__(self, p):
        self.mass = 4 / 3 * math.pi * p['sphere_radius']**3 * p['sphere_density']
        self.initial = self.mass * p['impact_velocity']**2 / 2
        spring = hertz_stiffness(p['sphere_radius'], p['sphere_young'], p['sphere_poisson'], p['beam_young'], p['beam_poisson'])
        self.beam = Beam(p['beam_length'], p['beam_width'], p['beam_height'], p['beam_young'], p['beam_poisson'],
                         p['beam_density'], p['beam_length'] / 2 + p['impact_offset'], 'timoshenko', modes=40)
        self.run = converged_impact(self.beam, spring, self.mass, p['impact_velocity'], p['end_time'], p['end_time'] / 3000, p['gap'])
        time, force = self.run['time'], self.run['force']
        velocity = numpy.gradient(self.run['deflection'], time)
        self.gain_rate = -numpy.trapz(numpy.gradient(force, time) * velocity, time) / self.initial
        self.stiffness_time = numpy.trapz(1.5 * spring**(2 / 3) * force**(1 / 3), time)  # integral of dF/d(depth), N s/m
        self.contact = numpy.count_nonzero(force) * (time[1] - time[0])

    def exponent(self, lag, window):
        """Of the amplitude of the mode that grows fastest, over all contacts."""
        rates = self.beam.weight**2 / (1 + (self.beam.omega * window / 2)**2)**2
        return lag * window / 2 * self.stiffness_time * rates.max()

    def window_at(self, lag, exponent):
        """The shortest window with this exponent, s, or none."""
        windows = numpy.geomspace(1e-9, 1e-3, 2000)
        beyond = [window for window in windows if self.exponent(lag, window) > exponent]
        return beyond[0] if beyond else math.nan


class Case:
    def __init__(self, point):
        p = point.parameters
        self.point, self.window, self.density = point, p['time_step'], p['sphere_density']
        predicted, scheme = p['wall_prediction'], p['scheme']
        self.method = ('iterated, IQN-ILS' if scheme == 'serial-implicit' else
                       'parallel' if scheme == 'parallel-explicit' else 'wall predicted' if predicted else 'as published')
        self.lag = {'iterated, IQN-ILS': 0, 'parallel': 2, 'wall predicted': 0, 'as published': 1}[self.method]
        if self.density not in theories:
            theories[self.density] = Theory(p)
        self.theory = theories[self.density]
        record = point.record()
        energy = record['sphere_energy'].sum(axis=1) + record['beam_energy'].sum(axis=1)
        self.growth = float(energy[-1] / self.theory.initial)
        self.exponent = self.theory.exponent(self.lag, self.window)
        self.first_order = self.lag * self.window * self.theory.gain_rate

    @property
    def outcome(self):
        if self.point.exit_code == 5:
            return 'ended: energy doubled'
        return 'energy kept within 1 %' if abs(self.growth - 1) <= right else 'energy off by more'


theories = {}
cases = [Case(point) for point in sandglass.open_study() if point.exit_code in (0, 5, 6)]
ended = [case for case in cases if case.point.exit_code == 5]
sandglass.quantity('points_ended', len(ended), '1', 'runs that the stability watch ended')
sandglass.quantity('points_ended_without_lag', sum(case.lag == 0 for case in ended), '1', 'of these, runs without a lag')
quiet = [case for case in cases if case.lag and case.exponent < 0.3 and case.window < case.theory.contact / 100]
sandglass.quantity('first_order_difference_max',
                   max((abs(case.growth - 1 - case.first_order) / case.first_order for case in quiet), default=None), '1',
                   'largest relative difference of the gain from its first-order theory where the contact takes 100 windows '
                   'and its oscillation grows by less than exp(0.3)')
sandglass.quantity('least_exponent_ended', min((case.exponent for case in ended if case.lag), default=None), '1',
                   'of runs with a lag: by theory an oscillation of the contact would grow by exp of this while it lasts')
sandglass.quantity('largest_exponent_not_ended', max((case.exponent for case in cases if case not in ended), default=None), '1',
                   'the same of runs that came to their end')

# The map: a panel for every scheme.
densities = sorted(theories)
panels = []
for number, method in enumerate(dict.fromkeys(case.method for case in cases)):
    mine = [case for case in cases if case.method == method]
    curves = []
    for k, outcome in enumerate(('energy kept within 1 %', 'energy off by more', 'ended: energy doubled')):
        some = [case for case in mine if case.outcome == outcome]
        if some:
            curves.append(sandglass.curve(
                'map_%d_%d' % (number, k), [case.window for case in some], [case.density / 7960 for case in some], x_unit='s',
                y_unit='1', x_name='window', y_name='density over that of steel', label=outcome, kind='computed', points=True))
    lag = mine[0].lag
    if lag:
        limits = (('gain', 'theory: gain of 1 %', [right / (lag * theories[density].gain_rate) for density in densities]),
                  ('growth', 'theory: an oscillation grows by e', [theories[density].window_at(lag, 1.0) for density in densities]))
        for name, label, windows in limits:
            curves.append(sandglass.curve(
                'map_%d_%s' % (number, name), windows, [density / 7960 for density in densities], x_unit='s', y_unit='1',
                x_name='window', y_name='density over that of steel', label=label, kind='analytic'))
    panels.append(dict(x='window', x_unit='us', y='%s: density over that of steel' % method, x_scale='log', y_scale='log',
                       curves=curves))
sandglass.figure('map', title='Which windows hold a contact', panels=panels,
                 caption='Each mark is one coupled run of YADE and FreeFEM. A run is ended (exit status 5) when its energy has '
                         'doubled. Without a lag theory has no limit.')
sandglass.table('points', 'All points', ['scheme', 'density over steel', 'window', 'windows in contact', 'energy at the end',
                                         'first-order gain', 'growth of an oscillation', 'outcome'],
                [[case.method, '%g' % (case.density / 7960), '%g us' % (1e6 * case.window),
                  '%.3g' % (case.theory.contact / case.window), '%.5g' % case.growth, '%.3g' % case.first_order,
                  'e^%.3g' % case.exponent, case.outcome] for case in cases])
sandglass.finish()
