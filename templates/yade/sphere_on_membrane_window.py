# One coupling window of sphere_on_membrane.py: the membrane pushes, the sphere moves on, its depth is told.

reaction = sandglass.receive('reaction')[0]  # N, upward
O.forces.setPermF(ball, (0, 0, reaction))
O.step()
sandglass.send('depth', -O.bodies[ball].state.pos[2])  # m, below the unstretched membrane
