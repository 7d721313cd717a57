"""The protocol client, against a stand-in for the orchestrator: real pipes, real slots, a process of its own."""

import os
import tempfile
import unittest

import h5py
import numpy

from stand_in import MappedSlot, Partner, make_slot, write

SCRIPT = """
from sandglass_participant import connect

participant = connect()
state = [0.0]
kept = []

def advance():
    numbers = participant.receive("numbers")
    window = participant.window
    if window.index == 13:
        fail(numbers)
    if window.index == 14:
        participant.send("double", [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])     # one row too few
    elif window.index == 15:
        participant.send("double", [1.0, 2.0])                               # wrong number of axes
    elif window.index == 16:
        participant.send("doubel", 1.0)
    elif window.index == 17:
        participant.send("double", numbers * float("nan"))
    elif window.index == 18:
        raise SystemExit("left")
    elif window.index != 19:
        state[0] += window.end - window.begin
        participant.send("double", 2 * numbers)
    participant.send("count", len(numbers) + 100 * window.iteration + state[0])
    numbers[:] = -1                                                          # the caller's own copy
    if window.index == 2:
        participant.note("two\\nlines")
        participant.saved("solve", 0.25)

def fail(numbers):
    numbers / participant.receive("nothing")

def checkpoint(path):
    with open(path, "w") as file:
        file.write(repr(state[0]))

def load(path):
    with open(path) as file:
        state[0] = float(file.read())

def restore():
    state[0] = kept[-1]

participant.serve(advance, save=lambda: kept.append(state[0]), restore=restore, checkpoint=checkpoint, load=load)
"""

FIELDS = {"numbers": (4, 2)}, {"double": (4, 2), "count": (1,)}


class ParticipantTest(unittest.TestCase):
    transport = "mapped"

    def setUp(self):
        # A space in the path, because run directories may have one.
        self.place = tempfile.TemporaryDirectory(prefix="with space ")
        self.addCleanup(self.place.cleanup)
        self.slot = make_slot(self.path("slot.h5"), *FIELDS, transport=self.transport)
        self.script = write(self.path("script.py"), SCRIPT)
        self.partner = Partner([self.script], self.place.name, self.slot, self.script)
        self.addCleanup(self.partner.close)
        self.assertEqual(self.partner.line(), "ready 1 memory disk")

    def path(self, name):
        return os.path.join(self.place.name, name)


class MappedTest(ParticipantTest):
    def setUp(self):
        super().setUp()
        self.fields = MappedSlot(self.slot)
        self.fields["in/numbers/values"][...] = numpy.arange(8.0).reshape(4, 2) / 3

    def advance(self, index=1, iteration=1):
        self.fields["window"][:] = index, iteration
        self.fields["time"][:] = 0.5 * (index - 1), 0.5 * index
        return self.partner.ask("advance")

    def test_fields_cross_bit_by_bit(self):
        numbers = self.fields["in/numbers/values"].copy()
        self.assertEqual(self.advance(iteration=3), "ok")
        self.assertEqual(self.fields["out/double/values"].tobytes(), (2 * numbers).tobytes())
        self.assertEqual(self.fields["out/count/values"][0], 4 + 300 + 0.5)
        self.assertEqual(self.fields["in/numbers/values"].tobytes(), numbers.tobytes(), "the input is not ours to change")
        self.assertGreater(self.fields["seconds"][0], 0)

    def test_slot_stays_a_valid_hdf5_file(self):
        self.advance()
        with h5py.File(self.slot, "r", locking=False) as file:
            self.assertEqual(file["out/double/values"][3, 1], 2 * file["in/numbers/values"][3, 1])

    def test_a_shorter_first_axis_is_received_and_sent_packed(self):
        self.fields["in/numbers/shape"][:] = 2, 2
        self.fields["out/double/values"][...] = -7
        self.assertEqual(self.advance(), "ok")
        self.assertEqual(self.fields["out/double/shape"].tolist(), [2, 2])
        expected = (2 * self.fields["in/numbers/values"].ravel()[:4]).tolist() + [-7] * 4
        self.assertEqual(self.fields["out/double/values"].ravel().tolist(), expected)
        self.assertEqual(self.fields["out/count/values"][0], 2 + 100 + 0.5)

    def test_an_empty_field_crosses(self):
        self.fields["in/numbers/shape"][:] = 0, 2
        self.assertEqual(self.advance(), "ok")
        self.assertEqual(self.fields["out/double/shape"].tolist(), [0, 2])

    def test_a_wrong_shape_and_nan_are_sent_as_they_are(self):
        self.assertEqual(self.advance(14), "ok")
        self.assertEqual(self.fields["out/double/shape"].tolist(), [3, 2])
        self.assertEqual(self.advance(17), "ok")
        self.assertTrue(numpy.isnan(self.fields["out/double/values"]).all())

    def test_exceptions_are_told_with_their_place_in_the_script(self):
        lines = SCRIPT.split("\n")

        def place(text):
            return "(%s:%d)" % (self.script, next(i for i, line in enumerate(lines, 1) if text in line))

        for index, texts in (
            (13, ["KeyError: field 'nothing' is not received", "it has: numbers", place('receive("nothing")')]),
            (15, ["ValueError: field 'double'", "[2]", "[4, 2]", place("[1.0, 2.0])  ")]),
            (16, ["KeyError: field 'doubel' is not sent", "it has: count, double", place("doubel")]),
            (18, ["SystemExit: left", place("SystemExit")]),
            (19, ["ValueError: field double not sent"]),
        ):
            with self.subTest(window=index):
                reply = self.advance(index)
                self.assertTrue(reply.startswith("error "), reply)
                for text in texts:
                    self.assertIn(text, reply)
        # One reply each and no more: the conversation is still in step.
        self.assertEqual(self.advance(20), "ok")

    def test_notes_come_before_the_reply(self):
        self.assertEqual(self.advance(2), "note two lines")
        self.assertEqual([self.partner.line() for _ in range(2)], ["saved solve 0.25", "ok"])

    def test_state_commands(self):
        checkpoint = self.path("state of one")
        self.advance(1)
        self.assertEqual(self.partner.ask("save"), "ok")
        self.assertEqual(self.partner.ask("checkpoint " + checkpoint), "ok")
        self.advance(3)
        self.assertEqual(self.fields["out/count/values"][0], 4 + 100 + 1.0)
        self.assertEqual(self.partner.ask("restore"), "ok")
        self.advance(3)
        self.assertEqual(self.fields["out/count/values"][0], 4 + 100 + 1.0)
        self.assertEqual(self.partner.ask("load " + checkpoint), "ok")
        self.advance(3)
        self.assertEqual(self.fields["out/count/values"][0], 4 + 100 + 1.0)

    def test_commands_it_does_not_know_are_errors(self):
        self.assertIn("unknown command 'dance'", self.partner.ask("dance"))
        self.assertIn("not able to 'script'", self.partner.ask("script somewhere.py"))
        self.assertIn("unknown command 'load'", self.partner.ask("load"))
        self.assertEqual(self.advance(), "ok")

    def test_several_commands_in_one_piece(self):
        self.fields["window"][:] = 1, 1
        os.write(self.partner.commands, b"advance\nsave\nsto")
        os.write(self.partner.commands, b"p\n")
        self.assertEqual([self.partner.line() for _ in range(4)], ["ok", "ok", "ok", None])
        self.assertEqual(self.partner.wait(), 0)

    def test_end_of_commands_ends_it(self):
        self.partner.end_of_commands()
        self.assertEqual(self.partner.wait(), 0)

    def test_nobody_listening_ends_it_quietly(self):
        os.close(self.partner.replies)
        self.fields["window"][:] = 1, 1
        os.write(self.partner.commands, b"advance\n")
        self.assertEqual(self.partner.wait(), 0)
        self.partner.replies = None
        with open(self.partner.log) as log:
            self.assertEqual(log.read(), "")


class FileTest(ParticipantTest):
    transport = "file"

    def test_fresh_files(self):
        numbers = numpy.arange(6.0).reshape(3, 2)
        with h5py.File(self.path("in 1.h5"), "w") as file:
            file["window"] = numpy.array([4, 2])
            file["time"] = numpy.array([1.5, 2.0])
            file["in/numbers/values"] = numbers
            file["in/numbers/shape"] = numpy.array([3, 2])
        reply = self.partner.ask("advance %s %s" % (self.path("in 1.h5"), self.path("out 1.h5")))
        self.assertEqual(reply, "ok")
        with h5py.File(self.path("out 1.h5"), "r") as file:
            self.assertEqual(file["out/double/values"][...].tolist(), (2 * numbers).tolist())
            self.assertEqual(file["out/double/shape"][...].tolist(), [3, 2])
            self.assertEqual(file["out/count/values"][0], 3 + 200 + 0.5)
            self.assertEqual(file["window"][...].tolist(), [4, 2])
            self.assertEqual(file["out/count/values"].attrs["unit"], "1")
            self.assertGreater(file["seconds"][0], 0)
        self.assertEqual([name for name in os.listdir(self.place.name) if name.endswith(".part")], [])

    def test_advance_without_files_is_an_error(self):
        self.assertIn("not mapped", self.partner.ask("advance"))

    def test_a_file_that_is_not_there_is_an_error(self):
        self.assertIn("FileNotFoundError", self.partner.ask("advance %s out.h5" % self.path("nowhere.h5")))


class ConnectTest(unittest.TestCase):
    def test_something_else_than_a_slot_is_refused(self):
        with tempfile.TemporaryDirectory() as place:
            slot = os.path.join(place, "slot.h5")
            with h5py.File(slot, "w") as file:
                file.attrs["filetype"] = "sandglass record"
                file.attrs["version"] = numpy.array([1, 0])
            script = write(os.path.join(place, "script.py"), SCRIPT)
            partner = Partner([script], place, slot, script)
            self.addCleanup(partner.close)
            self.assertIsNone(partner.line())
            self.assertNotEqual(partner.wait(), 0)
            with open(partner.log) as log:
                self.assertIn("filetype 'sandglass record'", log.read())


del ParticipantTest  # a base only

if __name__ == "__main__":
    unittest.main()
