# Building block: what the flow does to the beads of the erosion test, whichever engine moves them. It needs, as names:
# density, section, radii (of all beads, m), fine_diameter, looser (porosity of a fine layer that is looser than asked for, or
# None).
borders = numpy.linspace(0, {{cell_top}}, {{cells}} + 1)  # m
column = Column(borders, section**2, density, cut={{cell_borders}} == 'cut')
is_fine = radii < fine_diameter
volumes = 4 / 3 * numpy.pi * radii**3  # m3
{{#drag.constant}}
with h5py.File({{start}}, 'r', locking=False) as file:
    initial_porosity = file['porosity'][...].mean()
{{/drag.constant}}


def say_if_looser():
    if looser is not None and sandglass.window.index == 1:
        sandglass.note('the layer of fine beads is looser than asked for, porosity %.3g: in the preparation the wall met a coarse '
                       'bead that lies on top of the others' % looser)


def drag_of(z, pressure_difference, fine_gradient):
    """The drag on every bead at these heights, N, positive downward, and the sum of it that the cells exert."""
{{#drag.coupled}}
    force = column.drag(z, radii, pressure_difference, {{drag_split}})
{{/drag.coupled}}
{{#drag.constant}}
    # One mean force per volume for all: that of the specimen's first head loss over the whole coarse layer.
    force = pressure_difference.sum() / borders[-1] / (1 - initial_porosity) * volumes * ((z > 0) & (z < borders[-1]))
{{/drag.constant}}
    total = force.sum()
{{#fine_layer_drag}}
    force = force + WATER_WEIGHT * fine_gradient / (1 - {{fine_porosity}}) * volumes * (z >= borders[-1])
{{/fine_layer_drag}}
{{#drag_on.fines}}
    force = force * is_fine
{{/drag_on.fines}}
    return force, total
