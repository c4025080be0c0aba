# SPDX-License-Identifier: Apache-2.0
"""benchmarks/stage_table.py, ncu_csv.py, stage_kernels.py: ncu's output made by hand, stages from this source tree."""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
import ncu_csv  # noqa: E402
import record  # noqa: E402
import stage_kernels  # noqa: E402
import stage_table  # noqa: E402

HEAD = ["ID", "Process ID", "Process Name", "Host Name", "Kernel Name", "Context", "Stream", "Block Size", "Grid Size",
        "Device", "CC"]


def each(body):
    return (f"void meltsim::v0::core::kernels::each<meltsim::v0::{body}>(const unsigned int *, unsigned long, T1)")


def raw_page(launches, units=None):
    """--page raw: a column per metric, a row of units, numbers with thousands separators."""
    units = units or {}
    def line(cells):
        return ",".join('"' + str(c) + '"' for c in cells) + "\n"
    text = "==PROF== Connected to process 7 (meltsim_benchmarks)\n==PROF== Profiling \"each\": 0%....100% - 4 passes\n"
    text += line([*HEAD, *ncu_csv.METRICS])
    text += line([*[""] * len(HEAD), *(units.get(m, "") for m in ncu_csv.METRICS)])
    for i, (name, values) in enumerate(launches):
        text += line([i, 7, "meltsim_benchmarks", "127.0.0.1", name, 1, 7, "(128, 1, 1)", "(473, 1, 1)", 0, "9.0",
                      *(f"{values[m]:,}" if m in values else "n/a" for m in ncu_csv.METRICS)])
    return text + "==PROF== Disconnected from process 7\n"


def metrics(ns, dram, issue, registers=32):
    return {ncu_csv.TIME: ns, ncu_csv.DRAM_BYTES: dram, ncu_csv.DRAM: 10.0, ncu_csv.L2: 20.5, ncu_csv.ISSUE: issue,
            ncu_csv.REGISTERS: registers, ncu_csv.OCCUPANCY: 50.0}


class NcuCsv(unittest.TestCase):
    def test_raw_page(self):
        text = raw_page([("a(int)", {ncu_csv.TIME: 1234567, ncu_csv.DRAM_BYTES: 2.5}), ("b", {})],
                        {ncu_csv.TIME: "nsecond", ncu_csv.DRAM_BYTES: "Mbyte"})
        self.assertEqual(ncu_csv.launches(text), [("a(int)", {ncu_csv.TIME: 1234567, ncu_csv.DRAM_BYTES: 2.5e6}),
                                                  ("b", {})])

    def test_details_page(self):
        text = ",".join(f'"{c}"' for c in [*HEAD, "Section Name", "Metric Name", "Metric Unit", "Metric Value"]) + "\n"
        for metric, unit, value in ((ncu_csv.TIME, "usecond", "12.5"), (ncu_csv.REGISTERS, "register/thread", "64"),
                                    ("dram__bytes_read.sum", "Kbyte", "1.5"), ("dram__bytes_write.sum", "byte", "500")):
            text += (f'"0","7","p","h","f(int)","1","7","(1, 1, 1)","(1, 1, 1)","0","9.0","Command line profiler '
                     f'metrics","{metric}","{unit}","{value}"\n')
        (name, metrics), = ncu_csv.launches(text)
        self.assertEqual((name, metrics[ncu_csv.TIME], metrics[ncu_csv.REGISTERS]), ("f(int)", 12500, 64))
        self.assertEqual(metrics[ncu_csv.DRAM_BYTES], 2000)

    def test_refused(self):
        text = ("==PROF== Connected to process 7\n==ERROR== ERR_NVGPUCTRPERM - The user does not have permission to "
                "access NVIDIA GPU Performance Counters on the target device 0.\n")
        self.assertEqual(ncu_csv.launches(text), [])
        self.assertIn("ERR_NVGPUCTRPERM", ncu_csv.refusal(text))
        self.assertEqual(ncu_csv.refusal("==ERROR== Failed to find metric x\n"), "Failed to find metric x")


class StageKernels(unittest.TestCase):
    kernels = stage_kernels.Kernels(ROOT)

    def test_every_stage_can_be_found(self):
        found = set().union(*self.kernels.bodies.values(), self.kernels.verbs.get("sort", set()))
        for verb in ("sort", "scan", "bucket", "reduce"):
            self.assertTrue(self.kernels.verbs.get(verb), verb)
        self.assertEqual(found, set(self.kernels.order))

    def test_equal_names_in_two_modules(self):
        names = [each("spatial::NeighboursBody<float>"), each("topology::NeighbourMasksBody<float>"),
                 each("lsm::RegionMotionBody<double>"), each("topology::FillRegionsBody<double, 4>")]
        self.assertEqual(self.kernels.stages_of(names), ["spatial.neighbours", "topology.neighbours", "lsm.regions",
                                                         "topology.regions"])

    def test_kernels_of_several_stages_go_by_their_place(self):
        fill = each("core::kernels::FillBody<double>")
        names = [each("spatial::KeysBody<float>"), "void cub::DeviceRadixSortOnesweepKernel<cub::Policy800>(int)",
                 each("lsm::GoalsBody<float>"), each("lsm::PieceSumsBody<float>"), each("lsm::BalanceBody<float>"),
                 each("thermal::HeatOperandsBody<float>"),
                 "void meltsim::v0::core::kernels::gather_adding<3u, meltsim::v0::thermal::StageBody<float, false, "
                 "true>>(int)", "void meltsim::v0::core::kernels::gather_reduce<1u, meltsim::v0::core::CheckResult, "
                 "meltsim::v0::step::IntegrateBody<float>>(int)", "void meltsim::v0::core::kernels::combine_places<"
                 "meltsim::v0::core::CheckResult, meltsim::v0::core::JudgeBody<float>>(int)",
                 each("topology::PickBody<float>"), fill]
        self.assertEqual(self.kernels.stages_of(names), [
            "spatial.keys", "spatial.sort", "lsm.goals", "lsm.balance", "lsm.balance", "thermal.operands",
            "thermal.exchange", "step.integrate", "step.integrate", "topology.freeze", "topology.freeze"])

    def test_a_stage_none_of_whose_own_kernels_ran_did_not_run(self):
        operands = each("thermal::HeatOperandsBody<float>")
        self.assertEqual(self.kernels.stages_of([operands, each("thermal::StageBody<float>")])[0], "thermal.operands")
        plain = each("thermal::PlainOperandsBody<float>")
        self.assertEqual(self.kernels.stages_of([plain, each("thermal::PaperBody<float>")])[0], "thermal.paper")

    def test_a_bucket_is_several_kernels(self):
        scan = "void cub::DeviceScanKernel<cub::Policy900>(int)"
        counted = [each("core::kernels::CountBody<meltsim::v0::spatial::CellBody<float>>"), scan,
                   each("core::kernels::PlaceBody"),
                   each("spatial::SettleBody<float>")]
        self.assertEqual(self.kernels.stages_of(counted), [*["spatial.cells"] * 3, "spatial.settle"])
        scanned = [each("spatial::ReorderBody<float>"), each("core::kernels::CopyBody<int>"), scan,
                   each("spatial::GroupsBody<float>")]
        self.assertEqual(self.kernels.stages_of(scanned)[2:], ["spatial.groups", "spatial.groups"])

    def test_functions_that_stages_call_belong_to_them(self):
        text = "void a(E& ex, F& w) { ex.one(1); b<true, periodic()>(ex, w); }\nvoid b(E& ex, F& w) { { ex.two(X); } }\n"
        functions = stage_kernels.functions_of(text)
        self.assertEqual(set(functions), {"a", "b"})
        self.assertIn("ex.two", stage_kernels.with_called("a", functions))
        self.assertNotIn("ex.one", functions["b"])


class StageTable(unittest.TestCase):
    def benchmark(self, name, ms, **counters):
        return [{"name": name + "/iterations:1/manual_time", "run_type": "iteration", "real_time": ms * f,
                 "time_unit": "ms", **counters} for f in (0.9, 1.0, 1.2)]

    def folder(self, path):
        runs = self.benchmark("stage/sph.forces/cuda/60500", 0.163, **{"bytes/s": 1e12})
        runs += self.benchmark("stage/sph.forces/cuda/1000000/2d", 0.5, bytes=2e8)
        runs += self.benchmark("scene/melting/cuda/60500", 0.98, bytes_per_particle=424)
        runs += self.benchmark("scene/melting_double/cuda/1000000", 9.0)
        runs += self.benchmark("paper/table2_35k_5k/cuda/40000", 1.5, substeps=3)
        runs += self.benchmark("paper/fig7/cuda/200000", 6, substeps=4)
        runs += self.benchmark("stage/spatial.leaves/cpu/60500/pool_tree", 0.25)
        runs += self.benchmark("stage/spatial.walk/cpu/60500/pool_tree", 0.5)
        runs += self.benchmark("stage/sph.density/cpu/60500/pool_tree", 2)
        runs += self.benchmark("scene/water_pool_tree/cuda/60500", 0.7)
        for threads, ms in ((1, 160), (2, 80), (16, 16)):
            runs += self.benchmark(f"threads/water_2d/cpu/60500/{threads}", ms)
        (path / "benchmarks.json").write_text(json.dumps({"benchmarks": runs}))
        (path / "profile_melting_60500.csv").write_text(raw_page([
            (each("sph::ForcesBody<float>"), metrics(3000, 100e6, 70.0, 64)),
            (each("sph::ForcesBody<float>"), metrics(1000, 50e6, 30.0))],
            {ncu_csv.TIME: "ns", ncu_csv.DRAM_BYTES: "byte"}))
        (path / "profile_water_2d_1000000.csv").write_text("==ERROR== ERR_NVGPUCTRPERM\n")
        times, kernels = stage_table.measured(path / "benchmarks.json"), stage_kernels.Kernels(ROOT)
        counted, refused = stage_table.profiles_of(path, kernels)
        record.write(path / "2026-01-02.jsonl", {"commit": "0123456789", "device": "a GPU", "host": {"cores": 16}}, times,
                     {stage_table.scene_of(k): v for k, v in counted.items()},
                     {stage_table.scene_of(k): v for k, v in refused.items()}, [{"run": "dam_break", "wall_s": 1.5}])

    def test_whole_runs(self):
        run = {"run": "whole_run/dam_break/cuda/80000/default", "particles": 81000, "substeps": 2126,
               "bare_substep_ms": 0.0871, "job_s": 0.22, "ratio": 1.188, "start_up_s": 0.25, "stepping_s": 0.18,
               "reading_s": 0.03, "writing_s": 0.01, "pictures_s": 0.6}
        table = stage_table.run_table([run, {"run": "of another program"}])
        self.assertEqual(table.count("\n"), 2)
        self.assertIn("| dam_break, 81,000, default | cuda | 2,126 | 0.0871 | 0.22 | 1.19 |", table)
        self.assertEqual(stage_table.run_table([]), "")

    def test_the_whole(self):
        with tempfile.TemporaryDirectory() as name:
            path = Path(name)
            self.folder(path)
            docs = path / "page.md"
            docs.write_text("before\n" + stage_table.MARKERS[0] + "\nold\n" + stage_table.MARKERS[1] + "\nafter\n")
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                self.assertEqual(stage_table.main([str(path / "2026-01-02.jsonl"), "--docs", str(docs)]), 0)
            text, page = out.getvalue(), docs.read_text()
            _, _, counters, _, runs = record.read(path / "2026-01-02.jsonl")
            of_folder = io.StringIO()
            with contextlib.redirect_stdout(of_folder):
                self.assertEqual(stage_table.main([name]), 0)
        self.assertTrue(page.startswith("before\n") and page.endswith("\nafter\n") and "old" not in page)
        self.assertIn(text, page)
        self.assertIn("| melting, 60,500, 2.5 dx |  | 0.98 | 61.7 | 424 |", text)
        self.assertIn("| melting, 1,000,000, 2.5 dx, double |", text)
        self.assertIn("| stage | GPU 60,500, 2.5 dx | GPU 1,000,000, 2 dx |", text)
        self.assertIn("| sph.forces | 0.163 | 0.5 |", text)
        # Shares weighted by time: (3 * 70 + 30) / 4; bytes of the model: 1 TB/s in 0.163 ms.
        self.assertIn("| sph.forces | 0.163 | 0.004 | 2 | 163 | 150 | 10 | 20.5 | 60 | issue | 64 | 50 |", text)
        self.assertIn("water, 1,000,000, 2 dx: no counters: the driver lets no ordinary user read", text)
        self.assertIn("| 35k liquid + 5k solid | 22.5 | GPU | 1.5 | 3 | 0.5 | 15 |", text)
        self.assertIn("| 200,000 | 6 | 4 | 1.5 |", text)
        self.assertIn("| a pool at rest, 60,500 | tree | 0.75 | 2 |  |  |  | 0.7 |", text)
        self.assertNotIn("spatial.walk", text)
        self.assertIn("| water, 60,500, 2 dx | 160 | 80 (2.0x) | 16 (10.0x) |", text)
        self.assertIn("Of `2026-01-02`: a GPU, 16 CPU threads, commit 0123456.", text)
        self.assertEqual(counters["melting/60500"]["sph.forces"]["bound"], "issue")
        self.assertEqual(runs, [{"run": "dam_break", "wall_s": 1.5}])
        # A folder gives the tables of the record that is made from it, but for what only the record knows.
        self.assertEqual(of_folder.getvalue().splitlines()[1:], text.splitlines()[1:])

    def test_a_line_that_is_none_is_named(self):
        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / "r.jsonl"
            path.write_text('{"record":{}}\n{"what":1}\n')
            with self.assertRaisesRegex(ValueError, "r.jsonl:2"):
                record.read(path)

    def test_committed_records_are_read(self):
        records = sorted((ROOT / "benchmarks/records").glob("*.jsonl"))
        self.assertTrue(records)
        for path in records:
            about, times, *_ = record.read(path)
            self.assertTrue(about["commit"], path)
            timed = about["parts"].get("benchmarks", {}).get("result") == "passed"
            self.assertEqual(len(times) > 0, timed, path)  # a record without that part has no timings
            if "profile" in about["parts"]:  # of all scenes and stages; others may be of some
                self.assertGreater(len(times), 100, path)
        self.assertTrue(any(len(record.read(path)[1]) > 100 for path in records))

    def test_a_page_without_markers_is_refused(self):
        with tempfile.TemporaryDirectory() as name:
            (Path(name) / "page.md").write_text("nothing\n")
            with self.assertRaises(ValueError):
                stage_table.put(Path(name) / "page.md", "text\n")

    def test_the_page_of_this_tree_has_them(self):
        text = (ROOT / "docs/performance.md").read_text()
        self.assertLess(text.index(stage_table.MARKERS[0]), text.index(stage_table.MARKERS[1]))


if __name__ == "__main__":
    unittest.main()
