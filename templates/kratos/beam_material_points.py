# A simply supported elastic beam by Kratos' own material points, plane stress, implicit Newmark: the code of the paper, as
# an independent check of ours. Runs in the private environment of `sandglass setup kratos`.
#
# x runs along the beam from its left support, y up (0 at half height). Supports hold the grid's nodes at both ends of the
# beam in y and leave x free. Boundary particles lie within the body, where Kratos passes on the whole of a load.
import contextlib
import os
import sys

import numpy

length, height, width = {{beam_length}}, {{beam_height}}, {{beam_width}}      # m
young, poisson, density = {{beam_young}}, {{beam_poisson}}, {{beam_density}}  # Pa, 1, kg/m3
time_step, steps = {{time_step}}, {{beam_steps}}                              # s, the coupling window; steps in it
wall_points = {{wall_points}}
impact_place = length / 2 + {{impact_offset}}                                 # m
spread = {{spread_load}}
far_wall, idle_beam = not {{far_wall}}, not {{idle_beam}}                     # left out where False
grid_along, grid_through, grid_height = {{grid_along}}, {{grid_through}}, {{grid_height}}
points_along, points_through = {{points_along}}, {{points_through}}           # material points, four in a body cell
if int({{dimension}}) != 2:
    raise SystemExit('continuum kratos is two-dimensional here')

sys.stdout.flush()
os.dup2(2, 1)  # Kratos prints banners to descriptor 1
import KratosMultiphysics as Kratos  # noqa: E402
import KratosMultiphysics.LinearSolversApplication  # noqa: E402
import KratosMultiphysics.MPMApplication as Mpm  # noqa: E402
from KratosMultiphysics.MPMApplication.mpm_implicit_dynamic_solver import MPMImplicitDynamicSolver  # noqa: E402

from sandglass_participant import connect  # noqa: E402

Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
participant = connect()

longest = 0.26 if length > 15.4 * height else 0.52  # heights, as in freefem/beam_material_points.edp
slender = -int(-(length / (longest * height) - 1e-9) // 1)
if grid_along < slender:
    grid_along, points_along = slender, max(points_along, 4 * slender)
    participant.note('the beam is so slender that its grid has %d cells along it' % grid_along)

# Points of the wall that are exchanged: as in freefem/wall_near_sphere.idp.
segment = length / (wall_points - 1)
first, last = 0, wall_points - 1
if not far_wall:
    first = max(0, int(impact_place / segment + 1e-9) - 2)
    last = min(wall_points - 1, -int(-(impact_place / segment - 1e-9) // 1) + 2)
exchanged = last - first + 1
places = [segment * i for i in range(first, last + 1)] + [impact_place]  # the last one is for the record
gauss = numpy.polynomial.legendre.leggauss(4)
body_cells = points_through // 4
heights, shares = [height / 2], [1.0]
if spread:
    heights = [height * ((cell + (1 + x) / 2) / body_cells - 0.5) for cell in range(body_cells) for x in gauss[0]]
    shares = [w / 2 / body_cells for cell in range(body_cells) for w in gauss[1]]


def block(name, rows):
    return 'Begin %s\n%s\nEnd %s\n' % (name, '\n'.join(rows), name.split()[0])


def quadrilaterals(columns, rows):
    """Corners of a grid of cells, nodes numbered along x first from 1."""
    corner = [(j * (columns + 1) + i + 1) for j in range(rows) for i in range(columns)]
    return [(c, c + 1, c + columns + 2, c + columns + 1) for c in corner]


def write_mesh(name, nodes, element, cells, extra=''):
    with open(name + '.mdpa', 'w') as file:
        file.write('Begin Properties 0\nEnd Properties\nBegin Properties 1\nEnd Properties\n')
        file.write(block('Nodes', ['%d %.17g %.17g 0' % (n + 1, *xy) for n, xy in enumerate(nodes)]))
        file.write(block('Elements ' + element, ['%d 1 %d %d %d %d' % (e + 1, *c) for e, c in enumerate(cells)]))
        file.write(extra)


cell = length / grid_along
grid = [(cell * (i - 1), grid_height * (j / grid_through - 0.5)) for j in range(grid_through + 1) for i in range(grid_along + 3)]
supports = [n + 1 for n, (x, y) in enumerate(grid) if min(abs(x), abs(x - length)) < 1e-9 * length]
boundary = [(x, y) for x in places for y in heights]
loads = range(len(grid) + 1, len(grid) + len(boundary) + 1)
extra = block('Conditions MPMGridPointLoadCondition2D1N', ['%d 0 %d' % (i + 1, n) for i, n in enumerate(loads)])
extra += 'Begin SubModelPart Surface\n%s%sEnd SubModelPart\n' % (
    block('SubModelPartNodes', map(str, loads)), block('SubModelPartConditions', (str(i + 1) for i in range(len(boundary)))))
write_mesh('grid', grid + boundary, 'Element2D4N', quadrilaterals(grid_along + 2, grid_through), extra)
columns = points_along // 4
body = [(length * i / columns, height * (j / body_cells - 0.5)) for j in range(body_cells + 1) for i in range(columns + 1)]
body_elements = quadrilaterals(columns, body_cells)
write_mesh('body', body, 'MPMUpdatedLagrangian2D4N', body_elements,
           'Begin SubModelPart Beam\n%s%sEnd SubModelPart\n' % (
               block('SubModelPartNodes', (str(n + 1) for n in range(len(body)))),
               block('SubModelPartElements', (str(e + 1) for e in range(len(body_elements))))))

model = Kratos.Model()
solver = MPMImplicitDynamicSolver(model, Kratos.Parameters('''{
    "model_part_name": "MPM_Material", "domain_size": 2, "echo_level": 0,
    "analysis_type": "linear", "scheme_type": "newmark", "newmark_beta": 0.25,
    "model_import_settings": {"input_type": "mdpa", "input_filename": "body"},
    "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "grid"},
    "time_stepping": {"time_step": %.17g},
    "auxiliary_variables_list": ["NORMAL", "IS_STRUCTURE"],
    "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"}
}''' % (time_step / steps)))
solver.AddVariables()
solver.ImportModelPart()
solver.PrepareModelPart()
solver.AddDofs()
background = model['Background_Grid']
properties = model['Initial_MPM_Material'].GetProperties()[1]
properties.SetValue(Kratos.YOUNG_MODULUS, young)
properties.SetValue(Kratos.POISSON_RATIO, poisson)
properties.SetValue(Kratos.DENSITY, density)
properties.SetValue(Kratos.THICKNESS, width)
properties.SetValue(Mpm.MATERIAL_POINTS_PER_ELEMENT, 16)
properties.SetValue(Kratos.CONSTITUTIVE_LAW, Mpm.LinearElasticIsotropicPlaneStress2DLaw())
surface = model['Background_Grid.Surface']
Kratos.VariableUtils().SetFlag(Kratos.BOUNDARY, True, surface.Nodes)
for condition in surface.Conditions:
    condition.Set(Kratos.BOUNDARY, True)
    condition.SetValue(Mpm.MATERIAL_POINTS_PER_CONDITION, 1)
    condition.SetValue(Mpm.MPC_IS_NEUMANN, True)
    condition.SetValue(Mpm.POINT_LOAD, Kratos.Vector(3))
solver.Initialize()
for node in supports:
    background.GetNode(node).Fix(Kratos.DISPLACEMENT_Y)
material = model['MPM_Material']
info = material.ProcessInfo
particles = sorted(model['MPM_Material.Surface'].Conditions, key=lambda one: one.Id)
elements = list(material.Elements)
if len(particles) != len(boundary):
    raise SystemExit('Kratos made %d boundary particles of %d' % (len(particles), len(boundary)))
for particle, place in zip(particles, boundary):
    made = particle.CalculateOnIntegrationPoints(Mpm.MPC_COORD, info)[0]
    if max(abs(made[0] - place[0]), abs(made[1] - place[1])) > 1e-12:
        raise SystemExit('boundary particle %d is at (%g, %g), not at (%g, %g)' % (particle.Id, made[0], made[1], *place))
now = 0.0
moving = False


def vectors(variable):
    return numpy.array([list(one.CalculateOnIntegrationPoints(variable, info)[0]) for one in particles])


def means(values):
    """Of the particles of every wall point."""
    return numpy.einsum('s,psk->pk', shares, values.reshape(len(places), len(shares), 3))


def advance():
    global now, moving
    force = participant.receive('force')
    if len(force) not in (0, exchanged):
        raise ValueError("field 'force' has %d points, the beam exchanges %d" % (len(force), exchanged))
    moving = moving or bool(numpy.any(force))
    if idle_beam or moving:
        for i in range(exchanged if len(force) else 0):
            for s, share in enumerate(shares):
                particles[i * len(shares) + s].SetValuesOnIntegrationPoints(Mpm.POINT_LOAD, [Kratos.Vector(list(share * force[i]))], info)
        for _ in range(steps):
            now = solver.AdvanceInTime(now)
            solver.Predict()  # finds every particle's cell: without it there would be no body, and no word
            solver.InitializeSolutionStep()
            solver.SolveSolutionStep()
            solver.FinalizeSolutionStep()
    displacement, velocity = means(vectors(Mpm.MPC_DISPLACEMENT)), means(vectors(Mpm.MPC_VELOCITY))
    if len(force) and numpy.any(force) and not numpy.any(displacement):
        raise ValueError('Kratos lost the load: nothing moved under %g N' % abs(force).sum())
    participant.send('displacement', displacement[:-1])
    participant.send('velocity', velocity[:-1])
    participant.send('beam_deflection', -displacement[-1, 1])
    kinetic = elastic = 0.0
    if participant.wants('beam_energy') and moving:
        for one in elements:
            kinetic += one.CalculateOnIntegrationPoints(Mpm.MP_KINETIC_ENERGY, info)[0]
            elastic += one.CalculateOnIntegrationPoints(Mpm.MP_STRAIN_ENERGY, info)[0]
    participant.send('beam_energy', [kinetic, elastic])


participant.serve(advance)
