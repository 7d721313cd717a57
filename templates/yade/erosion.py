# The coarse-grid erosion test (ICY, section 4): beads of a prepared specimen under weight, buoyancy and the drag of a flow
# whose pressure differences are received once per window. This is the set-up; erosion_window.py is one window.
from sandglass_column import Column, WATER_WEIGHT, loose_places

young, poisson, friction_angle = {{young}}, {{poisson}}, {{friction_angle}}  # Pa, 1, rad
density, density_scaling = {{density}}, {{density_scaling}}                  # kg/m3, 1
gravity, fluid_density = {{gravity}}, {{fluid_density}}                      # m/s2, kg/m3
damping = {{damping}}
section, periodic = {{section}}, {{sides}} == 'periodic'                     # m
fine_diameter, verlet_distance = {{fine_diameter}}, {{verlet_distance}}      # m
plate, catch_depth, catch_steps = {{plate}}, {{catch_depth}}, 200            # file, m, steps
forget_fallen, plane_sides, needed_functors = {{fallen_beads}}, {{side_facets}}, {{idle_functors}}  # what is left out

{{> yade/erosion_box.py}}

with h5py.File({{specimen}}, 'r', locking=False) as file:
    radii = file['radius'][...]
    looser = file.attrs['porosity_fine'] if file.attrs.get('met_coarse') else None
    numbers = [add_bead(*bead) for bead in zip(file['position'][...], radii, file['velocity'][...], file['spin'][...])]
fine_ids = [number for number, radius in zip(numbers, radii) if radius < fine_diameter]
fallen_at = []
pressure_difference, fine_gradient = numpy.zeros({{cells}}), 0.0  # Pa; m/m, in the layer above the cells

{{> python/erosion_flow.py}}


def beads():
    return [O.bodies[number] for number in numbers]  # fetched anew: loading a state replaces the bodies


def positions():
    place = numpy.array([tuple(bead.state.pos) for bead in beads()])
    if periodic:
        place[:, :2] %= section  # YADE lets a bead go on through its copies
    return place


# The forces stay what they are until the next call.
def apply_drag():
    global drag_total
    z = positions()[:, 2]
    force, drag_total = drag_of(z, pressure_difference, fine_gradient)
    for number, one in zip(numbers, force):
        O.forces.setPermF(number, (0, 0, -one * density_scaling))


# Fallen beads go on top of all others, in places of their own, at rest.
def put_back(window):
    aside = [bead for bead in fines() if is_aside(bead)]
    top = max(bead.state.pos[2] + bead.shape.radius for bead in beads() if not is_aside(bead))
    random = numpy.random.default_rng([{{seed}}, window, {{reinsertion_seed}}])
    for bead, place in zip(aside, loose_places(len(aside), fine_diameter / 2, section, top, {{cloud_porosity}}, random)):
        bead.state.pos = tuple(place)
        bead.state.blockedDOFs, bead.bounded = '', True


O.dt = {{exchange_window}} / math.ceil({{exchange_window}} / ({{time_step_factor}} * PWaveTimeStep()))
{{#drag_follows.place}}
{{^drag.none}}
O.engines = O.engines + [PyRunner(command='apply_drag()', iterPeriod=math.ceil({{drag_refresh}} / O.dt))]
{{/drag.none}}
{{/drag_follows.place}}
