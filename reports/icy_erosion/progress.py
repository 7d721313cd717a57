#!/usr/bin/env python3
"""How right the time left was that a run told after its first tenth: /usr/bin/python3 reports/icy_erosion/progress.py RUN...

From the times of windows in record.h5, by the rule of the program: the windows to come, each as long as the mean of those
done. Only runs that nothing else on the machine slowed down for a part of their time mean something.
"""

import math
import os
import sys

import h5py

for run in sys.argv[1:]:
    with h5py.File(os.path.join(run, "record.h5"), "r", locking=False) as file:
        windows = int(file["windows"][0])
        timings = file["timings"]
        seconds = sum(timings[name][:windows] for name in ("grains", "water", "exchange", "record", "render") if name in timings)
    first = math.ceil(windows / 10)
    if windows < 2:
        print("%s: one window tells nothing" % run)
        continue
    told, true = seconds[:first].mean() * (windows - first), seconds[first:].sum()
    print("%s: after window %d of %d, %.4g s left were told and %.4g s were true: %+.1f %%"
          % (run, first, windows, told, true, 100 * (told / true - 1)))
