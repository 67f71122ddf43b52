"""Patterns of a small display, virtual photographs of them, and what `calibrate check` says of these."""
import json
import shutil

from harness import SystemTest, run
import harness

DISPLAY = """name = "small"
viewing_distance_mm = 400

[panel]
width_px = 160
height_px = 120
pitch_mm = 0.5

[[layer]]
position_mm = 0
d0_mm = 4
mirror_x = true
[layer.barrier]
period_px = 5
aperture_px = 1
slots = 5
"""


SHEET = """name = "sheet"
viewing_distance_mm = 300
[panel]
width_px = 96
height_px = 72
pitch_mm = 0.4
[[layer]]
position_mm = 0
d0_mm = 4
[layer.lenticular]
subpixels_per_lens = 14.1
slant = 0.1667
views = 9
"""

PLANES = """name = "planes"
viewing_distance_mm = 400
shear = false
[panel]
width_px = 117
height_px = 101
pitch_mm = 0.4
[varifocal]
planes = 2
depth_mm = 40
relay_focal_mm = 500
[[layer]]
d0_mm = 5
[layer.lenslets]
lattice = "hexagonal"
pitch_px = 9
rays = 4
"""


class CalibrateTest(SystemTest):
    def setUp(self):
        super().setUp()
        (self.dir / "small.toml").write_text(DISPLAY)
        self.patterns = self.dir / "patterns"
        made = run("calibrate", "patterns", self.dir / "small.toml", "--out", self.patterns)
        self.assertEqual(made.code, 0, made.err)

    def photograph(self):
        taken = run("synth", "photos", "--display", self.dir / "small.toml", "--shots", self.patterns / "shots.json",
                    "--eyes=25,10,390", "--raster=-44,34,0.25,352,272", "--samples", "32", "--aperture-mm", "3",
                    "--focus-mm", "310", "--exposure", "0.8", "--out", self.dir / "taken")
        self.assertEqual(taken.code, 0, taken.err)
        return self.dir / "taken" / "images"

    def test_good_photographs_pass_and_others_are_named(self):
        shots = json.loads((self.patterns / "shots.json").read_text())["shots"]
        self.assertEqual(len(shots), 6)
        photos = self.photograph()
        good = run("calibrate", "check", self.patterns, photos)
        self.assertEqual(good.code, 0, good.out + good.err)
        self.assertEqual(len(good.out.splitlines()), 7)
        self.assertIn("1 positions of 6 shots, all good", good.out)
        # A photograph that shows something else, and one that is missing.
        shutil.copy(photos / "eye_001_02_layer0_white.png", photos / "eye_001_04_layer0_modulator_board.png")
        (photos / "eye_001_06_layer0_modulator_board_again.png").unlink()
        bad = run("calibrate", "check", self.patterns, photos)
        self.assertEqual(bad.code, 3)
        self.assertIn("04_layer0_modulator_board: take again: no board is seen", bad.out)
        self.assertIn("position 1: take 04_layer0_modulator_board, 06_layer0_modulator_board_again", bad.out)

    def test_one_position_is_not_enough_for_a_calibration(self):
        out = self.dir / "calibration.json"
        solved = run("calibrate", "solve", self.patterns, self.photograph(), "--out", out)
        self.assertEqual(solved.code, 4, solved.out + solved.err)
        self.assertFalse(out.exists())
        self.assertIn("small: the calibration is NOT certain", (self.dir / "calibration.report.txt").read_text())
        self.assertIn("Not certain", (self.dir / "calibration.report.html").read_text())
        self.assertIn("is in 1 views only", solved.out)
        self.assertEqual(len(solved.error_lines()), 1, solved.err)
        self.assertIn("photograph", solved.error_lines()[0])
        page = self.dir / "page.html"
        reported = run("calibrate", "report", self.patterns, self.dir / "taken" / "images", "--out", page)
        self.assertEqual(reported.code, 4, reported.err)
        self.assertEqual(page.read_text(), (self.dir / "calibration.report.html").read_text())

    def solve_with_cameras(self, display, eyes, raster, exposure):
        """Of a display with lenses, photographed as designed: refused for want of positions, with its page."""
        (self.dir / "lenses.toml").write_text(display)
        made = run("calibrate", "patterns", self.dir / "lenses.toml", "--mode", "precise", "--no-board",
                   "--out", self.dir / "lenses")
        self.assertEqual(made.code, 0, made.err)
        taken = run("synth", "photos", "--display", self.dir / "lenses.toml", "--shots",
                    self.dir / "lenses" / "shots.json", f"--eyes={eyes}", f"--raster={raster}", "--samples", "2",
                    "--blur-px", "0.7", "--exposure", exposure, "--bits", "12", "--out", self.dir / "seen")
        self.assertEqual(taken.code, 0, taken.err)
        given = (self.dir / "lenses", self.dir / "seen" / "images", "--cameras", self.dir / "seen" / "transforms.json")
        solved = run("calibrate", "solve", *given, "--out", self.dir / "lenses.json")
        self.assertEqual(solved.code, 4, solved.out + solved.err)
        self.assertFalse((self.dir / "lenses.json").exists())
        reported = run("calibrate", "report", *given, "--out", self.dir / "page.html")
        self.assertEqual(reported.code, 4, reported.err)
        page = (self.dir / "lenses.report.html").read_text()
        self.assertEqual((self.dir / "page.html").read_text(), page)
        self.assertIn("Not certain enough for a calibration", page)
        return (self.dir / "lenses.report.txt").read_text(), page

    def test_a_sheet_has_a_page(self):
        text, page = self.solve_with_cameras(SHEET, "-70,20,310", "-21,16,0.2,210,160", "0.27")
        for words in (text, page):
            self.assertIn("there is one camera position only", words)
        self.assertIn("orange ring: where a further position", page)

    def test_planes_have_a_page(self):
        text, page = self.solve_with_cameras(PLANES, "60,15,400;-60,-20,390", "-27,23.2,0.4,135,116", "1.6")
        self.assertIn("2 planes are in 2 or 3 views only", text)
        for words in ("2 planes are in 2 or 3 views only", "Depth less the designed one"):
            self.assertIn(words, page)

    def test_mistakes_get_one_line(self):
        (self.dir / "empty").mkdir()
        out = self.dir / "calibration.json"
        for arguments, code, words in [
            (("patterns", "paper-two-layers", "--out", self.dir / "p"), 2, "paper-two-layer"),
            (("patterns", self.dir / "small.toml", "--out", self.dir / "p", "--mode", "exact"), 2, "exact"),
            (("patterns", self.dir / "small.toml", "--out", self.dir / "p", "--no-board"), 2, "no-board: is of"),
            (("check", self.dir, self.dir), 3, "patterns.json"),
            (("check", self.patterns, self.dir / "nowhere"), 3, "nowhere"),
            (("solve", self.dir, self.dir, "--out", out), 3, "patterns.json"),
            (("solve", self.patterns, self.dir / "empty", "--out", out), 3, "holds no image"),
            (("solve", self.patterns, self.patterns, "--display", "paper-two-layer", "--out", out), 2, "for which"),
            (("solve", self.patterns, self.patterns, "--out", self.dir), 2, "is a folder"),
            (("solve", self.patterns, self.patterns, "--out", self.dir / "no" / "c.json"), 5, "can't be written"),
        ]:
            self.assert_refused(run("calibrate", *arguments), code, words)


if __name__ == "__main__":
    harness.main()
