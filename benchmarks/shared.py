"""What the scripts of this folder and of peers/ share."""

import subprocess
import sys


def run(command):
    """What the command prints. Ends the script, with what it said, where it fails."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {result.stderr.strip()}")
    return result.stdout


def write_between_marks(file, script, text):
    """Puts the text into the document, in the place of what is between the two marks of that script."""
    begin, end = f"<!-- begin of {script} -->", f"<!-- end of {script} -->"
    before, rest = file.read_text(encoding="utf-8").split(begin)
    after = rest.split(end)[1]
    file.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
