# SPDX-License-Identifier: Apache-2.0
"""benchmarks/module_cost.py with programs made by hand: nothing is timed."""
import contextlib
import io
import json
import os
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import module_cost  # noqa: E402

PROGRAM = """#!{python}
import json, sys
with open({log!r}, "a") as log:
    log.write({name!r} + " " + " ".join(sys.argv[1:]) + "\\n")
print(json.dumps({answer!r}))
"""


def answer(ms, size=1000, energy=1.0, substeps=200):
    return {"particles": 8000, "substeps": substeps, "ms": ms, "processor_ms": ms / 2, "bytes": size, "kinetic_J": energy}


@unittest.skipIf(os.name == "nt", "scripts that are programs by their first line")
class ModuleCost(unittest.TestCase):
    def run_pair(self, before, after, *arguments):
        """The table's row, what was said beside it, and the order of the runs."""
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            for side, values in (("before", before), ("after", after)):
                path = Path(folder) / f"tides-{side}"
                path.write_text(PROGRAM.format(python=sys.executable, log=str(log), name=side, answer=values))
                path.chmod(0o755)
            out, errors = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
                code = module_cost.main(["run", folder, "--scenes", "ice", "--json", str(Path(folder) / "record"), *arguments])
            self.assertEqual(code, 0)
            self.assertEqual(len(json.loads((Path(folder) / "record").read_text())), 1)
            return out.getvalue().splitlines()[-1], errors.getvalue(), log.read_text().splitlines()

    def test_ratios_are_after_over_before(self):
        row, said, _ = self.run_pair(answer(2.0), answer(2.1, 1030))
        self.assertIn("| tides | `ice`, 8000 | 2 | 1.050 (1.050 to 1.050) | 1.050 (1.050 to 1.050) | 1.050 | 1.030 | yes |", row)
        self.assertEqual(said, "")

    def test_runs_alternate(self):
        _, _, log = self.run_pair(answer(2.0), answer(2.0), "--rounds", "3", "--backend", "cuda")
        self.assertEqual([line.split()[0] for line in log], ["before", "after", "after", "before", "before", "after"])
        self.assertTrue(all(line.endswith("--scene ice --particles 8000 --backend cuda") for line in log))

    def test_another_answer_and_other_substeps_are_said(self):
        row, said, _ = self.run_pair(answer(2.0), answer(2.0, energy=1.5, substeps=220))
        self.assertTrue(row.endswith("| no |"))
        self.assertIn("sub-steps differ: 200 and 220", said)

    def test_pairs_are_complete(self):
        with self.assertRaises(SystemExit):
            module_cost.pairs_of(["viscosity", "a"])


if __name__ == "__main__":
    unittest.main()
