"""Generated captures through the program: handheld photographs are reconstructed to the exact poses, a
user's recipe is taken, and a wrong one is refused with file and line."""
import json
import re
import unittest

import harness
from harness import SystemTest, run, write_png

MESH = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float u
property float v
element face 2
property list uchar int vertex_indices
end_header
-1 -1 0 0 0
1 -1 0 1 0
1 1 0.3 1 1
-1 1 0.3 0 1
3 0 1 2
3 0 2 3
"""

RECIPE = """name = "mine"
seed = 4

[cameras]
layout = "handheld"
views = 3
width_px = 96

[[surface]]
shape = "mesh"
file = "mesh.ply"
turn_deg = [0, 20, 0]
texture = { pattern = "image", file = "picture.png" }
"""


class Handheld(SystemTest):
    def test_all_views_are_registered_within_a_thousandth_of_the_scene(self):
        out, work = self.dir / "room", self.dir / "w"
        self.assertEqual(run("synth", "scene", "room", "--out", out, "--views", 7, "--width-px", 480, "--cameras-angle-deg", 16).code, 0)
        result = run("run", out / "images", "--workspace", work, "--until", "poses")
        self.assertEqual(result.code, 0, result.err)
        result = run("compare", "poses", work / "poses" / "transforms.json", out / "transforms.json")
        self.assertEqual(result.code, 0, result.err)
        figures = re.search(r"views (\d+) .*centre_max ([\d.e-]+)", result.out)
        self.assertEqual(int(figures[1]), 7, result.out)
        self.assertLess(float(figures[2]), 1e-3 * 6.5, result.out)  # the room is 6.5 wide


class Recipe(SystemTest):
    def setUp(self):
        super().setUp()
        (self.dir / "mesh.ply").write_text(MESH)
        write_png(self.dir / "picture.png", 64, 64, lambda x, y: harness.texture(4 * x, 4 * y))
        self.recipe = self.dir / "mine.toml"
        self.recipe.write_text(RECIPE)

    def synth(self, *options):
        return run("synth", "scene", self.recipe, "--out", self.dir / "out", *options)

    def refuse(self, old, new, code, *words):
        self.recipe.write_text(RECIPE.replace(old, new))
        self.assert_refused(self.synth(), code, *words)
        self.assertFalse((self.dir / "out").exists())

    def test_a_mesh_with_a_picture_is_photographed(self):
        result = self.synth()
        self.assertEqual(result.code, 0, result.err)
        frames = json.loads((self.dir / "out" / "transforms.json").read_text())["frames"]
        self.assertEqual([f["name"] for f in frames], ["view_001", "view_002", "view_003"])
        for name in ("images/view_001.jpg", "depth/view_001.exr", "masks/view_001.png", "recipe.toml", "degradation.json"):
            self.assertTrue((self.dir / "out" / name).is_file(), name)
        self.assertEqual(harness.half_written(self.dir / "out"), [])

    def test_the_same_call_gives_the_same_bytes_whatever_the_threads(self):
        self.synth("--threads", 1, "--degradation-full-well-e", 2000)
        first = harness.fingerprint(self.dir / "out")
        self.synth("--threads", 2, "--degradation-full-well-e", 2000)
        self.assertEqual(harness.fingerprint(self.dir / "out"), first)

    def test_wrong_recipes_are_refused_with_file_and_line(self):
        self.refuse("views = 3", "veiws = 3", 2, "mine.toml:6", "veiws", "views")
        self.refuse("views = 3", "views = 0", 2, "mine.toml:6", "views")
        self.refuse("turn_deg = [0, 20, 0]", "fit = -2", 2, "mine.toml:12", "above 0")
        self.refuse("[0, 20, 0]", "[0, nan, 0]", 2, "mine.toml:12", "finite")
        self.refuse("mesh.ply", "cow.ply", 3, "mine.toml:11", "cow.ply")
        self.refuse("picture.png", "photo.png", 3, "mine.toml:13", "photo.png")

    def test_a_broken_mesh_is_refused_with_both_lines(self):
        (self.dir / "mesh.ply").write_text(MESH.replace("1 1 0.3 1 1", "1 1 what 1 1"))
        self.assert_refused(self.synth(), 3, "mine.toml:11", "mesh.ply:14")

    def test_options_stand_above_the_recipe(self):
        self.assertEqual(self.synth("--views", 2, "--format", "png", "--layout", "line").code, 0)
        self.assertEqual(sorted(p.name for p in (self.dir / "out" / "images").iterdir()), ["view_001.png", "view_002.png"])
        self.assert_refused(self.synth("--layout", "grid"), 2, "3 views", "grid")

    def test_the_scenes_are_listed(self):
        result = run("synth", "scene", "--list")
        self.assertEqual(result.code, 0)
        for name in ("room", "charts", "slanted-plane", "occluder", "far-apart", "thin", "curved", "glossy", "near-to-infinity"):
            self.assertIn(name, result.out)
        self.assertIn("near-to-infinity", run("synth", "scene", "--help").out)
        self.assert_refused(run("synth", "scene", "romo", "--out", self.dir / "out"), 2, "romo", "room")


if __name__ == "__main__":
    harness.main()
