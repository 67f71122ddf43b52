"""A small prototype misaligned, photographed, calibrated and compared with the truth, by the script that does so."""
import re
import subprocess
from pathlib import Path

from harness import SystemTest
import harness

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/calibration_loop.sh"


class CalibrationLoopTest(SystemTest):
    def loop(self, *arguments):
        return subprocess.run([SCRIPT, *arguments, "--program", harness.PROGRAM], capture_output=True, text=True,
                              timeout=800, stdin=subprocess.DEVNULL)

    def test_finds_the_panels_of_a_small_prototype(self):
        done = self.loop("3", "--small", "--views", "8")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        figures = re.findall(r"^gap_error_mm (\S+) ray_rms_px (\S+) ray_max_px (\S+)$", done.stdout, re.MULTILINE)
        self.assertEqual(len(figures), 1, done.stdout)
        self.assertTrue(done.stdout.splitlines()[-1].startswith("gap_error_mm "))
        gap_mm, rms_px, max_px = map(float, figures[0])
        self.assertLess(rms_px, 0.04)
        self.assertLess(max_px, 0.12)
        self.assertLess(gap_mm, 0.2)

    def test_frees_what_the_design_does_not_know(self):
        done = self.loop("--trials", "1", "--first", "4", "--small", "--views", "8", "--bow", "0.3")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout.splitlines()[0], r"^seed 4 met: .* freed scale, bow$")
        self.assertEqual(done.stdout.splitlines()[1:],
                         ["freed bow: 1", "freed scale: 1", "trials 1  met 1  refused 0  missed 0"])

    def test_too_few_positions_are_refused(self):
        done = self.loop("3", "--small", "--views", "1")
        self.assertEqual(done.returncode, 4, done.stdout + done.stderr)
        self.assertNotIn("ray_rms_px", done.stdout)

    def test_wrong_arguments_get_the_usage(self):
        for arguments in ((), ("7", "--trials", "2"), ("--what",)):
            done = self.loop(*arguments)
            self.assertEqual(done.returncode, 2)
            self.assertIn("calibration_loop.sh SEED", done.stderr)


if __name__ == "__main__":
    harness.main()
