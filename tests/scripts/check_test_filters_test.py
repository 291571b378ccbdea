"""A filter that names a test which is gone must be found."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_test_filters


class Filters(unittest.TestCase):
    def faults(self, filters, not_under_asan=""):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "scripts").mkdir()
            (root / "scripts" / "check_sanitizer.sh").write_text(filters)
            (root / "tests").mkdir()
            (root / "tests" / "CMakeLists.txt").write_text(f"set(not_under_asan {not_under_asan})\n")
            (root / "tests" / "a_test.cpp").write_text(
                "TEST(Map, Forgets) {}\nTEST_P(Scenes, AreFound) {}\nINSTANTIATE_TEST_SUITE_P(All, Scenes, x);\n")
            return list(check_test_filters.check_filters(root))

    def test_patterns_that_match_pass(self):
        self.assertEqual(self.faults("""GTEST_FILTER='-Map.F*:*Scenes*'\nGTEST_FILTER="$GTEST_FILTER:All/Scenes.*" ;;"""), [])

    def test_a_pattern_without_a_test_fails(self):
        self.assertEqual(len(self.faults("GTEST_FILTER='Map.*:-Scenes.AreFound:Map.Keeps*'")), 2)

    def test_a_file_that_asan_does_not_compile_has_only_filtered_tests(self):
        self.assertEqual(self.faults("GTEST_FILTER='-Map.*:*Scenes*' ;;\ntsan)", "a"), [])
        faults = self.faults("GTEST_FILTER='-Map.*' ;;\ntsan) GTEST_FILTER='*Scenes*'", "a b")
        self.assertEqual(len(faults), 2)
        self.assertIn("should run All/Scenes.AreFound/0", faults[0])
        self.assertIn("no test file is called b_test.cpp", faults[1])


if __name__ == "__main__":
    unittest.main()
