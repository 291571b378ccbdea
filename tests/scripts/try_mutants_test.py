"""A mutant that no longer fits the source must be reported, and one that fits must change it."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import try_mutants


class Fitting(unittest.TestCase):
    MUTANT = try_mutants.Mutant("less", "a.cpp", "x < y", "x > y", "Less.*")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def test_replaces_the_one_place(self):
        (self.root / "a.cpp").write_text("return x < y;", encoding="utf-8")
        self.assertEqual(try_mutants.mutated(self.root, self.MUTANT), "return x > y;")

    def test_refuses_a_source_that_moved_changed_or_fits_twice(self):
        for text in (None, "return y > x;", "return x < y || x < y;"):
            if text is not None:
                (self.root / "a.cpp").write_text(text, encoding="utf-8")
            with self.assertRaisesRegex(try_mutants.CannotTry, "^less: a.cpp "):
                try_mutants.mutated(self.root, self.MUTANT)

    def test_names_differ_and_every_mutant_changes_its_file(self):
        mutants = try_mutants.MUTANTS
        self.assertEqual(len({mutant.name for mutant in mutants}), len(mutants))
        for mutant in mutants:
            self.assertNotEqual(mutant.search, mutant.replacement)


if __name__ == "__main__":
    unittest.main()
