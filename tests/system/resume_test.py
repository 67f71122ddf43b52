"""kill -9 at random moments, other thread counts, second runs: always the same bytes."""
import json
import os
import random
import signal
import subprocess
import time
import unittest
from pathlib import Path

import harness
from harness import SystemTest, run, write_grid

STAGES = ("capture", "poses", "depth", "layers", "frames", "preview")


def command(case, workspace, *more):
    return ("run", case.input, "--workspace", workspace, "--display", case.display, "--quality", "draft", *more)


def run_and_kill(arguments, workspace, stage, delay):
    """Starts the program, waits until the stage has begun and `delay` seconds more, kills it. True where it was still at work."""
    process = subprocess.Popen([harness.PROGRAM, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               stdin=subprocess.DEVNULL)
    begun = Path(workspace) / stage / "stage.json"
    while process.poll() is None and not begun.exists():
        time.sleep(0.002)
    time.sleep(delay)
    process.send_signal(signal.SIGKILL)
    return process.wait() == -signal.SIGKILL


def colmap_processes(workspace):
    """COLMAP's processes that work on this workspace: others' on the same machine are none of ours."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "comm").read_text().strip() == "colmap":
                if os.fsencode(workspace) in (entry / "cmdline").read_bytes():  # empty of a zombie
                    found.append(entry.name)
        except OSError:
            pass
    return found


class Same(SystemTest):
    def setUp(self):
        super().setUp()
        self.input = self.make_input()
        self.display = self.dir / "small.toml"
        self.display.write_text(harness.SMALL_DISPLAY)

    def make_input(self):
        return write_grid(self.dir / "grid", side=3, size=96)

    def complete(self, workspace, *more):
        result = run(*command(self, workspace, *more))
        self.assertEqual(result.code, 0, result.err)
        return harness.fingerprint(workspace)

    def assert_same(self, a, b):
        self.assertEqual(sorted(a), sorted(b))
        self.assertEqual([f for f in a if a[f] != b[f]], [])


class Grid(Same):
    def test_killed_runs_continue_to_the_same_bytes(self):
        undisturbed = self.complete(self.dir / "whole")
        choose = random.Random(20120507)
        workspace = self.dir / "killed"
        killed = [stage for stage in STAGES
                  if run_and_kill(command(self, workspace), workspace, stage, choose.uniform(0.0, 0.15))]
        self.assertGreaterEqual(len(killed), 3, f"only {killed} were still at work")
        self.assert_same(undisturbed, self.complete(workspace))

    def test_the_number_of_threads_changes_nothing(self):
        one = self.complete(self.dir / "one", "--threads", "1")
        two = self.complete(self.dir / "two", "--threads", "2")
        self.assert_same(one, two)

    def test_a_second_run_does_no_work_and_touches_no_file(self):
        workspace = self.dir / "w"
        self.complete(workspace)
        times = {p: (p.stat().st_mtime_ns, p.stat().st_ino) for p in workspace.rglob("*")}
        start = time.monotonic()
        self.complete(workspace)
        self.assertLess(time.monotonic() - start, 2.0)
        self.assertEqual(times, {p: (p.stat().st_mtime_ns, p.stat().st_ino) for p in workspace.rglob("*")})

    def test_another_option_runs_only_what_depends_on_it(self):
        workspace = self.dir / "w"
        self.complete(workspace)
        depth = (workspace / "depth" / "stage.json").stat().st_mtime_ns
        layers = (workspace / "layers" / "stage.json").stat().st_mtime_ns
        self.complete(workspace, "--border-mm", "2")
        self.assertEqual(depth, (workspace / "depth" / "stage.json").stat().st_mtime_ns)
        self.assertNotEqual(layers, (workspace / "layers" / "stage.json").stat().st_mtime_ns)

    def test_another_calibration_runs_only_what_depends_on_it(self):
        workspace, calibration = self.dir / "w", self.dir / "calibration.json"
        name = self.display.read_text().split('name = "')[1].split('"')[0]
        shots = self.dir / "shots.json"
        layers = self.display.read_text().count("[[layer]]")
        shots.write_text(json.dumps({"format_version": 1, "shots": [{"name": "dark", "layers": [{}] * layers}]}))
        made = run("synth", "photos", "--display", self.display, "--shots", shots, "--eyes=0,0,500",
                   "--raster=0,1,1,1,1", "--samples", "1", "--out", self.dir / "truth")
        self.assertEqual(made.code, 0, made.err)
        truth = json.loads((self.dir / "truth" / "calibration.json").read_text())
        self.assertEqual(truth["display"], name)
        truth["layers"][0]["emitter_offset_mm"] = [0.3, 0.1]
        calibration.write_text(json.dumps(truth))
        first = self.complete(workspace, "--calibration", calibration)
        self.assertEqual(json.loads((workspace / "layers" / "calibration.json").read_text())["layers"][0]
                         ["emitter_offset_mm"], [0.3, 0.1])
        self.assertEqual(json.loads((workspace / "frames" / "frames.json").read_text())["response"]["curve"],
                         "calibration")
        times = {stage: (workspace / stage / "stage.json").stat().st_mtime_ns for stage in STAGES}
        truth["layers"][0]["emitter_offset_mm"] = [0.1, 0.3]
        calibration.write_text(json.dumps(truth))
        self.assertRegex(run("status", workspace).out, r"depth +done[\s\S]*layers +out of date[\s\S]*frames +out of date")
        second = self.complete(workspace)
        after = {stage: (workspace / stage / "stage.json").stat().st_mtime_ns for stage in STAGES}
        self.assertEqual([s for s in STAGES if times[s] != after[s]], ["layers", "frames", "preview"])
        self.assertNotEqual(first, second)
        truth["display"] = "another"
        calibration.write_text(json.dumps(truth))
        self.assert_refused(run(*command(self, workspace)), 3, "another")

    def test_status_knows_what_is_done_and_what_is_not(self):
        workspace = self.dir / "w"
        self.complete(workspace, "--until", "depth")
        out = run("status", workspace).out
        self.assertRegex(out, r"depth +done")
        self.assertRegex(out, r"layers +not run")

    def test_ctrl_c_ends_within_a_second_with_130(self):
        process = subprocess.Popen([harness.PROGRAM, *map(str, command(self, self.dir / "w"))], stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        # On a busy machine the program may take long to start: it is at work once its workspace is there.
        while not (self.dir / "w").exists() and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), 130)
        self.assertLess(time.monotonic() - start, 1.0)
        process.stderr.close()
        self.complete(self.dir / "w")


class Photographs(Same):
    """With COLMAP: the small generated capture."""

    def make_input(self):
        result = run("synth", "scene", "room", "--out", self.dir / "room")
        self.assertEqual(result.code, 0, result.err)
        return self.dir / "room" / "images"

    def test_poses_are_the_same_bytes_in_every_run_also_after_kills_and_with_other_thread_counts(self):
        until = ("--until", "poses")
        undisturbed = self.complete(self.dir / "whole", "--threads", "1", *until)
        workspace = self.dir / "killed"
        choose = random.Random(7)
        killed = 0
        for _ in range(3):
            killed += run_and_kill(command(self, workspace, *until), workspace, "poses", choose.uniform(0.3, 4.0))
            time.sleep(0.3)
            self.assertEqual(colmap_processes(workspace), [], "COLMAP outlived its parent")
        self.assertGreaterEqual(killed, 1)
        self.assert_same(undisturbed, self.complete(workspace, *until))

    def test_colmap_ends_with_the_program_that_was_killed(self):
        workspace = self.dir / "caught"
        process = subprocess.Popen([harness.PROGRAM, *map(str, command(self, workspace, "--until", "poses"))],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        while process.poll() is None and not colmap_processes(workspace):
            time.sleep(0.002)
        self.assertIsNone(process.poll(), "COLMAP was never seen at work")
        process.kill()
        process.wait()
        time.sleep(0.3)
        self.assertEqual(colmap_processes(workspace), [], "COLMAP outlived its parent")


if __name__ == "__main__":
    harness.main()
