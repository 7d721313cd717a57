# The specimen of the erosion test by LAMMPS, as yade/erosion_specimen.py makes it by YADE. Made: specimen.h5.
import h5py
import numpy

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
hole, hole_pitch = {{hole}}, {{hole_pitch}}                                  # m
skin, catch_depth, catch_steps = {{skin}}, {{catch_depth}}, 200              # m, m, steps
random = numpy.random.default_rng({{seed}})

{{> lammps/erosion_box.py}}

# Coarse beads, with a friction of their own until they rest.
coarse_places = loose_places(coarse_beads, coarse_diameter / 2, section, 0, 0.9, random)
final_friction_angle, friction_angle = friction_angle, {{coarse_friction_angle}}
final_damping, damping = damping, max(damping, 0.1)  # without any friction only damping brings them to rest
make_box(coarse_places[:, 2].max() + 0.05)
place(COARSE, coarse_places, coarse_diameter / 2)
set_groups()
set_laws()
set_pairs()
set_motion()
commands('thermo_modify lost error')
p_wave_time = math.sqrt(density * density_scaling / young)  # over a length of 1 m
time = 0.0


def run(steps):
    global time
    find_near()
    lmp.command('run %d post no' % steps)
    time += steps * step


step = {{time_step_factor}} * coarse_diameter / 2 * p_wave_time
commands('timestep %.17g' % step)
while time < 0.5 or abs(beads('v')).max() > 1e-3:
    run(100)
    if time > 20:
        raise SystemExit('the coarse beads do not come to rest within 20 s')
coarse_top = beads('x')[:, 2].max() + coarse_diameter / 2
print('coarse beads at rest after %.2f s, up to %.2f mm' % (time, 1e3 * coarse_top), flush=True)
friction_angle, damping = final_friction_angle, final_damping
unset_motion()
set_laws()
set_pairs()
set_motion()

# Fine beads, below a wall that comes down.
fine_places = loose_places(fine_beads, fine_diameter / 2, section, coarse_top, cloud_porosity, random)
place(FINE, fine_places, fine_diameter / 2)
commands('group fines type 1', 'group moving type 1')
wall_height, layer_base = fine_places[:, 2].max() + fine_diameter / 2, coarse_top - coarse_diameter / 2
radii = numpy.repeat([coarse_diameter / 2, fine_diameter / 2], [coarse_beads, fine_beads])
step = {{time_step_factor}} * fine_diameter / 2 * p_wave_time
commands('timestep %.17g' % step)
commands('variable drop equal %.17g*(step-%d)*dt' % (-wall_speed, lmp.extract_global('ntimestep')),
         'region lid plane 0 0 %.17g 0 0 -1 move NULL NULL v_drop units box' % wall_height,
         'unfix damping', 'fix lid fines wall/gran/region %s region lid' % wall_law(stiffness(sizes[FINE], sizes[FINE])))
set_damping()
start, fallen = time, [(0.0, 0)]


def layer_porosity(top):
    return Column([layer_base, top], section**2, density).contents(beads('x')[:, 2], radii)[0][0]


def go_on():
    run(catch_steps)
    put_aside()
    fallen.append((time - start, numpy.count_nonzero(is_aside())))
    print('%.4f s, %d fell through' % fallen[-1], flush=True)


met_coarse = False  # a coarse bead, with a fine one on top, holds the wall back; the layer stays looser
while not met_coarse and layer_porosity(wall_height - wall_speed * (time - start)) > porosity:
    go_on()
    met_coarse = wall_height - wall_speed * (time - start) < coarse_top + fine_diameter
wall_height -= wall_speed * (time - start)
met_coarse = met_coarse and layer_porosity(wall_height) > porosity
reached, preparation_time, lost_at_porosity = layer_porosity(wall_height), time - start, fallen[-1][1]
lmp.command('unfix lid')
while time < start + preparation_time + resting_time:
    go_on()

kept = ~is_aside()
position, velocity, spin = (beads(name)[kept] for name in ('x', 'v', 'omega'))
{{> python/erosion_specimen_file.py}}
