# A sphere glued on a membrane: Newton's second law with weight and the reaction that the membrane solver sends. This is
# the set-up; sphere_on_membrane_window.py is one window, and one step of YADE.
#
# z points up, z = 0 is where the membrane is not stretched.

O.materials.append(FrictMat(density={{density}}, label='ball'))  # kg/m3
ball = O.bodies.append(sphere((0, 0, 0), radius={{diameter}} / 2, material='ball'))  # m

gravity = {{gravity}}  # m/s2
O.engines = [
    ForceResetter(),
    NewtonIntegrator(gravity=(0, 0, -gravity), damping=0),
]
O.dt = {{time_step}}  # s, the coupling window

# YADE keeps velocities half a step behind positions: this is a sphere at rest at the start.
O.bodies[ball].state.vel = (0, 0, gravity * O.dt / 2)
