"""A filter that names a test which is gone must be found."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_test_filters


class Filters(unittest.TestCase):
    def faults(self, filters):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "scripts").mkdir()
            (root / "scripts" / "check_sanitizer.sh").write_text(filters)
            (root / "tests").mkdir()
            (root / "tests" / "a_test.cpp").write_text(
                "TEST(Map, Forgets) {}\nTEST_P(Scenes, AreFound) {}\nINSTANTIATE_TEST_SUITE_P(All, Scenes, x);\n")
            return list(check_test_filters.check_filters(root))

    def test_patterns_that_match_pass(self):
        self.assertEqual(self.faults("""GTEST_FILTER='-Map.F*:*Scenes*'\nGTEST_FILTER="$GTEST_FILTER:All/Scenes.*" ;;"""), [])

    def test_a_pattern_without_a_test_fails(self):
        self.assertEqual(len(self.faults("GTEST_FILTER='Map.*:-Scenes.AreFound:Map.Keeps*'")), 2)


if __name__ == "__main__":
    unittest.main()
