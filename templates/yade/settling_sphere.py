# A sphere that settles in a still fluid: Newton's second law with weight, buoyancy and a drag that the fluid solver
# sends once per coupling window (ICY, section 3.2). This is the set-up; settling_sphere_window.py is one window.
#
# z points up in YADE; what is exchanged (velocity, acceleration, position) is positive downward.

diameter = {{diameter}}            # m
density = {{density}}              # kg/m3
fluid_density = {{fluid_density}}  # kg/m3
gravity = {{gravity}}              # m/s2
time_step = {{time_step}}          # s, the coupling window
grain_steps = {{grain_steps}}      # YADE's own steps in a window

O.materials.append(FrictMat(density=density, label='grain'))
grain = O.bodies.append(sphere((0, 0, 0), radius=diameter / 2, material='grain'))

mass = O.bodies[grain].state.mass            # kg
weight = mass * gravity                      # N
buoyancy = mass / density * fluid_density * gravity  # N, weight of the displaced fluid

O.engines = [
    ForceResetter(),
{{^contact_detection}}
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]
    ),
{{/contact_detection}}
    NewtonIntegrator(damping={{numerical_damping}}),
]
O.dt = time_step / grain_steps
