"""scripts/demo.sh, with a command that only writes down how it was called."""

import os
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "demo.sh"
COMMAND = """#!/bin/sh
echo "$*" >>calls
case $1 in
  detect) mkdir -p out/result/labels && touch out/result/labels/000007.label out/result/labels/000008.label ;;
  evaluate) echo progress >&2 && echo table ;;
esac
"""


class Demo(unittest.TestCase):
    def run_demo(self, args, recording="drive"):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            command = folder / "build" / "mapless"
            command.parent.mkdir()
            command.write_text(COMMAND)
            command.chmod(0o755)
            env = dict(os.environ, RECORDING=recording, ARGS=args, OUT="out")
            subprocess.run([str(SCRIPT)], cwd=folder, env=env, check=True, capture_output=True)
            calls = (folder / "calls").read_text().splitlines()
            evaluation = folder / "out" / "evaluation.txt"
            return {call.split()[0]: call for call in calls}, evaluation.read_text() if evaluation.exists() else ""

    def test_what_tells_how_to_read_the_recording_goes_to_every_verb(self):
        calls, _ = self.run_demo("--trajectory p.txt --labels truth --causal --sensor=VLP-16")
        self.assertEqual(calls["detect"], "detect drive -o out/result --overwrite --trajectory p.txt --labels truth"
                         " --causal --sensor=VLP-16")
        self.assertEqual(calls["render"], "render drive out/result --scan 8 -o out/scan_8.png"
                         " --labels truth --sensor=VLP-16")
        self.assertEqual(calls["evaluate"], "evaluate drive out/result --json out/evaluation.json"
                         " --labels truth --sensor=VLP-16")
        self.assertEqual(calls["view"], "view drive out/result -o out/drive.html --labels truth --sensor=VLP-16")

    def test_without_a_recording_it_is_the_quick_benchmark(self):
        calls, _ = self.run_demo("--profile paper", recording="")
        self.assertEqual(calls["benchmark"], "benchmark --quick -o out/benchmark --profile paper")
        self.assertEqual(calls["view"], "view out/town out/town_result -o out/drive.html")

    def test_the_evaluation_holds_the_table_alone(self):
        self.assertEqual(self.run_demo("")[1], "table\n")


if __name__ == "__main__":
    unittest.main()
