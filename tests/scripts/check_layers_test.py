"""The checks must find what they are there to find."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_documents
import check_layers


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def faults(self):
        return list(check_layers.check_tree(self.root))


class Layers(Tree):
    def test_upwards_and_foreign_includes_pass(self):
        self.write("src/io/a.cpp", '#include <vector>\n#include <mapless/core/time.hpp>\n#include "lidar/b.hpp"\n')
        self.assertEqual(self.faults(), [])

    def test_downwards_include_fails(self):
        self.write("include/mapless/geometry/a.hpp", "#include <mapless/detection/detector.hpp>\n")
        self.assertEqual(len(self.faults()), 1)
        self.assertIn("a.hpp:1", self.faults()[0])

    def test_own_include_without_prefix_counts(self):
        self.write("src/core/a.cpp", '#include "lidar/b.hpp"\n')
        self.assertEqual(len(self.faults()), 1)

    def test_evaluation_and_simulation_never_include_detection(self):
        self.write("src/evaluation/a.cpp", "#include <mapless/detection/detection.hpp>\n")
        self.write("src/simulation/a.cpp", "#include <mapless/detection/detection.hpp>\n")
        self.assertEqual(len(self.faults()), 2)

    def test_unknown_room_fails(self):
        self.write("src/misc/a.cpp", "\n")
        self.assertEqual(len(self.faults()), 1)


class Cycles(Tree):
    def test_two_modules_that_include_each_other_fail_with_their_path(self):
        self.write("src/core/a.hpp", '#include "core/b.hpp"\n')
        self.write("src/core/b.hpp", "int b;\n")
        self.assertEqual(self.faults(), [])
        self.write("src/core/b.hpp", '#include "core/a.hpp"\n')
        self.assertEqual(self.faults(), ["modules include each other: src/core/a -> src/core/b -> src/core/a"])

    def test_header_and_source_in_different_folders_are_one_module(self):
        self.write("include/mapless/core/a.hpp", "int a;\n")
        self.write("src/core/deep/a.cpp", '#include <mapless/core/a.hpp>\n#include "core/b.hpp"\n')
        self.write("src/core/b.hpp", "int b;\n")
        self.assertEqual(self.faults(), [])
        self.write("src/core/b.hpp", "#include <mapless/core/a.hpp>\n")
        self.assertEqual(len(self.faults()), 1)

    def test_one_name_in_two_rooms_is_two_modules(self):
        self.write("src/core/a.hpp", "int a;\n")
        self.write("src/lidar/a.hpp", '#include "core/a.hpp"\n')
        self.assertEqual(self.faults(), [])

    def test_an_inc_belongs_to_the_module_that_includes_it(self):
        self.write("src/core/a.cpp", '#include "core/lanes.inc"\n')
        self.write("src/core/lanes.inc", '#include "core/a.hpp"\n')
        self.write("src/core/a.hpp", "int a;\n")
        self.assertEqual(self.faults(), [])
        self.write("src/core/b.hpp", '#include "core/a.hpp"\n')
        self.write("src/core/lanes.inc", '#include "core/b.hpp"\n')
        self.assertEqual(self.faults(), ["modules include each other: src/core/a -> src/core/b -> src/core/a"])

    def test_a_long_circle_is_found_among_tests_too(self):
        for one, other in ("ab", "bc", "ca"):
            self.write(f"tests/support/{one}.hpp", f'#include "support/{other}.hpp"\n')
        self.assertEqual(len(self.faults()), 1)
        self.assertIn("a -> tests/support/b -> tests/support/c -> tests/support/a", self.faults()[0])


class Folders(Tree):
    def test_15_modules_pass_and_16_fail(self):
        for i in range(15):
            self.write(f"src/io/m{i}.hpp", "\n")
            self.write(f"src/io/m{i}.cpp", "\n")
        self.write("src/io/tables/more.hpp", "\n")
        self.assertEqual(self.faults(), [])
        self.write("src/io/m15.hpp", "\n")
        self.assertEqual(self.faults(), ["src/io: 16 modules; at most 15 in a folder"])

    def test_30_public_headers_pass_and_31_fail(self):
        rooms = ("io", "core", "live")
        for i in range(30):
            self.write(f"include/mapless/{rooms[i // 15]}/m{i}.hpp", "\n")
        self.assertEqual(self.faults(), [])
        self.write("include/mapless/lidar/one_more.hpp", "\n")
        self.assertEqual(len(self.faults()), 1)

    def test_a_public_header_includes_no_private_one(self):
        self.write("include/mapless/core/a.hpp", '#include "core/b.hpp"\n')
        self.write("src/core/b.hpp", "\n")
        self.assertEqual(len(self.faults()), 1)


class Lengths(Tree):
    def function(self, head, lines):
        return head + " {\n" + "  work();\n" * (lines - head.count("\n") - 2) + "}\n"

    def test_function_of_60_lines_passes_and_of_61_fails(self):
        self.write("src/core/a.cpp", self.function("void f()", 60))
        self.assertEqual(self.faults(), [])
        self.write("src/core/a.cpp", self.function("void f()", 61))
        self.assertEqual(len(self.faults()), 1)

    def test_signature_over_two_lines_counts(self):
        self.write("src/core/a.cpp", "namespace n {\n\n" + self.function("void f(int a,\n       int b)", 61) + "\n}\n")
        self.assertEqual(len(self.faults()), 1)

    def test_blank_lines_inside_do_not_end_a_function(self):
        self.write("src/core/a.cpp", "void f() {\n" + "  work();\n\n" * 40 + "}\n")
        self.assertEqual(len(self.faults()), 1)

    def test_long_table_is_not_a_function(self):
        self.write("src/core/a.cpp", "constexpr std::array<int, 80> kTable = {{\n" + "    1,\n" * 80 + "}};\n")
        self.assertEqual(self.faults(), [])

    def test_long_type_is_not_a_function(self):
        self.write("src/core/a.hpp", "struct S {\n" + "  int a;\n" * 100 + "};\n")
        self.assertEqual(self.faults(), [])

    def test_file_of_401_lines_fails(self):
        self.write("tests/core/a_test.cpp", "int a;\n" * 401)
        self.assertEqual(len(self.faults()), 1)


class Documents(Tree):
    def test_missing_file_and_unknown_name_fail(self):
        self.write("src/core/a.cpp", "void present();\n")
        self.write("docs/paper_map.md", "`src/core/a.cpp` `src/core/b.cpp` `present` `absent` [x](nowhere.png)\n")
        missing = list(check_documents.check_paths(self.root, self.root / "docs/paper_map.md"))
        self.assertEqual(len(missing), 2)
        unknown = list(check_documents.check_paper_map(self.root))
        self.assertEqual(len(unknown), 1)
        self.assertIn("absent", unknown[0])

    def length_faults(self, text):
        self.write("docs/page.md", text)
        return list(check_documents.check_length(self.root, self.root / "docs/page.md"))

    def test_page_of_131_lines_fails(self):
        self.assertEqual(self.length_faults("a\n" * 130), [])
        self.assertEqual(len(self.length_faults("a\n" * 131)), 1)

    def test_wide_lines_of_a_page_count_as_often_as_they_wrap(self):
        self.assertEqual(self.length_faults("a" * 110 * 130), [])
        self.assertEqual(len(self.length_faults("a" * (110 * 130 + 1))), 1)

    def test_notebook_may_name_sources_that_have_gone(self):
        self.write("docs/notebook/old.md", "`src/core/gone.cpp` [x](nowhere.png)\n")
        faults = list(check_documents.check_paths(self.root, self.root / "docs/notebook/old.md"))
        self.assertEqual(len(faults), 1)
        self.assertIn("nowhere.png", faults[0])


if __name__ == "__main__":
    unittest.main()
