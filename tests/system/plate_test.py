"""A beam splitter's glass that is thicker than designed, found by the commands that a user types."""
import json

from harness import SystemTest, run
import harness

LAYER = """[[layer]]
position_mm = {}
gap_mm = 6
index = 1.49
mirror_x = {}
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3
"""
DISPLAY = """format_version = 1
name = "prototype"
viewing_distance_mm = 800
[panel]
width_px = 480
height_px = 270
pitch_mm = 1.245
""" + LAYER.format(-20, "true") + LAYER.format(20, "false") + """[layer.plate]
thickness_mm = 5
index = 1.5
normal = [1, 0, 1]
"""


class PlateTest(SystemTest):
    def calibrated(self, name, thickness_mm):
        """The calibration and its report, of a prototype whose glass is so thick."""
        folder = self.dir / name
        folder.mkdir()
        (folder / "display.toml").write_text(DISPLAY)
        made = run("synth", "misalignment", folder / "display.toml", "--seed", 5, "--gap-mm", 3, 10,
                   "--out", folder / "truth.json")
        self.assertEqual(made.code, 0, made.err)
        truth = json.loads((folder / "truth.json").read_text())
        truth["layers"][1]["plate"]["thickness_mm"] = thickness_mm
        (folder / "truth.json").write_text(json.dumps(truth))
        made = run("calibrate", "patterns", folder / "display.toml", "--out", folder / "patterns")
        self.assertEqual(made.code, 0, made.err)
        shots = json.loads((folder / "patterns/shots.json").read_text())
        shots["shots"] = [shot for shot in shots["shots"] if "board" in shot["name"] or "dark" in shot["name"]]
        (folder / "patterns/shots.json").write_text(json.dumps(shots))
        taken = run("synth", "photos", "--misalignment", folder / "truth.json", "--shots",
                    folder / "patterns/shots.json", "--views", 12, "--tilt-deg", 20, "--width-px", 1344,
                    "--k1", -0.08, "--blur-px", 1, "--samples", 16, "--exposure", 1.6, "--full-well-e", 3500,
                    "--read-noise-e", 2, "--out", folder / "taken")
        self.assertEqual(taken.code, 0, taken.err)
        solved = run("calibrate", "solve", folder / "patterns", folder / "taken/images", "--out",
                     folder / "calibration.json")
        self.assertEqual(solved.code, 0, solved.err)
        compared = run("compare", "calibration", folder / "calibration.json", folder / "truth.json")
        self.assertEqual(compared.code, 0, compared.err)
        words = compared.out.splitlines()[-1].split()
        rms_px = float(words[words.index("ray_rms_px") + 1])
        report = (folder / "calibration.report.txt").read_text()
        return json.loads((folder / "calibration.json").read_text()), report, rms_px

    def test_a_plate_is_found_where_it_is_not_as_designed(self):
        found, report, rms_px = self.calibrated("thick", 5.4)
        self.assertIn("plate thickness: freed", report)
        self.assertAlmostEqual(found["layers"][1]["plate"]["thickness_mm"], 5.4, delta=0.05)
        self.assertLess(rms_px, 0.03)

    def test_a_plate_is_held_where_it_is_as_designed(self):
        found, report, rms_px = self.calibrated("as_designed", 5)
        self.assertNotIn("plate thickness: freed", report)
        self.assertEqual(found["layers"][1]["plate"]["thickness_mm"], 5)
        self.assertLess(rms_px, 0.03)


if __name__ == "__main__":
    harness.main()
