# Building block: growth per window of the washed cell, by theory and from a record.
#
# Law washed, with the speed v ~ i^p of the fines, their fraction phi, C = v dt / L and Gamma = p phi s (1 - w), where
# s = -dlnK/dphi and w is the cell's share of the head: G = exp(-C) - (1 - exp(-C)) Gamma. It oscillates for C > ln(1 + 1/Gamma),
# and grows, if Gamma > 1, for C > ln((Gamma + 1)/(Gamma - 1)).
# Law relative: G = 1 - dt/tau with tau = K (1 - n) rho / (n gamma_w); it oscillates beyond tau and grows beyond 2 tau.
import math

import numpy

from sandglass_column import WATER_WEIGHT


class Cell:
    """Theory at one set of parameters; `start` are the attributes of start.h5."""

    def __init__(self, start, law, exponent, throughput, window, density, cell_height):
        self.law, self.fine, self.disturbance = law, start['fine'], start['first'] / start['fine'] - 1
        if law == 'washed':
            self.ratio = throughput / start['fine'] * window / cell_height  # C
            self.gamma = exponent * start['fine'] * start['slope'] * (1 - start['share'])
            left = math.exp(-self.ratio)
            self.growth = left - (1 - left) * self.gamma
            self.oscillates = math.log1p(1 / self.gamma) if self.gamma > 0 else math.inf
            self.grows = math.log((self.gamma + 1) / (self.gamma - 1)) if self.gamma > 1 else math.inf
        else:
            porosity = start['porosity']
            self.relaxation_time = start['conductivity'] * (1 - porosity) * density / (porosity * WATER_WEIGHT)  # s
            self.ratio = window / self.relaxation_time
            self.gamma = None
            self.growth, self.oscillates, self.grows = 1 - self.ratio, 1.0, 2.0

    def measured(self, record):
        """G from the changes d(n+1) = G d(n), by least squares over the windows that are neither lost in rounding nor too
        far from the fixed point; None where there are none.
        """
        if self.law == 'washed':
            x, scale = record['porosity'][:, 0], self.fine
            near = abs(x - numpy.median(x[:3])) < 1e-4 * scale
        else:
            x = record['speed'][:, 0]
            scale = abs(x[0])
            near = numpy.isfinite(x)
        change = numpy.diff(x)
        usable = near[2:] & near[1:-1] & near[:-2] & (abs(change[:-1]) > 1e-9 * scale)
        if not usable.any():
            return None
        return float(numpy.mean(change[1:][usable] / change[:-1][usable]))  # every window weighs the same

    @property
    def outcome(self):
        """What theory expects of the stability watch; None near the limits, and where a disturbance has grown to the size of
        the fine fraction itself within twelve windows, which a linear theory does not know and the watch cannot tell."""
        if abs(self.growth) > 1.05:
            held = self.law == 'washed' and math.log(1 / self.disturbance) / math.log(abs(self.growth)) < 12
            return None if held else 'unstable'
        if -0.95 < self.growth < -0.05:
            return 'oscillating'
        return 'stable' if 0.05 < self.growth < 0.95 else None
