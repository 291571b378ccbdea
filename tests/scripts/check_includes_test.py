"""What a file uses of another library, and nothing that it includes brings, must be found."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_includes


class Includes(unittest.TestCase):
    def faults(self, source, header="#pragma once\n#include <Eigen/Core>\n"):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "src" / "core").mkdir(parents=True)
            (root / "src" / "core" / "a.hpp").write_text(header)
            (root / "src" / "core" / "a.cpp").write_text('#include "core/a.hpp"\n' + source)
            return check_includes.check_tree(root)

    def test_a_member_that_another_module_defines_needs_it(self):
        use = "Eigen::Vector3d f(Eigen::Vector3d a) { return a.cross(a); }\n"
        self.assertEqual(len(self.faults(use)), 1)
        self.assertIn("src/core/a.cpp: .cross( needs <Eigen/Geometry>", self.faults(use)[0])
        for brought in ("Geometry", "Dense", "Eigenvalues"):
            self.assertEqual(self.faults(f"#include <Eigen/{brought}>\n{use}"), [])
            self.assertEqual(self.faults(use, f"#include <Eigen/{brought}>\n"), [])

    def test_a_name_of_a_library_needs_one_of_its_headers(self):
        self.assertEqual(len(self.faults("auto t = fmt::format(x);\nvoid g() { tbb::parallel_for(0, 1, h); }\n")), 2)
        self.assertEqual(self.faults("#include <fmt/format.h>\nauto t = fmt::format(x);\n"), [])
        self.assertEqual(self.faults("#include <oneapi/tbb/parallel_for.h>\nvoid g() { tbb::parallel_for(0, 1, h); }\n"), [])

    def test_a_type_of_ours_needs_a_header_that_defines_or_declares_it(self):
        with tempfile.TemporaryDirectory() as folder:
            core = pathlib.Path(folder) / "src" / "core"
            core.mkdir(parents=True)
            (core / "scan.hpp").write_text("struct Scan {\n  enum class Kind { a };\n};\n")
            (core / "use.hpp").write_text('#include "core/scan.hpp"\n')
            use = core / "use.cpp"

            def faults(text):
                use.write_text(text)
                return check_includes.check_tree(pathlib.Path(folder))

            self.assertEqual(faults("int f(const Scan& scan);\n"), ["src/core/use.cpp: Scan needs scan.hpp, which nothing that it includes brings"])
            for right in ('#include "core/use.hpp"\nint f(const Scan& scan);\n', "struct Scan;\nint f(const Scan& scan);\n",
                          "int f() { return a.Scan + b->Scan; }\n", 'auto t = R"(a "Scan")"; // Scan\n'):
                self.assertEqual(faults(right), [])

    def test_comments_and_texts_use_nothing(self):
        self.assertEqual(self.faults('// a.cross(b)\n/* fmt::\n */\nauto t = "a.llt()";\n'), [])


if __name__ == "__main__":
    unittest.main()
