"""Layers of bare panels by the commands that a user types: a grid of cameras shown on them, panels that stand askew
found from photographs, and a ready picture warped for one."""
import json
import struct

import harness
from harness import SystemTest, run, write_grid, write_png

DISPLAY = """format_version = 1
name = "fused"
viewing_distance_mm = 800
border_mm = 24
[panel]
width_px = 480
height_px = 270
pitch_mm = 1.245
[[layer]]
position_mm = -12
mirror_x = true
[layer.bare]
eye_box_mm = 70
[[layer]]
position_mm = 12
[layer.bare]
eye_box_mm = 70
"""


def size_of(png):
    return struct.unpack(">II", png.read_bytes()[16:24])


class BareTest(SystemTest):
    def test_a_capture_becomes_one_frame_a_panel_and_a_page(self):
        write_grid(self.dir / "grid")
        result = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--display", "depth-fused",
                     "--quality", "draft")
        self.assertEqual(result.code, 0, result.err)
        frames = sorted(path.name for path in (self.dir / "w/frames").glob("*.png"))
        self.assertEqual(frames, ["layer_0_slot_0_emitter.png", "layer_1_slot_0_emitter.png"])
        self.assertIn("bare panels for eyes in 80 x 80 mm", (self.dir / "w/preview/index.html").read_text())

    def test_analysis_says_what_bare_panels_can_show(self):
        result = run("analyze", "depth-fused", "--json")
        self.assertEqual(result.code, 0, result.err)
        layer = json.loads(result.out)["layers"][0]
        self.assertAlmostEqual(layer["sharp_range_mm"], 610 * 0.3113158871666749 / 80)
        self.assertEqual(layer["directions_per_axis"], 1)

    def test_panels_askew_are_found_and_a_picture_is_warped_for_one(self):
        (self.dir / "display.toml").write_text(DISPLAY)
        made = run("synth", "misalignment", self.dir / "display.toml", "--seed", 3, "--out", self.dir / "truth.json")
        self.assertEqual(made.code, 0, made.err)
        made = run("calibrate", "patterns", self.dir / "display.toml", "--out", self.dir / "patterns")
        self.assertEqual(made.code, 0, made.err)
        names = [shot["name"] for shot in json.loads((self.dir / "patterns/shots.json").read_text())["shots"]]
        self.assertFalse([name for name in names if "modulator" in name])
        taken = run("synth", "photos", "--misalignment", self.dir / "truth.json", "--shots",
                    self.dir / "patterns/shots.json", "--views", 10, "--tilt-deg", 20, "--width-px", 1000,
                    "--blur-px", 1, "--samples", 8, "--exposure", 1.6, "--full-well-e", 3500, "--read-noise-e", 2,
                    "--out", self.dir / "taken")
        self.assertEqual(taken.code, 0, taken.err)
        solved = run("calibrate", "solve", self.dir / "patterns", self.dir / "taken/images", "--out",
                     self.dir / "calibration.json")
        self.assertEqual(solved.code, 0, solved.err)
        compared = run("compare", "calibration", self.dir / "calibration.json", self.dir / "truth.json")
        self.assertEqual(compared.code, 0, compared.err)
        words = compared.out.splitlines()[-1].split()
        self.assertLess(float(words[words.index("ray_rms_px") + 1]), 0.02)

        write_grid(self.dir / "grid")
        shown = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--display", self.dir / "display.toml",
                    "--calibration", self.dir / "calibration.json", "--quality", "draft", "--until", "frames")
        self.assertEqual(shown.code, 0, shown.err)

        write_png(self.dir / "picture.png", 480, 270, lambda x, y: (x // 2, y // 2, 255 if x > y else 0))
        arguments = ("calibrate", "warp", self.dir / "picture.png", "--display", self.dir / "display.toml",
                     "--calibration", self.dir / "calibration.json", "--out", self.dir / "frame.png")
        warped = run(*arguments)
        self.assertEqual(warped.code, 0, warped.err)
        self.assertIn("% of the panel shows the picture", warped.out)
        self.assertEqual(size_of(self.dir / "frame.png"), (480, 270))
        self.assert_refused(run(*arguments, "--layer", 2), 2, "--layer", "2 of a display of 2 layers")


if __name__ == "__main__":
    harness.main()
