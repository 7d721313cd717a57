# Building block: contact law, plate and sides of the erosion test, and the container below. It needs, as names: young,
# poisson, friction_angle, density, density_scaling, gravity, fluid_density, damping, section, periodic,
# fine_diameter, verlet_distance, plate (file), catch_depth, catch_steps, what is left out (forget_fallen, plane_sides,
# needed_functors); and then fine_ids, fallen_at.
import math

import h5py
import numpy

# Density scaling: mass, weight, buoyancy and drag times the same factor, so accelerations stay and the step is longer.
glass = O.materials.append(FrictMat(young=young, poisson=poisson, frictionAngle=friction_angle,
                                    density=density * density_scaling, label='glass'))
BEAD, WALL = 0b01, 0b11  # bodies meet that share a bit; walls and plate, by their second one, not each other

if periodic:
    O.periodic = True
    O.cell.hSize = Matrix3(section, 0, 0, 0, section, 0, 0, 0, 1.0)
else:
    for axis in (0, 1):
        for place in (0, section):
            if plane_sides:
                O.bodies.append(wall(place, axis=axis, material='glass', mask=WALL))
                continue
            # Two triangles in the place of a plane, to above every cloud of beads.
            along = [(0, -20 * catch_depth), (section, -20 * catch_depth), (section, 1.0), (0, 1.0)]
            corners = [(place, a, z) if axis == 0 else (a, place, z) for a, z in along]
            for three in ((0, 1, 2), (0, 2, 3)):
                O.bodies.append(facet([corners[corner] for corner in three], material='glass', mask=WALL))
with h5py.File(plate, 'r', locking=False) as file:
    for corners in file['triangles'][...]:
        O.bodies.append(facet([tuple(corner) for corner in corners], material='glass', mask=WALL))

bounds = [Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()]
contacts = [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()]
if not needed_functors:  # and those of bodies that the scene has not
    bounds += [Bo1_Box_Aabb()]
    contacts += [Ig2_Box_Sphere_ScGeom()]
O.engines = [
    ForceResetter(),
    # One margin for all: YADE's own, of each bead by its last motion, leaves beads that hardly move so little that the
    # lists are made anew nearly every step.
    InsertionSortCollider(bounds, verletDist=verlet_distance, targetInterv=-1, avoidSelfInteractionMask=0b10, label='collider'),
    InteractionLoop(contacts,
                    [Ip2_FrictMat_FrictMat_FrictPhys()],
                    [Law2_ScGeom_FrictPhys_CundallStrack()]),
    # Weight less buoyancy; damped like every other force, as everywhere in YADE.
    NewtonIntegrator(gravity=(0, 0, -gravity * (1 - fluid_density / density)), damping=damping, mask=0,
                     label='newton'),
    PyRunner(command='put_aside()', iterPeriod=max(1, catch_steps), label='catcher'),
]


def add_bead(position, radius, velocity=(0, 0, 0), spin=(0, 0, 0)):
    bead = sphere(tuple(position), radius, material='glass', mask=BEAD)
    bead.state.vel, bead.state.angVel = tuple(velocity), tuple(spin)
    return O.bodies.append(bead)


def is_aside(bead):
    return bead.state.blockedDOFs == 'xyzXYZ'


# A bead that has fallen through the plate feels nothing any more: it is put aside, at rest, each at a place of its own
# far below, and costs no contact and no new neighbour list.
def put_aside():
    for bead in fines():
        if bead.state.pos[2] < -catch_depth and not is_aside(bead):
            fallen_at.append(tuple(O.cell.wrap(bead.state.pos) if periodic else bead.state.pos))
            bead.state.blockedDOFs = 'xyzXYZ'
            bead.state.vel = bead.state.angVel = Vector3.Zero
            bead.state.pos = aside_place(bead.id)
            if forget_fallen:
                bead.bounded, bead.bound = False, None  # no collider looks at it


def aside_place(number):
    spacing = 1.1 * fine_diameter
    per_side = int(section / spacing)
    layer, site = divmod(number, per_side**2)
    return Vector3((site % per_side + 0.5) * spacing, (site // per_side + 0.5) * spacing,
                   -10 * catch_depth - layer * spacing)


def fines():
    return [O.bodies[number] for number in fine_ids]  # fetched anew: loading a state replaces the bodies
