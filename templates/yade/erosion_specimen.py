# The specimen of the erosion test: coarse beads settle on the plate, a cloud of fine ones falls on them under a wall that
# comes down until the fine layer has the porosity wanted; then, without the wall, it may rest. What falls through the
# plate meanwhile is counted and taken away. Made: specimen.h5.
from sandglass_column import Column, loose_places

young, poisson, friction_angle = {{young}}, {{poisson}}, {{friction_angle}}  # Pa, 1, rad
density, density_scaling = {{density}}, {{density_scaling}}                  # kg/m3, 1
gravity, fluid_density = {{gravity}}, {{fluid_density}}                      # m/s2, kg/m3
damping = {{damping}}
section, periodic = {{section}}, {{sides}} == 'periodic'                     # m
coarse_diameter, fine_diameter = {{coarse_diameter}}, {{fine_diameter}}      # m
coarse_beads, fine_beads = {{coarse_beads}}, {{fine_beads}}
cloud_porosity, porosity, wall_speed = {{cloud_porosity}}, {{layer_porosity}}, {{wall_speed}}  # 1, 1, m/s
resting_time = {{resting_time}}                                              # s
time_step_factor, verlet_distance = {{time_step_factor}}, {{verlet_distance}}  # 1, m
plate, catch_depth, catch_steps = {{plate}}, {{catch_depth}}, 200            # file, m, steps
random = numpy.random.default_rng({{seed}})
forget_fallen = plane_sides = needed_functors = True

# Without any friction only damping brings coarse beads to rest.
final_damping, damping = damping, max(damping, 0.1)
{{> yade/erosion_box.py}}

# The collider takes a body longer than half a period for one of its copies: beads would fall through the plate.
if periodic and section <= 2 * (coarse_diameter + 2 * verlet_distance):
    raise SystemExit('sides: periodic: YADE needs a section of more than two coarse beads, here more than %.4g mm, and has %.4g mm; '
                     'take scale=full or a wider section, or dem=lammps'
                     % (2e3 * (coarse_diameter + 2 * verlet_distance), 1e3 * section))

fine_ids, fallen_at, fallen = [], [], [(0.0, 0)]  # fallen: time since the fines were let go, how many


def heights(numbers):
    return numpy.array([O.bodies[number].state.pos[2] for number in numbers])


def speed(numbers):
    return max(O.bodies[number].state.vel.norm() for number in numbers)


# Coarse beads, with a friction of their own until they rest.
O.materials[glass].frictionAngle = {{coarse_friction_angle}}
coarse_ids = [add_bead(place, coarse_diameter / 2)
              for place in loose_places(coarse_beads, coarse_diameter / 2, section, 0, 0.9, random)]
O.dt = time_step_factor * PWaveTimeStep()
while O.time < 0.5 or speed(coarse_ids) > 1e-3:
    O.run(200, True)
    if O.time > 20:
        raise SystemExit('the coarse beads do not come to rest within 20 s')
coarse_top = heights(coarse_ids).max() + coarse_diameter / 2
print('coarse beads at rest after %.2f s, up to %.2f mm' % (O.time, 1e3 * coarse_top), flush=True)
newton.damping = final_damping
O.materials[glass].frictionAngle = friction_angle
for contact in O.interactions:
    contact.phys.tangensOfFrictionAngle = math.tan(friction_angle)

# Fine beads, under the wall.
places = loose_places(fine_beads, fine_diameter / 2, section, coarse_top, cloud_porosity, random)
fine_ids = [add_bead(place, fine_diameter / 2) for place in places]
wall_height = places[:, 2].max() + fine_diameter / 2
lid = None if periodic else O.bodies.append(wall(wall_height, axis=2, material='glass', mask=WALL))  # none has sides
if lid is not None:
    O.bodies[lid].state.vel = (0, 0, -wall_speed)
O.dt = time_step_factor * PWaveTimeStep()
start = O.time


# The fine layer is counted from the middle of the highest coarse bead, with the parts of coarse beads that lie in it.
layer_base = coarse_top - coarse_diameter / 2
ids = coarse_ids + fine_ids
radii = numpy.repeat([coarse_diameter / 2, fine_diameter / 2], [coarse_beads, fine_beads])


def layer_porosity(top):
    return Column([layer_base, top], section**2, density).contents(heights(ids), radii)[0][0]


met_coarse = False  # a coarse bead, with a fine one on top, holds the wall back; the layer stays looser
while not met_coarse and layer_porosity(wall_height - wall_speed * (O.time - start)) > porosity:
    O.run(catch_steps, True)
    fallen.append((O.time - start, len(fallen_at)))
    print('%.4f s, %d fell through' % fallen[-1], flush=True)
    met_coarse = wall_height - wall_speed * (O.time - start) < coarse_top + fine_diameter
wall_height -= wall_speed * (O.time - start)
met_coarse = met_coarse and layer_porosity(wall_height) > porosity
reached, closed, lost_at_porosity = layer_porosity(wall_height), O.time, len(fallen_at)
preparation_time = closed - start
if lid is not None:
    O.bodies.erase(lid)

while O.time < closed + resting_time:
    O.run(catch_steps, True)
    fallen.append((O.time - start, len(fallen_at)))

kept = [O.bodies[number] for number in coarse_ids] + [bead for bead in fines() if not is_aside(bead)]
position, velocity, spin = (numpy.array([tuple(getattr(bead.state, name)) for bead in kept]) for name in ('pos', 'vel', 'angVel'))
if periodic:
    position[:, :2] %= section  # YADE lets a bead go on through its copies
{{> python/erosion_specimen_file.py}}
