# The coarse-grid erosion test (ICY, section 4) by LAMMPS: as yade/erosion.py, with the same contact law, damping and step.
# This is the set-up; erosion_window.py is one window. Every rank executes both.
import h5py
import numpy

from sandglass_column import Column, WATER_WEIGHT, loose_places

young, poisson, friction_angle = {{young}}, {{poisson}}, {{friction_angle}}  # Pa, 1, rad
density, density_scaling = {{density}}, {{density_scaling}}                  # kg/m3, 1
gravity, fluid_density = {{gravity}}, {{fluid_density}}                      # m/s2, kg/m3
damping = {{damping}}
section, periodic = {{section}}, {{sides}} == 'periodic'                     # m
coarse_diameter, fine_diameter = {{coarse_diameter}}, {{fine_diameter}}      # m
hole, hole_pitch = {{hole}}, {{hole_pitch}}                                  # m
skin, catch_depth, catch_steps = {{skin}}, {{catch_depth}}, 200              # m, m, steps

{{> lammps/erosion_box.py}}

with h5py.File({{specimen}}, 'r', locking=False) as file:
    radii = file['radius'][...]
    looser = file.attrs['porosity_fine'] if file.attrs.get('met_coarse') else None
    start = [file[name][...] for name in ('position', 'velocity', 'spin')]
is_fine = radii < fine_diameter
if is_fine[: numpy.count_nonzero(~is_fine)].any():
    raise ValueError('the coarse beads are not the first ones of the specimen')
time_step = {{time_step_factor}} * fine_diameter / 2 * math.sqrt(density * density_scaling / young)  # YADE's PWaveTimeStep
window_steps = math.ceil({{exchange_window}} / time_step)


# The first window begins with the specimen; a run that is resumed, with a state that was written. One LAMMPS does one of
# the two: after clear and read_restart in one process the last bits differ.
def begin():
    make_box(start[0][:, 2].max() + 0.05)
    for kind, which in ((COARSE, ~is_fine), (FINE, is_fine)):
        place(kind, start[0][which], sizes[kind], *(array[which] for array in start[1:]))
    set_groups()
    set_laws()
    set_up()


def resume(path):
    commands('processors * 1 1', 'newton off', 'read_restart "%s"' % path)
    set_lists()
    set_up()


def set_up():
    set_pairs()
    set_motion(with_drag={{drag}} != 'none')
    commands('timestep %.17g' % ({{exchange_window}} / window_steps), 'thermo_modify lost error')


numbers = numpy.arange(1, len(radii) + 1)
{{#drag_follows.place}}
refresh_steps = max(catch_steps, math.ceil({{drag_refresh}} / ({{exchange_window}} / window_steps)))
{{/drag_follows.place}}

{{> python/erosion_flow.py}}


def apply_drag():
    force, total = drag_of(beads('x')[:, 2], pressure_difference, fine_gradient)
    put_drag(-force * density_scaling)
    return total


# Fallen beads go on top of all others, in places of their own, at rest.
def put_back(window):
    away = is_aside()
    top = (beads('x')[:, 2] + radii)[~away].max()
    random = numpy.random.default_rng([{{seed}}, window, {{reinsertion_seed}}])
    places = loose_places(numpy.count_nonzero(away), fine_diameter / 2, section, top, {{cloud_porosity}}, random)
    put('x', numbers[away], places)
    mask = local('mask')
    back = (mask & group_bit('aside')) != 0
    mask[back] = mask[back] & ~group_bit('aside') | group_bit('moving') | group_bit('fines')
    find_ranks()
