"""ICY's erosion test: the small scene with real YADE and FreeFEM, the head solver alone, and every option of the workflow.

What the analysis says is computed here a second time from the record: beads, heads from resistances in series by
numerical integration, and forces.
"""

import csv
import json
import math
import os
import signal
import unittest

import h5py
import meshio
import numpy

from case import DONE, HOME, PARTICIPANT, PYTHON, UNSTABLE, Case, Record, read, sets, together, wait_until

WORKFLOW = os.path.join(HOME, "workflows", "icy_erosion.yaml")
LAMMPS = os.path.exists(os.path.join(HOME, ".build", "solvers", "lammps", "installed"))
HANG = 600.0  # s, of beads that other work on the machine holds up
WATER = 9806.65  # N/m3
FINE_VOLUME = math.pi / 6 * 0.346e-3**3
FINE_LAYER = 19e-3 / 0.00134  # its resistance, s
OPTIONS = dict(scale=("small", "reduced", "full"), dem=("yade", "lammps"), drag=("coupled", "constant", "none"),
               drag_split=("volume", "surface"), drag_on=("all", "fines"), fine_layer_drag=("true", "false"),
               drag_follows=("bead", "place"), reinsertion=("true", "false"), sides=("walls", "periodic"), cells=("2", "5", "10"),
               flow_dimension=("1", "2", "3"), cell_borders=("cut", "centre"), conductivity_profile=("linear", "constant"), cell_top=("40.6 mm",),
               head=("1 m",), head_history=("constant", "ramp", "test_971121"), damping=("0.2",), friction_angle=("26 deg",),
               window=("0.1 s", "4 s"), end_time=("2 s",), seed=("7",), ranks=("2",), prepared_by=("yade", "lammps"), test=("950123", "run2_400kPa"))


def conductivity(porosity, surface):
    void = porosity / (1 - porosity)
    return 10**0.5 * void**3 / (2.5**2 * surface**2 * (1 + void))


def heads(k, top):
    """Head loss of cells with these conductivities at their centres, linear between, over the whole head."""
    cells = len(k)
    border = numpy.linspace(0, top, cells + 1)
    centre = (border[1:] + border[:-1]) / 2
    node, weight = numpy.polynomial.legendre.leggauss(40)
    loss = []
    for low, middle, high in zip(border, centre, border[1:]):
        # Half a cell at a time, where K is smooth: Gauss's rule of 40 points is exact to rounding.
        loss.append(sum(((b - a) / 2 * weight / numpy.interp((a + b) / 2 + (b - a) / 2 * node, centre, k)).sum()
                        for a, b in ((low, middle), (middle, high))))
    return numpy.array(loss) / (sum(loss) + FINE_LAYER)


class SmallScene(Case):
    """One run of the small scene, with fewer fine beads and two shorter windows; all tests look at it."""

    FINES = 2000  # fewer do not make a layer: the wall would come down to the coarse beads

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ended = cls.place.sandglass("run", WORKFLOW, *sets(
            scale="small", fine_beads=cls.FINES, layer_porosity=0.6, window="0.05 s", end_time="0.1 s"), out="small", seconds=1100)

    def test_ends_well_and_says_what_the_contract_asks(self):
        self.assert_code(self.ended, DONE)
        self.assertEqual([one["passed"] for one in self.ended.result["comparisons"]], [True] * 3)
        for name in ("eroded_mass", "beads_total", "beads_eroded", "beads_unaccounted", "darcy_residual_max",
                     "drag_balance_error_max", "porosity_fine_initial", "fines_lost_initial"):
            self.assertIsInstance(self.ended.quantity(name), (int, float), name)
        # The wall moves 55 um from one look to the next, of a layer of 2 mm or more.
        self.assertAlmostEqual(self.ended.quantity("porosity_fine_initial"), 0.6, delta=0.4 * 0.055 / 2)

    def test_every_bead_is_accounted_for(self):
        with h5py.File(self.ended.path("stages", "specimen", "specimen.h5")) as file:
            radius = file["radius"][...]
            lost = file.attrs["fines_lost"]
        record = self.ended.record
        fines = int((radius < 1e-3).sum())
        self.assertEqual(fines + lost, self.FINES)
        self.assertEqual(len(radius) - fines, 12)
        numpy.testing.assert_array_equal(record["fines_inside"][:, 0] + record["fines_aside"][:, 0], fines)
        self.assertEqual(self.ended.quantity("beads_total"), fines)
        self.assertEqual(self.ended.quantity("beads_unaccounted"), 0)
        self.assertEqual(self.ended.quantity("beads_eroded"), record["eroded"].sum())
        self.assertGreater(record["eroded"].sum(), 0, "nothing fell: the test says nothing")
        self.assertAlmostEqual(self.ended.quantity("eroded_mass") / (record["eroded"].sum() * FINE_VOLUME * 2500), 1, delta=1e-12)

    def test_darcy_and_the_sum_of_the_drag(self):
        record = self.ended.record
        with h5py.File(self.ended.path("stages", "start", "start.h5")) as file:
            porosity = [file["porosity"][...], *record["porosity"]]
            surface = [file["specific_surface"][...], *record["specific_surface"]]
        for window in range(record.windows):
            share = heads(conductivity(porosity[window], surface[window]), 10e-3)
            difference = record["pressure_difference"][window]
            numpy.testing.assert_allclose(difference, WATER * 0.23 * share, rtol=1e-11, atol=1e-12 * WATER * 0.23)
            self.assertAlmostEqual(record["drag_total"][window, 0] / (difference.sum() * 36e-6), 1, delta=1e-10)
        self.assertLess(self.ended.quantity("darcy_residual_max"), 1e-12)
        self.assertLess(self.ended.quantity("drag_balance_error_max"), 1e-10)

    def test_the_curve_is_a_file_that_the_result_names(self):
        with open(self.ended.path("stages", "analyse", "eroded_mass.csv")) as file:
            rows = list(csv.reader(file))[1:]
        self.assertEqual(len(rows), 3)
        self.assertAlmostEqual(float(rows[-1][1]), self.ended.quantity("eroded_mass"), delta=1e-15)
        self.assertIn("eroded_mass.csv", read(self.ended.path("result.json")))


BEADS = '''
import sys
import numpy
sys.path.insert(0, {python!r})
from sandglass_participant import connect
participant = connect()
porosity, surface = numpy.load({states!r})
def advance():
    window = min(participant.window.index, len(porosity) - 1)
    participant.send("porosity", porosity[window])
    participant.send("specific_surface", surface[window])
participant.serve(advance)
'''

START = '''
import h5py, numpy
porosity, surface = numpy.load({states!r})
with h5py.File("start.h5", "w") as file:
    file["porosity"], file["specific_surface"] = porosity[0], surface[0]
    file["head_time"], file["head"] = [0.0], [0.23]
'''

HEAD_SOLVER = """
sandglass: 1
name: head_solver
stages:
  start: {{run: command, command: [{program}, {start}], makes: [start.h5]}}
  couple: {{run: coupling}}
participants:
  water:
    solver: freefem
    template: freefem/darcy_column.edp
    given: [{{cells: {cells}}}, {{cell_top: 37 mm}}, {{fine_thickness: 19 mm}}, {{fine_conductivity: 0.00134 m/s}},
            {{density: 2500 kg/m3}}, {{section: 1 cm}}, {{flow_dimension: $dimension}}, {{drag: $drag}}, {{conductivity_profile: $profile}}, {{start: {{file: start/start.h5}}}}]
  beads: {{solver: command, command: [{program}, {beads}]}}
parameters:
  drag: {{value: coupled, choices: [coupled, constant, none]}}
  dimension: {{value: 1, choices: ["1", "2", "3"]}}
  profile: {{value: linear, choices: [linear, constant]}}
coupling:
  window: 1 s
  end: {windows} s
  order: [water, beads]
  stability: {{watch: false}}
  fields:
    porosity: {{unit: "1", shape: [{cells}], from: beads, to: water}}
    specific_surface: {{unit: m2/kg, shape: [{cells}], from: beads, to: water}}
    pressure_difference: {{unit: Pa, shape: [{cells}], from: water, to: beads}}
    fine_gradient: {{unit: "1", shape: [1], from: water}}
    conductivity: {{unit: m/s, shape: [{cells}], from: water}}
    flux: {{unit: m/s, shape: [1], from: water}}
    head: {{unit: m, shape: [1], from: water}}
left_out:
  unchanged_flow: {{of: water, what: solves, why: nothing moved}}
"""


class HeadSolver(Case):
    """FreeFEM's column, told what the cells contain."""

    def solve(self, name, porosity, surface, **parameters):
        states = self.place.join(name + ".npy")
        numpy.save(states, [porosity, surface])
        names = dict(python=os.path.join(HOME, "templates", "python"), states=states)
        text = HEAD_SOLVER.format(program=PYTHON, windows=len(porosity), cells=len(porosity[0]), start=self.place.write(name + "-start.py", START.format(**names)),
                                  beads=self.place.write(name + "-beads.py", BEADS.format(**names)))
        return self.run_workflow(text, *sets(**parameters), name=name)

    def test_jacobian_of_the_head_shares(self):
        # d(dh_i)/dn_j = -dh_i (delta_ij - w_j) s_j with s = (3 - n)/(n (1 - n)), for K constant in each cell.
        base = numpy.array([0.42, 0.35, 0.47, 0.39, 0.30])
        step = 1e-4
        porosity = numpy.vstack([base] + [base + sign * step * row for row in numpy.eye(5) for sign in (1, -1)])
        ended = self.solve("jacobian", porosity, numpy.full_like(porosity, 2.1), profile="constant")
        self.assert_code(ended, DONE)
        loss = ended.record["pressure_difference"] / WATER
        share = loss[0] / 0.23
        slope = (3 - base) / (base * (1 - base))
        theory = -loss[0][:, None] * (numpy.eye(5) - share) * slope
        measured = ((loss[1::2] - loss[2::2]) / (2 * step)).T
        # The central difference leaves step^2 / 6 times the third derivative, some (10)^2 here: 2e-7.
        numpy.testing.assert_allclose(measured, theory, rtol=1e-5, atol=1e-6 * abs(theory).max())
        self.assertGreater(abs(theory - numpy.diag(numpy.diag(theory))).max(), 1e-4, "cells feel each other")

    def test_clogged_and_wide_open_cells(self):
        porosity = numpy.full((4, 5), 0.4)
        surface = numpy.full((4, 5), 2.0)
        porosity[1, 3], surface[1, 3] = 0.0085, 6.0  # a millionth of its neighbours' conductivity
        porosity[2, 1] = 0.98
        ended = self.solve("extreme", porosity, surface)
        self.assert_code(ended, DONE)
        record = ended.record
        for window in range(4):
            k = conductivity(porosity[window], surface[window])
            exact = WATER * 0.23 * heads_of_halves(k)
            numpy.testing.assert_allclose(record["pressure_difference"][window], exact, rtol=1e-9, atol=1e-12 * WATER * 0.23)
        clogged = conductivity(0.0085, 6.0) / conductivity(0.4, 2.0)
        self.assertLess(clogged, 1e-6)

    def test_open_cells_above_the_beads(self):
        # Twenty cells in a column that is filled to a third: a cell with the tip of one bead, and nothing above it.
        porosity, surface = numpy.full((3, 20), 1.0), numpy.zeros((3, 20))
        porosity[:, :6], surface[:, :6] = 0.45, 2.0
        porosity[:, 6], surface[:, 6] = 0.37, 6.9
        porosity[:, 7], surface[:, 7] = (0.999, 1 - 1e-5, 1 - 1e-8), 6.9
        for dimension in "123":
            ended = self.solve("open_" + dimension, porosity, surface, dimension=dimension)
            self.assert_code(ended, DONE)
            for window in range(3):
                full = porosity[window] < 1
                k = numpy.full(20, 1340.0)
                k[full] = conductivity(porosity[window][full], surface[window][full])
                exact = WATER * 0.23 * heads_of_halves(k)
                numpy.testing.assert_allclose(ended.record["pressure_difference"][window], exact, rtol=1e-9, atol=1e-12 * WATER * 0.23)

    def test_columns_of_two_and_three_dimensions(self):
        random = numpy.random.default_rng(3)
        porosity, surface = random.uniform(0.3, 0.5, (3, 5)), random.uniform(1, 6, (3, 5))
        one, two, three = (self.solve("dimension_" + name, porosity, surface, dimension=name) for name in "123")
        for ended in (one, two, three):
            self.assert_code(ended, DONE)
        for field in ("pressure_difference", "fine_gradient", "flux", "conductivity"):
            for other in (two, three):
                # Linear elements are exact between planes; what differs is the rounding of the solve.
                numpy.testing.assert_allclose(other.record[field], one.record[field], rtol=1e-10)
        exact = WATER * 0.23 * heads_of_halves(conductivity(porosity[2], surface[2]))
        numpy.testing.assert_allclose(three.record["pressure_difference"][2], exact, rtol=1e-9)

    def test_what_is_no_porosity_ends_the_run(self):
        for value, code, words in ((-0.1, PARTICIPANT, "cell 3 from below has the porosity -0.1"),
                                   (math.nan, UNSTABLE, "field 'porosity' holds a value that is not a number at position 2")):
            porosity, surface = numpy.full((4, 5), 0.4), numpy.full((4, 5), 2.0)
            porosity[1, 2] = value
            ended = self.solve("wrong%d" % (value == value), porosity, surface)
            self.assert_code(ended, code)
            self.assert_said(ended, words, "window")

    def test_a_cell_without_beads_is_named_and_finite(self):
        porosity, surface = numpy.full((2, 5), 0.4), numpy.full((2, 5), 2.0)
        porosity[0, 2], surface[0, 2] = 1, 0
        ended = self.solve("empty", porosity, surface)
        self.assert_code(ended, DONE)
        self.assertIn("cell 3 from below has no beads", read(ended.path("result.json")))
        self.assertTrue(numpy.isfinite(ended.record["pressure_difference"]).all())

    def test_an_unchanged_flow_is_not_solved_again(self):
        porosity, surface = numpy.full((3, 5), 0.4), numpy.full((3, 5), 2.0)
        once = self.solve("once", porosity, surface)
        again = self.sandglass("run", self.place.join("once.yaml"), "--no-prune", out="again")
        self.assertGreater(once.result["left_out"][0]["saving_s"], 0)
        self.assertEqual(again.result["left_out"], [])
        numpy.testing.assert_array_equal(once.record["pressure_difference"], again.record["pressure_difference"])


def heads_of_halves(k):
    """As heads(), in closed form, which does not mind a million between neighbours."""
    border = numpy.concatenate((k[:1], (k[1:] + k[:-1]) / 2, k[-1:]))
    half = 37e-3 / len(k) / 2

    def part(a, b):
        return numpy.where(a == b, half / a, half * numpy.log(b / a) / numpy.where(a == b, 1, b - a))

    loss = part(border[:-1], k) + part(k, border[1:])
    return loss / (loss.sum() + FINE_LAYER)


def state_bytes(record):
    return {name: values.tobytes() for name, values in record.fields.items()}


class Checkpoints(Case):
    """The state that a checkpoint holds is complete: what is on its way, aside, or held by friction. One thread, one rank."""

    # Few beads in a layer so loose that the wall stops at once; they fall through from the fourth window on or so.
    QUICK = dict(scale="small", fine_beads=300, layer_porosity=0.95, window="0.04 s", end_time="0.24 s", record_positions="true")

    def assert_repeats(self, dem):
        unbroken = self.sandglass("run", WORKFLOW, *sets(dem=dem, **self.QUICK), out=dem, seconds=HANG)
        self.assert_code(unbroken, DONE)
        self.assertGreater(unbroken.record["eroded"][3:].sum(), 0, "nothing was put back: the test says little")
        self.assert_apart(unbroken)
        self.assert_for_paraview(unbroken)
        self.assert_code(self.sandglass("replay", self.place.join(dem), "--window", "2", seconds=HANG), DONE)

        started = self.place.start("run", WORKFLOW, *sets(dem=dem, **self.QUICK), out=dem + "-killed")
        checkpoint = started.path("checkpoints", "000000003")
        self.assertTrue(wait_until(lambda: os.path.isdir(checkpoint), HANG), "no third window")
        started.signal(signal.SIGKILL)
        started.wait(30)
        self.assert_nothing_left()
        self.assertLess(Record(started.path("record.h5")).windows, 6, "it was killed too late")
        resumed = self.sandglass("resume", started.directory, seconds=HANG)
        resumed.directory = started.directory
        self.assert_code(resumed, DONE)
        self.assertEqual(state_bytes(resumed.record), state_bytes(unbroken.record))
        for name in ("eroded_mass", "beads_eroded", "beads_unaccounted", "darcy_residual_max", "drag_balance_error_max"):
            self.assertEqual(resumed.quantity(name), unbroken.quantity(name), name)
        return unbroken

    def assert_apart(self, ended):
        """No bead is put back into another one, fine or coarse: overlaps stay those of contacts."""
        with h5py.File(ended.path("stages", "specimen", "specimen.h5")) as file:
            radius = file["radius"][...]
        for position in ended.record["position"][:, : len(radius)]:
            apart = numpy.linalg.norm(position[:, None] - position, axis=2) - radius[:, None] - radius
            numpy.fill_diagonal(apart, 0)
            self.assertGreater(apart.min(), -0.05 * radius.min())

    def assert_for_paraview(self, ended):
        self.assertIn('timestep="0.24" part="0" file="beads_000006.vtu"', read(ended.path("stages", "analyse", "beads.pvd")))
        beads = meshio.read(ended.path("stages", "analyse", "beads_000006.vtu"))
        numpy.testing.assert_array_equal(beads.points, ended.record["position"][5, : len(beads.points)])
        self.assertEqual(sorted(set(beads.point_data["radius"])), [0.173e-3, 1.5e-3])

    def test_of_yade(self):
        unbroken = self.assert_repeats("yade")
        # What is left out without any influence puts no other byte when it is put back.
        idle = self.sandglass("run", WORKFLOW, *sets(dem="yade", **self.QUICK), "--no-prune", "idle_functors", out="idle", seconds=HANG)
        self.assert_code(idle, DONE)
        self.assertEqual(state_bytes(idle.record), state_bytes(unbroken.record))

    @unittest.skipUnless(LAMMPS, "LAMMPS is not installed: ./sandglass setup lammps")
    def test_of_lammps(self):
        self.assert_repeats("lammps")


class Options(Case):
    def test_every_option_is_understood(self):
        for ended in together(*(lambda one=one: self.sandglass("check", WORKFLOW, *sets(**one))
                                for one in ({name: value} for name, values in OPTIONS.items() for value in values))):
            self.assert_code(ended, DONE)

    def test_periodic_sides_and_no_damping(self):
        few = dict(fine_beads=300, layer_porosity=0.95, window="2 ms", end_time="4 ms", record_positions="true")
        ended = self.sandglass("run", WORKFLOW, *sets(scale="small", sides="periodic", damping=0, drag="none", drag_follows="place", **few),
                               out="periodic", seconds=HANG)
        self.assert_code(ended, DONE)
        self.assertEqual(ended.quantity("beads_unaccounted"), 0)
        place = ended.record["position"]
        self.assertTrue(((place[:, :, :2] >= 0) & (place[:, :, :2] <= 6.2e-3)).all())

    def test_constant_drag_goes_with_the_beads_in_the_cells(self):
        ended = self.sandglass("run", WORKFLOW, *sets(drag="constant", **Checkpoints.QUICK), out="constant", seconds=HANG)
        self.assert_code(ended, DONE)
        self.assertLess(ended.quantity("drag_balance_error_max"), 1e-10)
        record = ended.record
        with h5py.File(ended.path("stages", "start", "start.h5")) as file:
            porosity = numpy.vstack((file["porosity"][...], record["porosity"][:-1]))
        solid = (1 - porosity).sum(axis=1)
        wanted = record["pressure_difference"][0].sum() * 36e-6 * solid / solid[0]
        self.assertGreater(abs(solid / solid[0] - 1).max(), 1e-3, "no bead came or went: the test says nothing")
        numpy.testing.assert_allclose(record["drag_total"][:, 0], wanted, rtol=1e-10)

    def test_a_periodic_section_too_narrow_for_yade_is_refused(self):
        ended = self.sandglass("run", WORKFLOW, *sets(scale="small", sides="periodic", section="6 mm"), out="narrow", seconds=HANG)
        self.assert_code(ended, PARTICIPANT)
        self.assertIn("YADE needs a section of more than two coarse beads", ended.err)

    @unittest.skipUnless(LAMMPS, "LAMMPS is not installed: ./sandglass setup lammps")
    def test_both_programs_move_one_specimen(self):
        few = dict(scale="small", fine_beads=300, layer_porosity=0.95, window="2 ms", end_time="2 ms", prepared_by="lammps")
        made = []
        for dem in ("lammps", "yade"):
            ended = self.sandglass("run", WORKFLOW, *sets(dem=dem, **few), out="from-one-" + dem, seconds=HANG)
            self.assert_code(ended, DONE)
            solvers = {solver["name"] for solver in json.loads(read(ended.path("provenance.json")))["solvers"]}
            self.assertLessEqual({"lammps", dem}, solvers)
            with open(ended.path("stages", "specimen", "specimen.h5"), "rb") as file:
                made.append(file.read())
        self.assertEqual(*made)

    @unittest.skipUnless(LAMMPS, "LAMMPS is not installed: ./sandglass setup lammps")
    def test_beads_that_are_put_back_find_their_rank(self):
        """Four ranks, one beside the other: a bead may have to go past the next one."""
        ended = self.sandglass("run", WORKFLOW, *sets(dem="lammps", ranks=4, **dict(Checkpoints.QUICK, end_time="0.2 s")), out="ranks", seconds=HANG)
        self.assert_code(ended, DONE)
        self.assertGreater(ended.record["eroded"].sum(), 5, "nothing was put back: the test says nothing")
        self.assertEqual(ended.quantity("beads_unaccounted"), 0)

    def test_a_wall_that_meets_a_coarse_bead_stops_there_and_says_so(self):
        """300 fine beads fill the hollows between the coarse ones and make no layer."""
        ended = self.sandglass("run", WORKFLOW, *sets(scale="small", fine_beads=300, end_time="0.04 s", window="0.04 s"), out="met", seconds=HANG)
        self.assert_code(ended, DONE)
        self.assertIn("the wall met a coarse bead", " ".join(note["text"] for note in ended.result["notes"]))
        self.assertGreater(ended.quantity("porosity_fine_initial"), 0.51)
        with h5py.File(ended.path("stages", "specimen", "specimen.h5")) as file:
            self.assertLess(file.attrs["wall_height"], file.attrs["coarse_top"] + 0.346e-3)
            self.assertGreater(file.attrs["wall_height"], file.attrs["coarse_top"] + 0.3e-3)


if __name__ == "__main__":
    unittest.main()
