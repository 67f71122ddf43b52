"""A capture to a quilt and to a Looking Glass's image, by the commands that a user types."""
import json
import struct

import harness
from harness import SystemTest, run, write_grid

PANEL = {"configVersion": "3.0", "serial": "LKG-PORT-00000", "pitch": {"value": 52.5}, "slope": {"value": -7.1},
         "center": {"value": 0.4}, "viewCone": {"value": 40.0}, "DPI": {"value": 324.0}, "screenW": {"value": 150.0},
         "screenH": {"value": 200.0}, "invView": {"value": 0}}


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


class QuiltTest(SystemTest):
    def setUp(self):
        super().setUp()
        write_grid(self.dir / "grid")
        self.workspace = self.dir / "W"

    def with_depth(self):
        made = run("run", self.dir / "grid", "-w", self.workspace, "--until", "depth")
        self.assertEqual(made.code, 0, made.err)

    def render(self, *arguments, out="q.png"):
        return run("quilt", "render", "-w", self.workspace, "--out", self.dir / out, *arguments)

    def test_a_capture_becomes_a_quilt_and_its_device_s_image(self):
        self.with_depth()
        before = harness.fingerprint(self.workspace)
        (self.dir / "visual.json").write_text(json.dumps(PANEL))
        made = self.render("--visual", self.dir / "visual.json", "--columns", 4, "--rows", 3, "--views", 10,
                           "--width", 240, "--depth-budget", 2, "--threads", 1)
        self.assertEqual(made.code, 0, made.err)
        quilt, native = self.dir / "q_qs4x3a0.75.png", self.dir / "q_native.png"
        self.assertEqual(made.out.splitlines()[-2:], [str(quilt), str(native)])
        self.assertEqual(png_size(quilt), (240, 240))
        self.assertEqual(png_size(native), (150, 200))
        for word in ("depth", "+2.0 to -2.0 mm", "viewing distance", "rays seen", "10 of 60 x 80 px, over 40 degrees"):
            self.assertIn(word, made.out)
        self.assertEqual(harness.fingerprint(self.workspace), before)  # nothing is changed there
        # Other threads write the same bytes, and `quilt native` weaves the same image.
        again = self.render("--visual", self.dir / "visual.json", "--columns", 4, "--rows", 3, "--views", 10,
                            "--width", 240, "--depth-budget", 2, "--threads", 2, out="again.png")
        self.assertEqual(again.code, 0, again.err)
        self.assertEqual((self.dir / "again_qs4x3a0.75.png").read_bytes(), quilt.read_bytes())
        woven = run("quilt", "native", quilt, "--visual", self.dir / "visual.json", "--views", 10,
                    "--out", self.dir / "woven.png")
        self.assertEqual(woven.code, 0, woven.err)
        self.assertEqual((self.dir / "woven.png").read_bytes(), native.read_bytes())
        self.assertEqual(harness.half_written(self.dir), [])

    def test_mistakes_get_one_line_and_the_right_code(self):
        self.assert_refused(self.render(), 3, "needs poses", "lamella run")
        made = run("run", self.dir / "grid", "-w", self.workspace, "--until", "poses")
        self.assertEqual(made.code, 0, made.err)
        self.assert_refused(self.render(), 3, "needs depth", "lamella depth")
        self.assert_refused(self.render("--views", 0), 2, "--views")
        self.assert_refused(self.render("--columns", 0), 2, "--columns")
        self.assert_refused(self.render("--views", 49), 2, "8 x 6 tiles hold no 49 views")
        self.assert_refused(self.render("--width", 100000, "--height", 100000), 2, "2^29")
        self.assert_refused(self.render("--cone", 180), 2, "--cone")
        self.assert_refused(self.render("--filter", "liner"), 2, "linear")
        self.assert_refused(self.render("--colums", 8), 2, "--columns")
        self.assert_refused(self.render(out="q.jpg"), 2, "is no .png")
        (self.dir / "new.json").write_text(json.dumps({**PANEL, "configVersion": "4.0"}))
        self.assert_refused(self.render("--visual", self.dir / "new.json"), 3, "new.json", "4.0", "newer")
        self.assert_refused(self.render("--visual", self.dir / "new.json", "--aspect", 0.75), 2, "--aspect", "--visual")
        self.assert_refused(self.render("--visual", self.dir / "none.json"), 3, "none.json")
        self.assertEqual([p.name for p in self.dir.glob("*.png")], [])


if __name__ == "__main__":
    harness.main()
