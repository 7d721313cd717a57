# One coupling window of erosion.py: the drag on every bead from the pressure differences of its cells, then LAMMPS's own
# steps, then the fallen beads are counted and put back, and the cells looked at.
{{^drag.none}}
pressure_difference = sandglass.receive('pressure_difference')
fine_gradient = sandglass.receive('fine_gradient')[0]
sandglass.send('drag_total', apply_drag())
{{/drag.none}}
fallen, done = [], 0
while done < window_steps:
    steps = min(catch_steps, window_steps - done)
    find_near()
    lmp.command('run %d post no' % steps)
    done += steps
    fallen.extend(put_aside())
{{#drag_follows.place}}
{{^drag.none}}
    if done // refresh_steps > (done - steps) // refresh_steps:
        apply_drag()
{{/drag.none}}
{{/drag_follows.place}}
near = [min(x, section - x, y, section - y) < 0.5e-3 for x, y, z in fallen]
sandglass.send('eroded', len(fallen))
sandglass.send('eroded_at_sides', sum(near))
{{#reinsertion}}
put_back(sandglass.window.index)
{{/reinsertion}}
place, inside = beads('x'), ~is_aside()
porosity, specific_surface = column.contents(place[inside, 2], radii[inside])
sandglass.send('porosity', porosity)
sandglass.send('specific_surface', specific_surface)
sandglass.send('fines_inside', accounted_for(place, inside, fallen))
sandglass.send('fines_aside', numpy.count_nonzero(~inside))
if sandglass.wants('position'):
    sandglass.send('position', place)
say_if_looser()
