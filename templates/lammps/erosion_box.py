# Building block: contact law, plate, sides and container of the erosion test for LAMMPS, as yade/erosion_box.py has them
# for YADE. It needs, as names: young, poisson, friction_angle, density, density_scaling, gravity, fluid_density, damping,
# section, periodic, coarse_diameter, fine_diameter, hole, hole_pitch, catch_depth, skin.
import math

import numpy

FINE, COARSE, PLATE = 1, 2, 3
sizes = {FINE: fine_diameter / 2, COARSE: coarse_diameter / 2}  # radii, m


def stiffness(one, other):
    """YADE's normal stiffness of a contact, 2 E r r' / (r + r'), N/m. A plane has the bead's own radius, a facet twice that."""
    return 2 * young * one * other / (one + other)


def pair_law(normal):
    return 'gran/hooke/history %.17g %.17g 0 0 %.17g 0' % (normal, poisson * normal, math.tan(friction_angle))


def wall_law(normal):
    # The same; the short form of it divides the two dampings, which are none.
    return ('granular hooke %.17g 0 tangential linear_history %.17g 0 %.17g damping velocity'
            % (normal, poisson * normal, math.tan(friction_angle)))


def commands(*lines):
    lmp.commands_string('\n'.join(lines))


def make_box(top):
    side = 'p' if periodic else 'f'
    commands('units si', 'atom_style sphere', 'boundary %s %s f' % (side, side), 'newton off',
             'atom_modify map array sort 0 0', 'neighbor %.17g multi' % skin, 'comm_modify mode multi vel yes', 'processors * 1 1',
             'region box block 0 %.17g 0 %.17g %.17g %.17g units box' % (section, section, -40 * catch_depth, top),
             'create_box 3 box')


def place(kind, positions, radius, velocity=None, spin=None):
    """Makes beads, numbered on from those there are, at rest unless told otherwise."""
    first, count = int(lmp.get_natoms()) + 1, len(positions)
    lmp.create_atoms(count, list(range(first, first + count)), [kind] * count, numpy.ascontiguousarray(positions).ravel())
    commands('group new id %d:%d' % (first, first + count - 1),
             'set group new diameter %.17g density %.17g' % (2 * radius, density * density_scaling))
    for name, values in (('v', velocity), ('omega', spin)):
        if values is not None:
            put(name, numpy.arange(first, first + count), values)
    commands('group new delete')


def local(name):
    return lmp.numpy.extract_atom(name)[: lmp.extract_global('nlocal')]


def put(name, numbers, values):
    """Writes an array of some beads, by number; each rank those that it has."""
    order = numpy.argsort(numbers)
    at = numpy.minimum(numpy.searchsorted(numbers, local('id'), sorter=order), len(numbers) - 1)
    found = numbers[order[at]] == local('id')
    local(name)[found] = numpy.asarray(values)[order[at[found]]]


def gather(name):
    """An array of all beads in the order of their numbers, on every rank."""
    parts = comm.allgather((local('id').copy(), local(name).copy()))
    numbers = numpy.concatenate([part[0] for part in parts])
    return numpy.concatenate([part[1] for part in parts])[numpy.argsort(numbers)]


def set_laws():
    pairs = [(FINE, FINE), (COARSE, COARSE), (FINE, COARSE), (FINE, PLATE), (COARSE, PLATE), (PLATE, PLATE)]
    # To a facet, for which the plate's beads stand, YADE gives twice the bead's radius.
    normal = [stiffness(sizes.get(a, 1), 2 * sizes.get(a, 1) if b == PLATE else sizes[b]) for a, b in pairs]
    commands('pair_style hybrid ' + ' '.join(map(pair_law, normal)),
             *('pair_coeff %d %d gran/hooke/history %d' % (*pair, number + 1) for number, pair in enumerate(pairs)),
             'neigh_modify delay 0 every 1 check yes one 4000 page 100000', 'neigh_modify collection/type 2 1,3 2', 'neigh_modify exclude type 3 3',
             'group fines type 1', 'group coarse type 2', 'group moving type 1 2', 'group aside empty',
             'neigh_modify exclude group aside all')


# The plate: bars both ways, with their tops at the height 0, of beads that do not move. Four rows to a bar, so close that
# a fine bead feels it as flat, nearly: single rows of the bars' width let a third more beads through.
def place_plate():
    width = hole_pitch - hole
    radius = width / 4
    rows = numpy.add.outer(numpy.arange(round(section / hole_pitch) + 1) * hole_pitch, numpy.linspace(-radius, radius, 4)).ravel()
    rows = rows[(rows > 0) & (rows < section)]
    along = numpy.linspace(0, section, round(section / (width / 6)) + 1)[1:-1]
    points = {(round(x, 9), round(y, 9)) for x in rows for y in along}
    points = numpy.array(sorted(points | {(y, x) for x, y in points}))
    place(PLATE, numpy.column_stack((points, numpy.full(len(points), -radius))), radius)


def group_bit(name):
    return 1 << lmp.available_ids('group').index(name)


# As in YADE: each at a place of its own far below, out of all groups that anything is done to.
def put_aside():
    position, mask = local('x'), local('mask')
    below = (position[:, 2] < -catch_depth) & (local('type') == FINE) & ((mask & group_bit('aside')) == 0)
    fallen = position[below].copy()
    spacing = 1.1 * fine_diameter
    per_side = int(section / spacing)
    layer, site = numpy.divmod(local('id')[below], per_side**2)
    position[below] = numpy.column_stack(((site % per_side + 0.5) * spacing, (site // per_side + 0.5) * spacing,
                                          -10 * catch_depth - layer * spacing))
    local('v')[below] = local('omega')[below] = 0
    mask[below] = mask[below] & ~group_bit('moving') & ~group_bit('fines') | group_bit('aside')
    return numpy.concatenate(comm.allgather(fallen))


def beads(name):
    """An array of all beads but those of the plate, in the order of their numbers, on every rank."""
    return gather(name)[gather('type') != PLATE]


def is_aside():
    return (beads('mask') & group_bit('aside')) != 0


# The order matters: damping acts on the sum of what stands before it, as in YADE.
def set_motion():
    commands('fix motion moving nve/sphere',
             'fix weight moving gravity %.17g vector 0 0 -1' % (gravity * (1 - fluid_density / density)))
    if not periodic:
        for group, kind in (('fines', FINE), ('coarse', COARSE)):
            wall = wall_law(stiffness(sizes[kind], sizes[kind]))
            commands('fix x_%s %s wall/gran %s xplane 0 %.17g' % (group, group, wall, section),
                     'fix y_%s %s wall/gran %s yplane 0 %.17g' % (group, group, wall, section))
    commands('fix keep all property/atom d_drag', 'variable drag atom d_drag', 'fix drag moving addforce 0 0 v_drag')
    set_damping()


def set_damping():
    commands('fix damping moving damping/cundall %.17g %.17g' % (damping, damping))
