# One coupling window of erosion.py: the drag on every bead from the pressure differences of its cells, then YADE's own
# steps, then the fallen beads are counted and put back, and the cells looked at.
{{^drag.none}}
pressure_difference = sandglass.receive('pressure_difference')
fine_gradient = sandglass.receive('fine_gradient')[0]
{{/drag.none}}
aside_before = sum(map(is_aside, fines()))
fallen_at.clear()

{{^drag.none}}
apply_drag()
sandglass.send('drag_total', drag_total)
{{/drag.none}}
O.run(round({{exchange_window}} / O.dt), True)
put_aside()

eroded = sum(map(is_aside, fines())) - aside_before
near = [min(x, section - x, y, section - y) < 0.5e-3 for x, y, z in fallen_at]
sandglass.send('eroded', eroded)
sandglass.send('eroded_at_sides', sum(near))
{{#reinsertion}}
put_back(sandglass.window.index)
collider()  # which does not see that beads were moved by hand
{{/reinsertion}}
place = positions()
inside = numpy.array([not is_aside(bead) for bead in beads()])
porosity, specific_surface = column.contents(place[inside, 2], radii[inside])
sandglass.send('porosity', porosity)
sandglass.send('specific_surface', specific_surface)
sandglass.send('fines_inside', accounted_for(place, inside, fallen_at))
sandglass.send('fines_aside', numpy.count_nonzero(~inside))
if sandglass.wants('position'):
    sandglass.send('position', place)
say_if_looser()
