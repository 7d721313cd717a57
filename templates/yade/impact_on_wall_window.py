# One coupling window of impact_on_wall.py: `grain_steps` steps against a wall that stands where it was at the window's
# begin, moves on from there with its velocity (wall_prediction), or moves to where it is at the window's end (iterated).
import time

began = time.perf_counter()
ball_state, wall_state = O.bodies[ball].state, O.bodies[tangent].state  # anew: loading a state replaces the bodies
displacement = sandglass.receive('displacement').tolist()  # m, of the wall's points
velocity = sandglass.receive('velocity').tolist()          # m/s
if not displacement:                                       # the beam has not spoken yet
    displacement = velocity = [[0.0, 0.0, 0.0]] * len(points)
if len(displacement) != len(points) or len(velocity) != len(points):
    raise ValueError("the beam sent %d points, the wall has %d" % (len(displacement), len(points)))
fastest_wall = max(fastest_wall, *(abs(component) for point in velocity for component in point))


def touching():
    """Force on the sphere (N) and energy (J) of the contact that YADE has found, if any."""
    for contact in O.interactions:
        if contact.isReal:
            force = contact.phys.normalForce
            return force, 0.4 * force.norm() * contact.geom.penetrationDepth  # Hertz: F = K d^1.5
    return Vector3.Zero, 0.0


index = sandglass.window.index
detecting = far_contact or index > silent_until
collider.dead = contacts.dead = not detecting
force, contact_energy = touching() if detecting else (Vector3.Zero, 0.0)
impulse = force / 2  # over the step: the trapezoidal rule, as YADE's integrator sees it
cell, weights, distance = wall.cells[0], (1.0, 0.0), None

for step in range(1, grain_steps + 1):
    center = ball_state.pos
    if detecting:
        share = step / grain_steps - 1 if iterated else step / grain_steps if predicted else 0
        if share:
            moved = [[d + share * window * v for d, v in zip(*one)] for one in zip(displacement, velocity)]
        else:
            moved = displacement
        cell, weights = wall.next_to(center)
        foot, normal = wall.tangent(cell, weights, moved)
        distance = dot(difference(center, foot), normal)
        if not distance > 0:
            raise ValueError("the centre of the sphere has passed through the wall at x = %.6g m, %.6g m below its rest"
                             % (foot[0], -center[1]))
        wall_state.pos = foot
        wall_state.ori = Quaternion(Vector3(0, 1, 0), Vector3(normal))
        wall_state.vel = [sum(w * velocity[i][k] for w, i in zip(weights, cell)) for k in range(3)]
    velocity_before = ball_state.vel
    O.step()
    if detecting:
        force, contact_energy = touching()
    impulse += force if step < grain_steps else force / 2

if detecting and distance > radius:
    # Nothing moves faster towards the other than twice the fastest so far; so long they cannot meet.
    closing = 2 * (ball_state.vel.norm() + fastest_wall)
    silent_until = index + int((distance - radius) / (closing * window)) - 1

on_wall = force if hold_force else impulse / grain_steps
loads = [[0.0, 0.0, 0.0] for point in points]
for i, weight in zip(cell, weights):
    loads[i] = [-weight * component for component in on_wall]
sandglass.send('force', loads)

mean_velocity = (velocity_before + ball_state.vel) / 2  # at the time of the force, half a step each away
sandglass.send('contact_force', force[1])
sandglass.send('sphere_position', radius - center[1])
sandglass.send('sphere_velocity', -mean_velocity[1])
sandglass.send('sphere_energy', [0.5 * mass * mean_velocity.squaredNorm(), contact_energy])
spent = looked if detecting else silent
spent[0] += 1
spent[1] += time.perf_counter() - began
if index == windows and silent[0] and looked[0]:
    sandglass.saved('far_contact', max(0.0, silent[0] * looked[1] / looked[0] - silent[1]))
