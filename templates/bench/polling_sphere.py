"""One window of a settling sphere in a YADE that was started for it (polling.py)."""

import os

position, velocity, drag, window = (float(word) for word in os.environ["BENCH_VALUES"].split())
weight = 1650 * 9.80665 * math.pi / 6 * 1e-4**3  # less buoyancy
O.materials.append(FrictMat(density=2650))
O.bodies.append(utils.sphere((0, 0, -position), 0.5e-4))
O.bodies[0].state.vel = (0, 0, -velocity)
O.engines = [ForceResetter(), NewtonIntegrator(damping=0)]
O.dt = window
O.forces.setPermF(0, (0, 0, -(weight + drag)))
O.run(1, True)
with open("result.part", "w") as file:
    file.write("%r %r\n" % (-O.bodies[0].state.pos[2], -O.bodies[0].state.vel[2]))
os.rename("result.part", "result.txt")
