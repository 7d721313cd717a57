"""Workflows at the extremes of what can be written: handled or refused, in little memory.

The bound on memory is the project's own promise: 200 MB. Time is promised too (a second), but only a hang is asserted.
"""

import os
import subprocess
import unittest

from case import BINARY, DONE, ENVIRONMENT, HOME, PARTICIPANT, PYTHON, REFUSED, UNSTABLE, Case

MOST_MEMORY = 200e6  # bytes

SCENE = """\
sandglass: 1
name: {name}
parameters:
  window: {{value: {window}, unit: s, above: 0, meaning: time between exchanges}}
  length: {{value: {value}, meaning: some number}}
  words: {{value: "{words}", type: text}}
stages:
  couple: {{run: coupling}}
participants:
  {left}: {{solver: command, command: [{python}, -c, "pass"]}}
  right: {{solver: command, command: [{python}, -c, "pass"]}}
coupling:
  window: $window
  end: {end}
  order: [{left}, right]
  fields:
    {field}: {{unit: {unit}, shape: [{shape}], from: {left}, to: right, initial: {initial}}}
"""
ORDINARY = dict(name="scene", window="1e-3", value="2", words="some words", left="left", python=PYTHON, end="5 ms",
                field="force", unit="N", shape="3", initial="0")


def scene(**changes):
    return SCENE.format(**{**ORDINARY, **changes})


def bomb(levels=60, width=9):
    """A billion laughs and more: every level names the one below `width` times."""
    lines = ["l0: &l0 [ha, ha]"]
    for level in range(1, levels):
        lines.append("l%d: &l%d [%s]" % (level, level, ", ".join(["*l%d" % (level - 1)] * width)))
    return "\n".join(lines) + "\n"


LONG_NAME = "n" * 10_000
EXTREMES = {
    **{"number " + value: scene(value=value)
       for value in ("1e308", "-1e308", "1e309", "-1e309", "-0", "-0.0", "5e-324", "-5e-324", "2.3e-308", "1e-400", ".inf",
                     ".nan", "9223372036854775807", "9223372036854775808", "1" * 5000, "0." + "0" * 5000 + "1",
                     "1e" + "9" * 300)},
    **{"initial " + value: scene(initial=value) for value in ("1e308", "-0", "5e-324", "1e309", ".nan")},
    "1e9 windows": scene(end="1e6 s"),
    "1e15 windows": scene(end="1e12 s"),
    "1e300 windows": scene(window="1e-300", end="1 s"),
    "the shortest window": scene(window="5e-324", end="1e-300 s"),
    "the longest window": scene(window="1e308", end="1.7e308 s"),
    "a field of 1e9 values": scene(shape="1000000000"),
    "a field of 1e18 values": scene(shape="1000000000, 1000000000"),
    "a field of 4e19 values": scene(shape="9223372036854775807, 4"),
    "a field of many axes": scene(shape=", ".join(["2"] * 200)),
    "a unit of 10 kB": scene(unit="m" * 10_000),
    "a power of a unit": scene(unit="m^999999999"),
    "a unit of many brackets": scene(unit="'" + "(" * 10_000 + "m" + ")" * 10_000 + "'"),
    "a name of 10 kB": scene(name=LONG_NAME),
    "a participant's name of 10 kB": scene(left=LONG_NAME),
    "a field's name of 10 kB": scene(field=LONG_NAME),
    "a word of 10 kB": scene(words=LONG_NAME),
    "words in UTF-8": scene(words="grüße ≤ 安全 🙂 e\u0301 \u202e\u200b"),
    "a name in UTF-8": scene(name="kugel_größe_安全"),
    "a field's name in UTF-8": scene(field="kraft_größe_🙂"),
    "a key in UTF-8": scene().replace("meaning: some number", "größe: 1"),
    "anchors": scene().replace("length: {value", "length: &here {value").replace('words: {value: "some words", type: text}',
                                                                                 "words: *here"),
    "a bomb of aliases": bomb() + scene(),
    "a bomb within": scene() + "description: " + "&a [" * 1000 + "]" * 1000 + "\n",
    "a bomb of merges": "a0: &a0 {k: v}\n" + "".join("a%d: &a%d {<<: [%s]}\n" % (
        n, n, ", ".join(["*a%d" % (n - 1)] * 9)) for n in range(1, 50)) + scene(),
    "deep lists": "a: " + "[" * 200_000,
    "deep maps": "a: " + "{b: " * 100_000,
    "deep indentation": "".join(" " * n + "a:\n" for n in range(1300)),
    "many keys": scene() + "".join("key%d: 1\n" % n for n in range(60_000)),
    "a megabyte of one word": scene(words="w" * 1_000_000),
    "a megabyte of blanks": scene() + " " * 1_000_000,
    "a megabyte of commas": scene() + "description: [" + "," * 1_000_000 + "]\n",
    "a megabyte of question marks": "? " * 500_000,
    "a megabyte of dashes": "- " * 500_000,
    "a megabyte of quotes": "'" * 1_000_000,
    "a megabyte of folded text": "description: >-\n" + "  x\n\n" * 200_000,
}


class Extremes(Case):
    def measured(self, verb, path, *arguments):
        """Exit status, messages and peak memory of one call."""
        process = subprocess.Popen([BINARY, verb, path, *arguments], cwd=self.place.path, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, errors="replace",
                                   env=dict(os.environ, SANDGLASS_HOME=HOME, SANDGLASS_TEST=self.place.mark))
        try:
            with process.stderr:
                messages = process.stderr.read()
            _, status, usage = os.wait4(process.pid, 0)
        finally:
            process.returncode = 0  # reaped above
        return os.waitstatus_to_exitcode(status), messages, usage.ru_maxrss * 1024

    def assert_handled(self, verb, path, *arguments, codes):
        code, messages, memory = self.measured(verb, path, *arguments)
        self.assertIn(code, codes, messages[-2000:])
        self.assertLess(memory, MOST_MEMORY, messages[-2000:])
        self.assertLess(len(messages), 200_000, "so much cannot be read")
        for bad in ("terminate", "bad_alloc", "std::", "yaml-cpp"):
            self.assertNotIn(bad, messages)
        if code == REFUSED:
            self.assertRegex(messages, r"extreme\.yaml|--set")

    def test_they_are_checked_planned_and_rendered(self):
        for name, text in EXTREMES.items():
            path = self.place.write("extreme.yaml", text)
            for verb, *arguments in (("check",), ("plan",), ("run", "--dry-run")):
                with self.subTest(name, verb=verb):
                    self.assert_handled(verb, path, *arguments, codes=(DONE, REFUSED))

    def test_those_that_are_accepted_are_run(self):
        """Their participants leave at once: what is left is to make slots, record and result, or to say why not."""
        for number, (name, text) in enumerate(EXTREMES.items()):
            path = self.place.write("extreme.yaml", text)
            out = self.place.join("run%d" % number)
            with self.subTest(name):
                self.assert_handled("run", path, "--out", out, codes=(REFUSED, PARTICIPANT, UNSTABLE, ENVIRONMENT))

    def test_settings(self):
        path = self.place.write("plain.yaml", scene())
        for value in ("1e308", "1e309", "-0", "5e-324", "nan", "inf", "9" * 10_000, "1 " + "m" * 10_000, "", " ", "$" * 10_000,
                      "größe", "\udcff\udcfe", "{{x}}", "1e9 fortnights"):
            with self.subTest(value[:20]):
                self.assert_handled("check", path, "--set", "length=" + value, codes=(DONE, REFUSED, 2))
        self.assert_handled("check", path, "--set", LONG_NAME + "=1", codes=(REFUSED, 2))


if __name__ == "__main__":
    unittest.main()
