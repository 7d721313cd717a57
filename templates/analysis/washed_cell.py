# The washed cell: growth per window from the record beside theory, and where theory has its limits.
import h5py

import sandglass_analysis as sandglass

{{> analysis/washed_cell_theory.py}}

record = sandglass.open_record()
with h5py.File({{start}}, 'r', locking=False) as file:
    start = dict(file.attrs)
cell = Cell(start, {{law}}, {{exponent}}, {{throughput}}, {{window}}, {{density}}, {{cell_height}})
growth = cell.measured(record)

quantity = sandglass.quantity
quantity('window_ratio', cell.ratio, '1', 'washed: C, the way of a fine bead in a window over the cell; relative: window over tau')
quantity('gamma', cell.gamma, '1', 'feedback of the flow on the fines, p phi s (1 - w)')
quantity('growth_per_window', growth, '1', 'of a disturbance, from the record')
quantity('growth_per_window_theory', cell.growth, '1', 'of a disturbance, theory')
quantity('growth_difference', None if growth is None else (growth - cell.growth) / max(1, abs(cell.growth)), '1',
         'measured less theory, over the larger of 1 and theory')
quantity('oscillates_beyond', cell.oscillates, '1', 'window_ratio beyond which it oscillates')
quantity('grows_beyond', cell.grows, '1', 'window_ratio beyond which it grows; inf: never')
quantity('head_share', start['share'], '1', "the cell's share of the head, where as many fines leave as enter")

name, unit = ('porosity', '1') if cell.law == 'washed' else ('speed', 'm/s')
values = record[name][:, 0]
sandglass.curve(name, record.time, values, 's', unit, 'this run', 'computed')
sandglass.figure('course', title='One flow cell', panels=[dict(y=name, curves=[name])])
sandglass.finish()
