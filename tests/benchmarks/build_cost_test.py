# SPDX-License-Identifier: Apache-2.0
"""benchmarks/build_cost.py on a log made by hand."""
import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import build_cost  # noqa: E402

LOG = """# ninja log v5
9\t60\t0\tCMakeFiles/cmake.verify_globs\t2a76233e37dee968
65\t61065\t1795268447972821453\tsrc/slow.cpp.o\t697e57727d736f9
70\t30070\t1795268447972821453\tsrc/quick.cpp.o\t697e57727d736f8
30070\t90070\t1795268447972821453\tsrc/just.cu.o\t697e57727d736f7
90070\t95070\t1795268447972821453\tlib/libx.so\t697e57727d736f6
"""


class BuildCost(unittest.TestCase):
    def run_on(self, log, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            if log is not None:
                (Path(folder) / ".ninja_log").write_text(log)
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                code = build_cost.main([folder, *arguments])
        return code, out.getvalue()

    def test_slowest_units_first(self):
        in_order = LOG.splitlines(keepends=True)
        in_order[2], in_order[3] = in_order[3], in_order[2]  # as Ninja writes it: by end
        code, text = self.run_on("".join(in_order))
        self.assertEqual(code, 0)
        self.assertIn("3 translation units, 151 s together, 2 other steps; the last ended after 95 s\n", text)
        self.assertLess(text.index("slow.cpp.o"), text.index("quick.cpp.o"))
        self.assertIn("over 60 s: src/slow.cpp.o\n", text)
        self.assertEqual(self.run_on("".join(in_order), "--strict")[0], 1)
        self.assertEqual(self.run_on("".join(in_order), "--strict", "--limit", "62")[0], 0)

    def test_a_unit_built_again_counts_once(self):
        again = "20\t5020\t1795268447972821453\tsrc/quick.cpp.o\t697e57727d736f8\n"
        _, text = self.run_on(LOG + again)
        self.assertIn("3 translation units, 126 s together", text)
        self.assertIn("5.0 s  src/quick.cpp.o", text)

    def test_without_a_log(self):
        self.assertEqual(self.run_on(None)[0], 2)
        code, text = self.run_on("something else")
        self.assertEqual(code, 2)
        self.assertIn("not a .ninja_log", text)


if __name__ == "__main__":
    unittest.main()
