# One coupling window of settling_sphere.py: the drag that was received acts, unchanged, during all steps of the window.
# Nothing here differs from window to window, so this script is rendered and compiled once.

state = O.bodies[grain].state             # fetched anew: loading a state replaces the bodies
drag = sandglass.receive('drag')[0]       # N, upward on a sphere that moves downward
O.forces.setPermF(grain, (0, 0, buoyancy + drag - weight))

for step in range(grain_steps):
    velocity_before = state.vel[2]
    O.step()

sandglass.send('velocity', -state.vel[2])
if sandglass.wants('acceleration'):       # of the last step, numerical damping included
    sandglass.send('acceleration', (velocity_before - state.vel[2]) / O.dt)
if sandglass.wants('position'):           # depth below the start
    sandglass.send('position', -state.pos[2])
