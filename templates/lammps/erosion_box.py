# Building block: contact law, plate, sides and container of the erosion test for LAMMPS, as yade/erosion_box.py has them
# for YADE. It needs, as names: young, poisson, friction_angle, density, density_scaling, gravity, fluid_density, damping,
# section, periodic, coarse_diameter, fine_diameter, hole, hole_pitch, catch_depth, skin.
import math

import numpy

FINE, COARSE = 1, 2
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
    commands('units si', 'atom_style sphere', 'boundary %s %s f' % (side, side), 'newton off', 'atom_modify map array',
             'processors * 1 1',
             'region box block 0 %.17g 0 %.17g %.17g %.17g units box' % (section, section, -40 * catch_depth, top),
             'create_box 2 box')
    set_lists()


def set_lists():
    # Neighbours in space are neighbours in memory: sorted at the begin of every run of steps and every so many of them.
    commands('atom_modify sort 1000 %.17g' % fine_diameter, 'neighbor %.17g multi' % skin, 'comm_modify mode multi vel yes',
             'neigh_modify delay 0 every 1 check yes one 4000 page 100000', 'neigh_modify collection/type 2 1 2')


def place(kind, positions, radius, velocity=None, spin=None):
    """Makes beads, numbered on from those there are, at rest unless told otherwise."""
    first, count = int(lmp.get_natoms()) + 1, len(positions)
    lmp.command('create_atoms 1 random 0 1 NULL')  # none: but copies of beads beyond a periodic side are forgotten before
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
    if len(numbers) == 0:
        return
    order = numpy.argsort(numbers)
    at = numpy.minimum(numpy.searchsorted(numbers, local('id'), sorter=order), len(numbers) - 1)
    found = numbers[order[at]] == local('id')
    local(name)[found] = numpy.asarray(values)[order[at[found]]]


def beads(name):
    """An array of all beads in the order of their numbers, on every rank."""
    parts = comm.allgather((local('id').copy(), local(name).copy()))
    numbers = numpy.concatenate([part[0] for part in parts])
    return numpy.concatenate([part[1] for part in parts])[numpy.argsort(numbers)]


PAIRS = [(FINE, FINE), (COARSE, COARSE), (FINE, COARSE)]


def set_laws():
    commands('pair_style hybrid ' + ' '.join(pair_law(stiffness(sizes[a], sizes[b])) for a, b in PAIRS))


# A state brings its laws along, with the friction of every contact, but not which pairs of sizes they are for.
def set_pairs():
    commands(*('pair_coeff %d %d gran/hooke/history %d' % (*pair, number + 1) for number, pair in enumerate(PAIRS)))


def set_groups():
    commands('group fines type 1', 'group coarse type 2', 'group moving type 1 2', 'group aside empty', 'group near empty')


# The plate: bars both ways, flat, with their tops at the height 0. Beads may be where they are outside of all bars. Of the
# fine ones only those near it are looked at.
def set_plate():
    if 'plate' not in lmp.available_ids('region'):
        make_bars()
    for group, kind in (('near', FINE), ('coarse', COARSE)):
        commands('fix plate_%s %s wall/gran/region %s region plate'
                 % (group, group, wall_law(stiffness(sizes[kind], 2 * sizes[kind]))))


def make_bars():
    holes = math.floor(section / hole_pitch + 0.5)  # along a side, as gmsh rounds; what pitch there is follows
    pitch = section / holes
    width, names = pitch - hole, []
    for along in 'xy':
        for middle in numpy.arange(holes + 1) * pitch:
            across = '%.17g %.17g' % (max(0, middle - width / 2), min(section, middle + width / 2))
            faces = ('0 %.17g %s' % (section, across)) if along == 'x' else ('%s 0 %.17g' % (across, section))
            # Of two faces at one height, where bars cross, LAMMPS would drop both: the second bars lie a nanometre lower.
            top = 0 if along == 'x' else -1e-9
            names.append('bar%d' % len(names))
            commands('region %s block %s %.17g %.17g side out units box' % (names[-1], faces, -fine_diameter / 2, top))
    commands('region plate intersect %d %s' % (len(names), ' '.join(names)))


# Anew before any bead that was far can have come near.
def find_near():
    near = (local('type') == FINE) & (abs(local('x')[:, 2]) < fine_diameter / 2 + catch_depth)
    local('mask')[:] = local('mask') & ~group_bit('near') | numpy.where(near, group_bit('near'), 0)


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
    find_ranks()
    return numpy.concatenate(comm.allgather(fallen))


def find_ranks():
    """Gives beads that were put somewhere else to the rank that has the place: LAMMPS hands them on to the next one only."""
    if comm.size > 3:
        lmp.command('displace_atoms all move 0 0 0 units box')


def is_aside():
    return (beads('mask') & group_bit('aside')) != 0


# The order matters: damping acts on the sum of what stands before it, as in YADE.
def set_motion(with_drag=False):
    commands('fix motion moving nve/sphere',
             'fix weight moving gravity %.17g vector 0 0 -1' % (gravity * (1 - fluid_density / density)))
    if not periodic:
        for group, kind in (('fines', FINE), ('coarse', COARSE)):
            wall = wall_law(stiffness(sizes[kind], sizes[kind]))
            commands('fix x_%s %s wall/gran %s xplane 0 %.17g' % (group, group, wall, section),
                     'fix y_%s %s wall/gran %s yplane 0 %.17g' % (group, group, wall, section))
    set_plate()
    lmp.command('neigh_modify exclude group aside all')
    if with_drag:  # an array: for a variable that addforce evaluates LAMMPS would sum up the pairs' virial in every step
        lmp.command('fix drag moving external pf/array 1')
    set_damping()


def put_drag(force):
    """Upward forces on all beads in the order of their numbers, N, in every step from now on."""
    lmp.numpy.fix_external_get_force('drag')[: lmp.extract_global('nlocal'), 2] = force[local('id') - 1]


def unset_motion():
    own = {'motion', 'weight', 'damping'}
    commands(*('unfix ' + name for name in lmp.available_ids('fix')
               if name in own or name.startswith(('x_', 'y_', 'plate_'))))


def set_damping():
    commands('fix damping moving damping/cundall %.17g %.17g' % (damping, damping))
