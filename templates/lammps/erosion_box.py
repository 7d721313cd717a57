# Building block: contact law, plate, sides and container of the erosion test for LAMMPS, as yade/erosion_box.py has them
# for YADE. It needs, as names: young, poisson, friction_angle, density, density_scaling, gravity, fluid_density, damping,
# section, periodic, coarse_diameter, fine_diameter, hole, hole_pitch, catch_depth, skin.
import math

import numpy

FINE, COARSE, PLATE = 1, 2, 3
sizes = {FINE: fine_diameter / 2, COARSE: coarse_diameter / 2}  # radii, m
plate_radius = (hole_pitch - hole) / 2


def stiffness(one, other):
    """YADE's normal stiffness of a contact, 2 E r r' / (r + r'), N/m. A plane has the bead's own radius; so has a bar."""
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


# Bars without thickness are rows of beads that do not move, of the bars' width, with their tops at the height 0.
def place_plate():
    n = round(section / hole_pitch)
    along = numpy.linspace(0, section, 2 * round(section / (2 * plate_radius)) + 1)[0 if not periodic else 1:]
    across = numpy.linspace(0, section, n + 1)[0 if not periodic else 1:]
    inside = lambda x: numpy.clip(x, 1e-9 * section, (1 - 1e-9) * section)
    points = {(round(x, 9), round(y, 9)) for x in across for y in along} | {(round(x, 9), round(y, 9)) for x in along for y in across}
    points = numpy.array(sorted(points))
    place(PLATE, numpy.column_stack((inside(points), numpy.full(len(points), -plate_radius))), plate_radius)


def set_laws():
    pairs = [(FINE, FINE), (COARSE, COARSE), (FINE, COARSE), (FINE, PLATE), (COARSE, PLATE)]
    # A bar stands for a facet, to which YADE gives twice the bead's radius.
    normal = [stiffness(sizes[a], 2 * sizes[a] if b == PLATE else sizes[b]) for a, b in pairs]
    commands('pair_style hybrid ' + ' '.join(map(pair_law, normal)),
             *('pair_coeff %d %d gran/hooke/history %d' % (min(pair), max(pair), number + 1) for number, pair in enumerate(pairs)),
             'pair_coeff 3 3 gran/hooke/history 4',
             'neigh_modify delay 0 every 1 check yes one 4000 page 100000',
             'neigh_modify collection/type 2 1,3 2', 'neigh_modify exclude type 3 3',
             'group fines type 1', 'group coarse type 2', 'group moving type 1 2', 'group aside empty',
             'neigh_modify exclude group aside all')


# The order matters: damping acts on the sum of what stands before it, as in YADE.
def set_motion():
    commands('fix motion moving nve/sphere',
             'fix weight moving gravity %.17g vector 0 0 -1' % (gravity * (1 - fluid_density / density)))
    if not periodic:
        for group, kind in (('fines', FINE), ('coarse', COARSE)):
            wall = wall_law(stiffness(sizes[kind], sizes[kind]))
            commands('fix x_%s %s wall/gran %s xplane 0 %.17g' % (group, group, wall, section),
                     'fix y_%s %s wall/gran %s yplane 0 %.17g' % (group, group, wall, section))
    commands('fix keep all property/atom d_drag', 'variable drag atom d_drag', 'fix drag moving addforce 0 0 v_drag',
             'fix damping moving damping/cundall %.17g %.17g' % (damping, damping))
