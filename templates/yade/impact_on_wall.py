# A sphere strikes a wall that another solver moves: Hertz contact without friction, restitution 1, no gravity. This is
# the set-up; impact_on_wall_window.py is one window.
#
# x runs along the wall, y up, z across; the wall rests at y = 0 and the sphere comes from above. The wall is made of
# segments (2-D) or triangles (3-D) between points whose displacement and velocity are received. YADE itself would make
# one contact with every facet that a sphere touches, two over a shared edge, so it is shown one facet: the tangent plane
# at the place of the wall next to the sphere, put there anew in every step. A smooth wall has one contact.

radius = {{sphere_radius}}                    # m
impact_velocity = {{impact_velocity}}         # m/s, towards the wall
gap = {{gap}}                                 # m, between sphere and wall at the start
window = {{time_step}}                        # s, the coupling window
grain_steps = {{grain_steps}}                 # YADE's own steps in a window
windows = round({{end_time}} / window)        # of the run
length, width = {{beam_length}}, {{beam_width}}  # m, of the wall
wall_points = {{wall_points}}                 # along the wall
impact_x = {{beam_length}} / 2 + {{impact_offset}}  # m
predicted = {{wall_prediction}}               # the wall moves on with its velocity within the window
iterated = {{scheme}} == 'serial-implicit'    # what is received stands for the window's end
hold_force = {{force_in_window}} == 'last'    # the beam gets the newest force, not the mean over the window
dimension = int({{dimension}})
far_wall = not {{far_wall}}                   # left out: only points that the sphere can reach are exchanged
far_contact = not {{far_contact}}             # left out: no contact detection while the sphere cannot arrive

# YADE's Hertz law takes 2/3 R as the effective radius of a sphere on a facet (it gives the facet the radius 2 R); a flat
# wall has R. Force goes with E* sqrt(R*), so moduli larger by sqrt(3/2) give Hertz's own stiffness.
stiffening = (3 / 2) ** 0.5
O.materials.append(FrictMat(young=stiffening * {{sphere_young}}, poisson={{sphere_poisson}},
                            density={{sphere_density}}, frictionAngle=0, label='sphere'))
O.materials.append(FrictMat(young=stiffening * {{beam_young}}, poisson={{beam_poisson}}, frictionAngle=0, label='wall'))

if abs(impact_x - length / 2) >= length / 2:
    raise ValueError('impact_offset %g m: the sphere would miss the beam of %g m' % (impact_x - length / 2, length))
O.dt = window / grain_steps
size = 2 * radius
tangent = O.bodies.append(facet([(size, 0, 0), (-size / 2, 0, size * 0.75**0.5), (-size / 2, 0, -size * 0.75**0.5)],
                                material='wall', fixed=True))
# YADE's step is: forces, then velocity and position. So the sphere starts one step ahead, at the position where the
# first window's force is looked for; nothing acts on it before.
ball = O.bodies.append(sphere((impact_x, radius + gap - impact_velocity * O.dt, 0), radius=radius, material='sphere'))
O.bodies[ball].state.vel = (0, -impact_velocity, 0)
mass = O.bodies[ball].state.mass  # kg, of the sphere in three dimensions, also in plane stress

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist=0, label='collider'),
    InteractionLoop([Ig2_Facet_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()],
                    [Law2_ScGeom_MindlinPhys_Mindlin()], label='contacts'),
    NewtonIntegrator(damping=0),
]

{{> yade/smooth_wall.py}}


def numbers_near(place, length, points, segments=2):
    """Numbers of the points on 0..length that are exchanged: all, or up to `segments` beyond those beside `place`."""
    if far_wall:
        return range(points)
    at = place / length * (points - 1)
    return range(max(0, int(at + 1e-9) - segments), min(points, -int(-(at - 1e-9) // 1) + segments + 1))


# The same points, in the same order, as in freefem/wall_near_sphere.idp.
along = numbers_near(impact_x, length, wall_points)
if dimension == 2:
    points = [(length * i / (wall_points - 1), 0, 0) for i in along]
    cells = [(i, i + 1) for i in range(len(along) - 1)]
else:
    wall_points_across = {{wall_points_across}}
    across = numbers_near(width / 2, width, wall_points_across)
    points = [(length * i / (wall_points - 1), 0, width * (j / (wall_points_across - 1) - 0.5))
              for i in along for j in across]
    cells = []
    for i in range(len(along) - 1):
        for j in range(len(across) - 1):
            corner = i * len(across) + j
            cells += [(corner, corner + len(across), corner + 1), (corner + len(across), corner + len(across) + 1, corner + 1)]
wall = SmoothWall(points, cells)

silent_until = 0                     # the window up to which the sphere cannot arrive
fastest_wall = 0.0                   # m/s, of any point so far
looked, silent = [0, 0.0], [0, 0.0]  # windows with and without contact detection, and their seconds
