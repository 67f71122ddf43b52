"""A display's file with a mistake gets one line that names the file, the field and what to do, and exit code 2.

Every mistake is made in a file that is good without it.
"""
import harness
from harness import SystemTest, run

BARRIERS = harness.SMALL_DISPLAY.replace("viewing_distance_mm = 600\n", "viewing_distance_mm = 600\nshear = true\nborder_offset_mm = 0\n")
LENSES = """name = "lenses"
viewing_distance_mm = 500

[panel]
width_px = 100
height_px = 80
pitch_mm = 0.2

[[layer]]
position_mm = -2
d0_mm = 3
magnification = 1
[layer.lenslets]
lattice = "hexagonal"
pitch_px = 13.5
rays = 6
offset_px = [1, 2]
focal_mm = 3

[[layer]]
position_mm = 5
gap_mm = 4
index = 1.5
[layer.lenticular]
subpixels_per_lens = 4.5
slant = 0.2
views = 9
offset_subpx = 0.5
"""
VARIFOCAL = """name = "planes"
viewing_distance_mm = 500

[panel]
width_px = 100
height_px = 80
pitch_mm = 0.2

[varifocal]
planes = 3
depth_mm = 60
spacing = "uniform"
relay_focal_mm = 300
magnification0 = 1

[[layer]]
d0_mm = 3
[layer.lenslets]
lattice = "square"
pitch_px = 8
rays = 4
"""

# (file, what is replaced once, by what, words of the line)
MISTAKES = [
    # the issues that builders of displays meet first
    (BARRIERS, "d0_mm = 5", "d0_mm = -5", "layer 0", "d0_mm = -5", "give millimetres"),
    (BARRIERS, "d0_mm = 5", "d0_mm = 0", "layer 0", "d0_mm = 0", "give millimetres"),
    (BARRIERS, "d0_mm = 5", "d0_mm = 1e-6", "layer 0", "d0_mm = 1e-06", "degrees", "give a larger d0_mm"),
    (BARRIERS, "pitch_mm = 0.3", "pitch_mm = 0", "pitch_mm = 0", "give millimetres"),
    (BARRIERS, "pitch_mm = 0.3", "pitch_mm = -0.3", "pitch_mm = -0.3", "give millimetres"),
    (BARRIERS, "position_mm = 10", "position_mm = -10", "layers 0 and 1", "position_mm", "no two at one place"),
    (BARRIERS, "position_mm = 10", "position_mm = -11", "layers 0 and 1", "rising position_mm"),
    (BARRIERS, "slots = 3", "slots = 4", "layer 0", "slots = 4", "divide the period"),
    (BARRIERS, "slots = 3", "slots = 0", "layer 0", "slots = 0", "give slots from 1"),
    (BARRIERS, "period_px = 6\naperture_px = 2\nslots = 3", "period_px = 66\naperture_px = 2\nslots = 33", "layer 0", "slots = 33", "to 32"),
    (BARRIERS, "aperture_px = 2", "aperture_px = 1", "layer 0", "period_px = 6", "aperture_px = 1", "parity"),
    (BARRIERS, "aperture_px = 2", "aperture_px = 8", "layer 0", "aperture_px = 8", "at most the period"),
    (BARRIERS, "aperture_px = 2", "aperture_px = 0", "layer 0", "aperture_px = 0", "at least 1"),
    (BARRIERS, "period_px = 6", "period_px = 0", "layer 0", "period_px = 0", "give a period of 1"),
    (BARRIERS, "height_px = 96", "height_px = 1", "layer 0", "no opening", "aperture_px"),
    # sizes
    (BARRIERS, "width_px = 96", "width_px = 1000000000", "96000000000 pixels", "width_px"),
    (BARRIERS, "width_px = 96\nheight_px = 96", "width_px = 1000000000\nheight_px = 1", "1000000000 pixels", "width_px"),
    (BARRIERS, "width_px = 96", "width_px = 10000000000", ":9", "width_px = 10000000000 is too large"),
    (BARRIERS, "width_px = 96", "width_px = 0", "0 x 96 pixels", "width_px"),
    (BARRIERS, "height_px = 96", "height_px = -96", "96 x -96 pixels", "height_px"),
    (BARRIERS, "pitch_mm = 0.3", "pitch_mm = 0.3\nbinning_px = 5", "binning_px = 5", "divides width and height"),
    (BARRIERS, "pitch_mm = 0.3", "pitch_mm = 0.3\nbinning_px = 0", "binning_px = 0", "divides width and height"),
    # the viewer and the borders
    (BARRIERS, "viewing_distance_mm = 600", "viewing_distance_mm = -600", "viewing_distance_mm = -600", "give millimetres"),
    (BARRIERS, "viewing_distance_mm = 600", "viewing_distance_mm = 10", "layer 1", "viewing_distance_mm = 10", "in front of every layer"),
    (BARRIERS, "viewing_distance_mm = 600", "viewing_distance_mm = 14", "viewing_distance_mm = 14", "in front of every layer"),
    (BARRIERS, "border_mm = 4", "border_mm = 21", "border_mm = 21", "at most the spacing"),
    (BARRIERS, "border_mm = 4", "border_mm = -1", "border_mm = -1", "give 0 or more"),
    # what is not finite
    *[(BARRIERS, f"{key} = {value}", f"{key} = {wrong}", key, "give")
      for wrong in ("nan", "inf", "-inf")
      for key, value in (("pitch_mm", "0.3"), ("position_mm", "-10"), ("d0_mm", "5"), ("border_mm", "4"),
                         ("border_offset_mm", "0"), ("viewing_distance_mm", "600"))],
    *[(LENSES, f"{key} = {value}", f"{key} = {wrong}", key, "give")
      for wrong in ("nan", "inf")
      for key, value in (("pitch_px", "13.5"), ("focal_mm", "3"), ("magnification", "1"), ("index", "1.5"), ("gap_mm", "4"),
                         ("subpixels_per_lens", "4.5"), ("slant", "0.2"), ("offset_subpx", "0.5"))],
    *[(VARIFOCAL, f"{key} = {value}", f"{key} = nan", word, "give")
      for key, value, word in (("depth_mm", "60", "depth_mm"), ("relay_focal_mm", "300", "relay_focal_mm"),
                               ("magnification0", "1", "magnification"))],
    # names, types and TOML
    (BARRIERS, "border_mm", "boarder_mm", ":6", "boarder_mm", 'did you mean "border_mm"?'),
    (BARRIERS, "slots", "slot", ":19", "slot", 'did you mean "slots"?'),
    (BARRIERS, "[panel]", "[pannel]", "pannel", 'did you mean "panel"?'),
    (BARRIERS, "[layer.barrier]", "[layer.barier]", "barier", 'did you mean "barrier"?'),
    (BARRIERS, "pitch_mm = 0.3", "", "[panel]", 'no "pitch_mm"', "add pitch_mm"),
    (BARRIERS, "pitch_mm = 0.3", 'pitch_mm = "0.3"', ":11", "pitch_mm", "give a number"),
    (BARRIERS, "slots = 3", "slots = 3.5", ":19", "slots", "whole number"),
    (BARRIERS, "shear = true", "shear = 1", ":4", "shear", "true or false"),
    (BARRIERS, "pitch_mm = 0.3", "pitch_mm = 0.3\npitch_mm = 0.4", ":12", "pitch_mm", "mend the TOML"),
    (BARRIERS, "[panel]", "[panel", ":8", "mend the TOML"),
    (BARRIERS, "format_version = 1", "format_version = 2", "version"),
    (BARRIERS, BARRIERS, "", 'no "name"', "add name"),
    (BARRIERS, BARRIERS[BARRIERS.index("[[layer]]"):], "", "no layer", "[[layer]]"),
    # lenses
    (LENSES, "rays = 6", "rays = 14", "layer 0", "rays = 14", "at most the pitch"),
    (LENSES, "rays = 6", "rays = 0", "layer 0", "rays = 0", "at least 1"),
    (LENSES, "pitch_px = 13.5", "pitch_px = 95", "layer 0", "no lens of 95 emitters", "pitch_px"),
    (LENSES, "pitch_px = 13.5", "pitch_px = -1", "layer 0", "pitch_px = -1", "give a number from"),
    (LENSES, '"hexagonal"', '"hexagon"', ":14", "lattice", 'did you mean "hexagonal"?'),
    (LENSES, "[1, 2]", "[1]", "offset_px", "two numbers"),
    (LENSES, "focal_mm = 3", "focal_mm = -3", "layer 0", "focal_mm = -3", "give millimetres"),
    (LENSES, "magnification = 1", "magnification = 0", "layer 0", "magnification = 0", "give a number from"),
    (LENSES, "d0_mm = 3", "d0_mm = 3\ngap_mm = 3", "layer 0", "d0_mm beside gap_mm"),
    (LENSES, "gap_mm = 4", "gap_mm = -4", "layer 1", "gap_mm = -4", "give millimetres"),
    (LENSES, "gap_mm = 4", "gap_mm = 0", "layer 1", "gap_mm = 0", "give millimetres"),
    (LENSES, "index = 1.5", "index = 0.5", "layer 1", "index = 0.5", "refractive index"),
    (LENSES, "subpixels_per_lens = 4.5", "subpixels_per_lens = 0", "layer 1", "subpixels_per_lens = 0", "give a number from"),
    (LENSES, "subpixels_per_lens = 4.5", "subpixels_per_lens = 400", "layer 1", "no lens of 400 sub-pixels", "subpixels_per_lens"),
    (LENSES, "views = 9", "views = 0", "layer 1", "views = 0", "give a number from"),
    (LENSES, "slant = 0.2", "slant = 2000", "layer 1", "slant = 2000", "give a number from"),
    (LENSES, "pitch_mm = 0.2", "pitch_mm = 0.2\nbinning_px = 2", "layer 1", "binning_px = 2", "binning_px = 1"),
    (LENSES, "[layer.lenslets]", "[layer.barrier]\nperiod_px = 6\naperture_px = 2\nslots = 3\n[layer.lenslets]", "layer 0", "beside", "keep"),
    (LENSES, LENSES[LENSES.index("[layer.lenticular]"):], "", "layer 1", "[layer.lenticular]", "add one"),
    # planes
    (VARIFOCAL, "planes = 3", "planes = 0", "[varifocal]", "planes = 0", "give 1 to"),
    (VARIFOCAL, "planes = 3", "planes = 100000", "[varifocal]", "planes = 100000", "give 1 to"),
    (VARIFOCAL, "depth_mm = 60", "depth_mm = -60", "[varifocal]", "depth_mm = -60", "give millimetres"),
    (VARIFOCAL, "relay_focal_mm = 300", "relay_focal_mm = 20", "[varifocal]", "relay_focal_mm", "give a number from"),
    (VARIFOCAL, '"uniform"', '"even"', "spacing", "did you mean"),
    (VARIFOCAL, "d0_mm = 3", "d0_mm = 3\nposition_mm = 1", "layer 0", "position_mm", "leave it out"),
    (VARIFOCAL, VARIFOCAL[VARIFOCAL.index("[[layer]]"):], "", "0 [[layer]]", "exactly one"),
]


class Displays(SystemTest):
    def setUp(self):
        super().setUp()
        self.file = self.dir / "mine.toml"

    def test_good_files_are_good(self):
        for toml in (BARRIERS, LENSES, VARIFOCAL):
            self.file.write_text(toml)
            result = run("displays", "check", self.file)
            self.assertEqual(result.code, 0, result.err)
            self.assertIn("good", result.out)

    def test_every_mistake_gets_one_line(self):
        files = []
        for i, (good, old, new, *_) in enumerate(MISTAKES):
            self.assertIn(old, good)
            files.append(self.dir / f"mistake_{i:03}.toml")
            files[-1].write_text(good.replace(old, new, 1))
        result = run("displays", "check", *files)
        self.assertEqual((result.code, result.out), (2, ""))
        lines = result.error_lines()
        self.assertEqual(len(lines), len(files))
        for file, line, (_, old, new, *words) in zip(files, lines, MISTAKES):
            with self.subTest(old[:40] + " -> " + new[:40]):
                for word in (file.name, *words):
                    self.assertIn(word.lower(), line.lower())

    def test_good_files_are_told_from_wrong_ones(self):
        (self.dir / "good.toml").write_text(LENSES)
        self.file.write_text("nonsense = 1\n")
        result = run("displays", "check", self.file, self.dir / "good.toml", self.dir / "absent.toml")
        self.assertEqual(result.code, 2)
        self.assertIn("good.toml: good", result.out)
        self.assertEqual([line.count("mine.toml") + 2 * line.count("absent.toml") for line in result.error_lines()], [1, 2])

    def test_layers_refuses_them_before_any_work(self):
        for good, old, new, *words in MISTAKES[::9]:
            with self.subTest(old[:40] + " -> " + new[:40]):
                self.file.write_text(good.replace(old, new, 1))
                result = run("layers", "--workspace", self.dir / "w", "--display", self.file)
                self.assert_refused(result, 2, "mine.toml", *words)
                self.assertFalse((self.dir / "w").exists())

    def test_files_that_are_no_display(self):
        self.file.write_bytes(bytes(range(256)) * 4)
        self.assert_refused(run("displays", "check", self.file), 2, "mine.toml:1")
        self.assert_refused(run("displays", "check", self.dir / "absent.toml"), 2, "absent.toml", "there is no file")
        self.assert_refused(run("displays", "check", self.dir), 2, str(self.dir))


if __name__ == "__main__":
    harness.main()
