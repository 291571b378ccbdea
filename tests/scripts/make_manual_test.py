import importlib.util
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("make_manual", ROOT / "scripts" / "make_manual.py")
make_manual = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(make_manual)

HELP = """Labels points.
Usage: mapless [OPTIONS] [SUBCOMMAND]

Subcommands:
  detect                      Label a recording

Exit codes:
  0        success
"""
HELP_OF_DETECT = """Label a recording
Usage: mapless detect [OPTIONS]

Options:
  -o,--output TEXT REQUIRED   .folder for the result
  --from-scan UINT
                              the first, see --output
"""


class MakeManual(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.command = self.folder / "mapless"
        cases = f"'detect --help') cat <<'E'\n{HELP_OF_DETECT}E\n;; --version) echo mapless 1.2;; *) cat <<'E'\n{HELP}E\n;;"
        self.command.write_text(f"#!/bin/sh\ncase \"$*\" in {cases} esac\n")
        self.command.chmod(0o755)

    def test_the_page_has_verbs_options_and_exit_codes_as_roff_prints_them(self):
        page = make_manual.manual(str(self.command))
        self.assertIn('"mapless 1.2"', page)
        self.assertIn(".SH MAPLESS DETECT\nLabel a recording\n", page)
        self.assertIn("\\fB\\-o,\\-\\-output TEXT REQUIRED\\fR\n\\&.folder for the result\n", page)
        self.assertIn("\\fB\\-\\-from\\-scan UINT\\fR\nthe first, see \\-\\-output\n", page)
        self.assertIn("0        success", page)

    def test_bash_completes_verbs_and_options(self):
        file = self.folder / "mapless.bash"
        file.write_text(make_manual.completions(str(self.command)))
        for words, expected in (("mapless de", "detect"), ("mapless detect --o", "--output")):
            script = f'. {file}; COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _mapless; echo "${{COMPREPLY[@]}}"'
            found = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True).stdout
            self.assertEqual(found.strip(), expected)


if __name__ == "__main__":
    unittest.main()
