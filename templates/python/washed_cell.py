"""One flow cell without beads: what is in it follows a prescribed law, in which the flow is frozen over a window."""

import math

import h5py

from sandglass_column import WATER_WEIGHT
from sandglass_participant import connect

participant = connect()
with h5py.File({{start}}, "r", locking=False) as file:
    start = dict(file.attrs)
coarse, height, density = {{coarse_fraction}}, {{cell_height}}, {{density}}  # 1, m, kg/m3
{{#law.washed}}
supply = {{throughput}} / height  # of fine fraction, 1/s
steady_speed = {{throughput}} / start["fine"]  # m/s
fine = start["first"]


def advance():
    global fine
    gradient = participant.receive("pressure_difference")[0] / WATER_WEIGHT / height
    speed = steady_speed * (gradient / start["gradient"]) ** {{exponent}}
    # d fine/dt = supply - speed fine/height over the window, exactly.
    rate = speed / height
    left = math.exp(-rate * (participant.window.end - participant.window.begin))
    fine = fine * left + supply / rate * (1 - left)
    answer(speed)
{{/law.washed}}
{{#law.relative}}
fine, speed = start["fine"], 0.0


def advance():
    global speed
    porosity = 1 - coarse - fine
    drag = WATER_WEIGHT * (participant.receive("flux")[0] - porosity * speed) / participant.receive("conductivity")[0]  # N/m3
    speed += (participant.window.end - participant.window.begin) * drag / ((1 - porosity) * density)
    answer(speed)
{{/law.relative}}


def answer(speed):
    solid = coarse + fine
    participant.send("porosity", 1 - solid)
    participant.send("specific_surface", 6 * (coarse / {{coarse_diameter}} + fine / {{fine_diameter}}) / (density * solid))
    participant.send("speed", speed)


participant.serve(advance)
