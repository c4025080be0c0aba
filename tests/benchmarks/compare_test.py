# SPDX-License-Identifier: Apache-2.0
"""benchmarks/compare.py on records made by hand."""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import compare  # noqa: E402
import record as compact  # noqa: E402


def record(folder, name, **times):
    """A file as Google Benchmark writes it, with the aggregates that must not count."""
    runs = []
    for benchmark, values in times.items():
        for k, value in enumerate(values):
            runs.append({"name": f"stage/{benchmark}/cpu/60500/iterations:1/manual_time", "run_type": "iteration",
                         "repetition_index": k, "real_time": value, "time_unit": "us"})
        runs.append({"name": f"stage/{benchmark}/cpu/60500/iterations:1/manual_time_mean", "run_type": "aggregate",
                     "real_time": 1e9, "time_unit": "us"})
    runs.append({"name": "stage/broken/cpu/60500", "run_type": "iteration", "error_occurred": True, "real_time": 0,
                 "time_unit": "us"})
    path = Path(folder) / name
    path.write_text(json.dumps({"benchmarks": runs}))
    return str(path)


class Compare(unittest.TestCase):
    def compare(self, before, after, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                code = compare.main([record(folder, "a.json", **before), record(folder, "b.json", **after), *arguments])
        return code, out.getvalue()

    def test_slower_beyond_the_spread(self):
        code, text = self.compare({"forces": [100, 101, 102]}, {"forces": [107, 108, 109]})
        self.assertEqual(code, 1)
        self.assertIn("1.069  slower", text)
        self.assertIn("beyond the spread: stage/forces/cpu/60500", text)
        self.assertNotIn("broken", text)

    def test_slower_within_the_spread_is_no_regression(self):
        code, text = self.compare({"forces": [100, 101, 130]}, {"forces": [107, 120, 121]})
        self.assertEqual(code, 0)
        self.assertIn("within spread", text)

    def test_less_than_the_threshold(self):
        self.assertEqual(self.compare({"f": [100, 100]}, {"f": [104.9, 104.9]})[0], 0)
        self.assertEqual(self.compare({"f": [100, 100]}, {"f": [105.1, 105.1]})[0], 1)
        self.assertEqual(self.compare({"f": [100, 100]}, {"f": [105.1, 105.1]}, "--threshold", "10")[0], 0)

    def test_faster_is_no_regression(self):
        code, text = self.compare({"f": [100, 101]}, {"f": [50, 51]})
        self.assertEqual(code, 0)
        self.assertIn("faster", text)

    def test_one_repetition_proves_nothing(self):
        code, text = self.compare({"f": [100]}, {"f": [200]})
        self.assertEqual(code, 0)
        self.assertIn("one repetition", text)

    def test_compact_records(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.jsonl"
            compact.write(path, {}, {"stage/f/cpu/60500": {"ms": 0.1, "low": 0.09, "high": 0.11, "runs": 3}}, {}, {})
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                code = compare.main([str(path), record(folder, "b.json", f=[120, 121, 122])])
        self.assertEqual(code, 1, out.getvalue())
        self.assertIn("1.210  slower", out.getvalue())

    def test_what_only_one_record_has(self):
        code, text = self.compare({"f": [1, 1], "old": [1]}, {"f": [1, 1], "new": [1]})
        self.assertEqual(code, 0)
        self.assertIn("only before: stage/old/cpu/60500", text)
        self.assertIn("only after: stage/new/cpu/60500", text)
        self.assertEqual(self.compare({"old": [1]}, {"new": [1]})[0], 2)


if __name__ == "__main__":
    unittest.main()
