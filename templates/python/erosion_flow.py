# Building block: what the flow does to the beads of the erosion test, whichever engine moves them. It needs, as names:
# density, section, periodic, radii (of all beads, m), fine_diameter, looser (porosity of a fine layer that is looser than asked for, or
# None).
borders = numpy.linspace(0, {{cell_top}}, {{cells}} + 1)  # m
column = Column(borders, section**2, density, cut={{cell_borders}} == 'cut')
is_fine = radii < fine_diameter
volumes = 4 / 3 * numpy.pi * radii**3  # m3
{{#drag.constant}}
with h5py.File({{start}}, 'r', locking=False) as file:
    solid = (1 - file['porosity'][...]) * column.area * column.heights                         # m3, in each cell
    split_by = {'volume': solid, 'surface': density * solid * file['specific_surface'][...]}   # m3, m2
{{/drag.constant}}


def say_if_looser():
    if looser is not None and sandglass.window.index == 1:
        sandglass.note('the layer of fine beads is looser than asked for, porosity %.3g: in the preparation the wall met a coarse '
                       'bead that lies on top of the others' % looser)


def accounted_for(position, inside, fallen):
    """How many fine beads are where they should be: over the section, whence none has come down beside the plate.

    position: of all beads [beads, 3], m; inside: those that are not aside; fallen: whence they fell in this window, m.
    """
    def over_section(places):
        return numpy.full(len(places), True) if periodic else (abs(places[:, :2] - section / 2) <= section / 2).all(axis=1)

    strayed = numpy.count_nonzero(~over_section(numpy.reshape(fallen, (-1, 3))))
    return numpy.count_nonzero(inside & is_fine & over_section(position)) - strayed


def drag_of(z, pressure_difference, fine_gradient):
    """The drag on every bead at these heights, N, positive downward, and the sum of it that the cells exert."""
{{#drag.coupled}}
    force = column.drag(z, radii, pressure_difference, {{drag_split}})
{{/drag.coupled}}
{{#drag.constant}}
    # One mean force per volume, or surface, for all: that of the specimen's first head loss over the whole coarse layer.
    size = dict(zip(('volume', 'surface'), column.parts(z, radii)))[{{drag_split}}].sum(axis=0)
    total = split_by[{{drag_split}}].sum()
    force = pressure_difference.sum() * column.area * (size / total if total > 0 else 0 * size)
{{/drag.constant}}
    total = force.sum()
{{#fine_layer_drag}}
    force = force + WATER_WEIGHT * fine_gradient / (1 - {{fine_porosity}}) * volumes * (z >= borders[-1])
{{/fine_layer_drag}}
{{#drag_on.fines}}
    force = force * is_fine
{{/drag_on.fines}}
    return force, total
