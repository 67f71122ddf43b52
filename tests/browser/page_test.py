"""The preview page in a real browser, opened from file://: what a drag shows is what the eye would see."""

import argparse
import base64
import pathlib
import subprocess
import sys
import tempfile
import unittest

from webdriver import Browser

PROGRAM = None
D, NEAR, FAR, PIXEL, STEP = 400.0, 15.0, -15.0, 0.5, 20.0  # of page_fixture.cc, mm

# The centroid (px), the size and the count of the canvas's pixels for which `test` holds.
CENTROID = """
const canvas = document.getElementById('eye');
const p = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
let n = 0, sx = 0, sy = 0;
for (let i = 0; i < p.length; i += 4) {
  const r = p[i], g = p[i + 1], b = p[i + 2];
  if (%s) { ++n; sx += i / 4 %% canvas.width + 0.5; sy += Math.floor(i / 4 / canvas.width) + 0.5; }
}
return n ? {x: sx / n, y: sy / n, n} : null;
"""
YELLOW = "r > 170 && g > 150 && b < 110"
WHITE = "r > 170 && g > 170 && b > 170"


class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="lamella-page-")
        cls.page = pathlib.Path(cls.folder.name) / "a page.html"
        subprocess.run([PROGRAM, cls.page], check=True)
        cls.browser = Browser().__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.folder.cleanup()

    def setUp(self):
        self.browser.open(self.page.as_uri())
        self.settle()

    def settle(self):
        """Until the last requested picture is on the canvas."""
        self.browser.run("return new Promise((done) => setTimeout(done, 150));")

    def eye(self):
        return self.browser.run("const d = document.getElementById('eye').dataset;"
                                "return [+d.column, +d.row, d.mode];")

    def centroid(self, test):
        found = self.browser.run(CENTROID % test)
        self.assertIsNotNone(found, "no such pixels")
        return found

    def test_loads_without_console_messages_and_starts_in_the_middle(self):
        self.assertEqual(self.browser.messages(), [])
        self.assertEqual(self.eye(), [3, 3, "simulated"])
        self.assertEqual(self.browser.run("return document.title;"), "lamella preview")

    def test_asks_the_network_for_nothing(self):
        asked = self.browser.run("return performance.getEntriesByType('resource').map((e) => e.name)"
                                 ".filter((name) => !name.startsWith('data:'));")
        self.assertEqual(asked, [])

    def test_is_upright_and_not_mirrored(self):
        middle = self.centroid(YELLOW)
        self.assertAlmostEqual(middle["x"], 108 + -1.9 / PIXEL, delta=3)  # the F's stem is at the left
        quarter = YELLOW + " && %s"
        top = self.centroid(quarter % "Math.floor(i / 4 / canvas.width) < 78")
        bottom = self.centroid(quarter % "Math.floor(i / 4 / canvas.width) >= 78")
        self.assertGreater(top["n"], 1.4 * bottom["n"])
        self.assertGreater(top["x"], bottom["x"] + 4)
        self.assertLess(self.centroid(WHITE)["x"], 60)
        red = self.centroid("r > 150 && g < 120 && b > 100")  # right half, bottom
        self.assertGreater(red["x"], 108)
        self.assertGreater(red["y"], 78)

    def test_dragging_right_moves_near_things_left_and_far_things_right(self):
        before, still = self.centroid(YELLOW), self.centroid(WHITE)
        width = self.browser.run("return document.getElementById('eye').getBoundingClientRect().width;")
        self.browser.drag("#eye", width / 6 * 2, 0)  # two of the six steps
        self.settle()
        self.assertEqual(self.eye(), [5, 3, "simulated"])
        moved = self.centroid(YELLOW)["x"] - before["x"]
        self.assertAlmostEqual(moved, -2 * STEP * NEAR / (D - NEAR) / PIXEL, delta=0.7)
        self.assertAlmostEqual(self.centroid(WHITE)["x"], still["x"], delta=0.7)
        # The wall's right half is red: its border is behind the F, look below it.
        wall = "r > 120 && g < 100 && b > 80 && Math.floor(i / 4 / canvas.width) > 130"
        there = self.centroid(wall)
        self.browser.press("#eye", "home")
        self.settle()
        # The border moves by 40 * 15 / 415 mm, and the centroid of what is right of it by half of that.
        self.assertAlmostEqual(there["x"] - self.centroid(wall)["x"], 0.5 * 2 * STEP * -FAR / (D - FAR) / PIXEL, delta=0.5)

    def test_dragging_up_moves_near_things_down(self):
        before = self.centroid(YELLOW)
        height = self.browser.run("return document.getElementById('eye').getBoundingClientRect().height;")
        self.browser.drag("#eye", 0, -height / 6 * 2)
        self.settle()
        self.assertEqual(self.eye(), [3, 1, "simulated"])
        self.assertAlmostEqual(self.centroid(YELLOW)["y"] - before["y"], 2 * STEP * NEAR / (D - NEAR) / PIXEL, delta=0.7)

    def test_simulated_and_target_agree_in_place(self):
        self.browser.press("#eye", "right", "right", "down")
        self.settle()
        simulated = self.centroid(YELLOW)
        self.browser.click("input[value=target]")
        self.settle()
        self.assertEqual(self.eye(), [5, 4, "target"])
        target = self.centroid(YELLOW)
        # The openings' lattice is 2 px wide and the plain encoder has no prefilter: edges snap to it.
        self.assertAlmostEqual(simulated["x"], target["x"], delta=1.5)
        self.assertAlmostEqual(simulated["y"], target["y"], delta=1.5)
        self.browser.click("input[value=difference]")
        self.settle()
        dark = self.browser.run(CENTROID % "r < 60 && g < 60 && b < 60")
        self.assertGreater(dark["n"], 0.6 * 216 * 156)

    def test_a_finger_drags_too_and_the_keys_stop_at_the_last_position(self):
        width = self.browser.run("return document.getElementById('eye').getBoundingClientRect().width;")
        self.browser.drag("#eye", -width / 6, 0, pointer="touch")
        self.settle()
        self.assertEqual(self.eye()[:2], [2, 3])
        self.browser.press("#eye", *["up"] * 9)
        self.settle()
        self.assertEqual(self.eye()[:2], [2, 0])

    def test_cross_fading_shows_four_positions_and_keeps_the_brightness(self):
        mean = ("const c = document.getElementById('eye'); const p = c.getContext('2d')"
                ".getImageData(0, 0, c.width, c.height).data; let s = 0;"
                "for (let i = 0; i < p.length; ++i) s += p[i]; return s / p.length;")
        before = self.browser.run(mean)
        self.browser.click("#blend")
        box = self.browser.run("const b = document.getElementById('eye').getBoundingClientRect();"
                               "return [b.width, b.height];")
        self.browser.drag("#eye", box[0] / 12, box[1] / 12)
        self.settle()
        self.assertEqual(self.browser.run("return +document.getElementById('eye').dataset.positions;"), 4)
        self.assertAlmostEqual(self.browser.run(mean), before, delta=3)

    # ---- Layers and slots, against the files of frames/ that the browser decodes itself ----

    def shown_differences(self, *files):
        """The largest differences of codes between the shown parts and files' pixels there, and between the light of
        the whole picture and the first file, by 4 x 4 fields of it. Where they stand the mark on the picture says."""
        uris = ["data:image/png;base64," + base64.b64encode((self.page.parent / "frames" / file).read_bytes()).decode()
                for file in files]
        return self.browser.run("""
            const [uris] = arguments;
            const light = (code) => code <= 10 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4;
            async function pixels(image, x, y, width, height) {
              await image.decode();
              const canvas = document.createElement('canvas');
              canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
              const paint = canvas.getContext('2d');
              paint.drawImage(image, 0, 0);
              return paint.getImageData(x, y, width || image.naturalWidth, height || image.naturalHeight);
            }
            function fields(picture) {
              const sum = new Float64Array(16), n = new Float64Array(16);
              for (let i = 0; i < picture.width * picture.height; ++i) {
                const field = 4 * Math.floor(4 * Math.floor(i / picture.width) / picture.height) +
                  Math.floor(4 * (i % picture.width) / picture.width);
                sum[field] += light(picture.data[4 * i + 1]); ++n[field];
              }
              return sum.map((s, f) => s / n[f]);
            }
            return (async () => {
              const wholes = [...document.querySelectorAll('#step-pictures .whole img')];
              const parts = [...document.querySelectorAll('#step-pictures .part img')];
              const frames = uris.map((uri) => Object.assign(new Image(), {src: uri}));
              await Promise.all(frames.map((f) => f.decode()));
              const mark = document.querySelector('#step-pictures .mark').style;
              const x = Math.round(parseFloat(mark.left) * frames[0].naturalWidth / 100);
              const y = Math.round(parseFloat(mark.top) * frames[0].naturalHeight / 100);
              let most = 0;
              for (let i = 0; i < frames.length; ++i) {
                const shown = await pixels(parts[i], 0, 0);
                const there = await pixels(frames[i], x, y, shown.width, shown.height);
                shown.data.forEach((code, at) => { most = Math.max(most, Math.abs(code - there.data[at])); });
              }
              const whole = fields(await pixels(wholes[0], 0, 0)), file = fields(await pixels(frames[0], 0, 0));
              return {parts: [parts.length, most], whole: Math.max(...whole.map((v, f) => Math.abs(v - file[f]))),
                      brightest: Math.max(...file)};
            })();""", uris)

    def expect_slot(self, layer, slot):
        files = [f"layer_{layer}_slot_{slot}_{role}.png" for role in ("emitter", "modulator")]
        found = self.shown_differences(*files)
        self.assertEqual(found["parts"], [2, 0])  # both frames' pixels, to the code
        self.assertLess(found["whole"], 0.01)
        self.assertGreater(found["brightest"], 0.05)
        captions = self.browser.run("return document.getElementById('step-pictures').textContent;")
        for file in files:
            self.assertIn(file, captions)

    def steps(self):
        return self.browser.run("return ['layer', 'slot'].map((n) => +document.getElementById('step-' + n).value);")

    def test_steps_through_layers_and_slots_by_keys_buttons_and_sliders(self):
        self.assertEqual(self.steps(), [0, 0])  # the sum of the slots comes first
        self.browser.press("#step-pictures", "right")
        self.expect_slot(0, 0)
        self.browser.press("#step-pictures", "right", "right", "down")
        self.assertEqual(self.steps(), [1, 3])
        self.expect_slot(1, 2)
        self.browser.click("#slot-on")
        self.browser.click("#layer-on")
        self.expect_slot(2, 3)
        self.browser.press("#step-slot", "right", "right")
        self.browser.press("#step-layer", "left")
        self.expect_slot(1, 5)
        self.browser.click("#slot-back")
        self.browser.click("#layer-back")
        self.expect_slot(0, 4)
        self.assertIn("4 (x 1, y 1)", self.browser.run(
            "return document.getElementById('step-slot').getAttribute('aria-valuetext');"))
        self.assertEqual(self.browser.messages(), [])

    def test_steps_stop_at_the_ends(self):
        self.browser.press("#step-pictures", "up", "left", *["right"] * 12, *["down"] * 4)
        self.assertEqual(self.steps(), [2, 9])
        self.expect_slot(2, 8)
        disabled = self.browser.run("return ['layer-back', 'layer-on', 'slot-back', 'slot-on'].map((id) =>"
                                    "document.getElementById(id).disabled);")
        self.assertEqual(disabled, [False, True, False, True])

    def test_text_is_only_text(self):
        self.assertIn("<i>markup</i>", self.browser.run("return document.getElementById('warnings').textContent;"))
        self.assertEqual(self.browser.run("return document.querySelectorAll('main i, main b').length;"), 0)

    # How steep the F's left edge is: the largest step between neighbours of a row through its stem.
    def focused_step(self):
        return self.browser.run("""
            const i = document.getElementById('focus-simulated'), c = document.createElement('canvas');
            c.width = i.naturalWidth; c.height = i.naturalHeight;
            const p = c.getContext('2d'); p.drawImage(i, 0, 0);
            const row = p.getImageData(c.width / 4, c.height / 2, c.width / 4, 1).data;
            let most = 0;
            for (let x = 4; x < row.length; x += 4) most = Math.max(most, row[x] - row[x - 4]);
            return most;""")

    def test_the_slider_focuses_the_eye(self):
        self.assertFalse(self.browser.run("return document.getElementById('focus').hidden;"))
        self.assertIn("0.0 mm", self.browser.run("return document.getElementById('plane-text').textContent;"))
        self.browser.press("#plane", "right")
        self.settle()
        near = self.focused_step()
        self.browser.press("#plane", "left", "left")
        self.settle()
        self.assertIn("15.0 mm", self.browser.run("return document.getElementById('plane-text').textContent;"))
        self.assertGreater(near, 1.5 * self.focused_step())  # the F stands in front

    def test_shows_the_cut_off_over_depth(self):
        shown = self.browser.run("const i = document.getElementById('cutoff-figure');"
                                 "return [document.getElementById('cutoff').hidden, i.naturalWidth > 0,"
                                 " document.getElementById('cutoff-caption').textContent];")
        self.assertEqual(shown, [False, True, "80 % are <b>sharp</b>"])

    def test_fits_a_phone_and_changes_its_colours(self):
        for size in ((1280, 900, False), (390, 800, True)):
            with self.subTest(size=size), Browser(*size) as browser:
                browser.open(self.page.as_uri())
                browser.run("return new Promise((done) => setTimeout(done, 200));")
                width, window = browser.run("return [document.documentElement.scrollWidth, innerWidth];")
                self.assertLessEqual(width, window)
                before = browser.run("return getComputedStyle(document.body).backgroundColor;")
                browser.click("#theme")
                self.assertNotEqual(browser.run("return getComputedStyle(document.body).backgroundColor;"), before)
                self.assertEqual(browser.messages(), [])

    def test_every_control_has_a_name(self):
        unnamed = self.browser.run("""
            return [...document.querySelectorAll('button, input, canvas, img, svg')].filter((e) =>
              !(e.getAttribute('aria-label') || e.getAttribute('alt') || e.textContent.trim() ||
                (e.labels && e.labels.length))).map((e) => e.outerHTML.slice(0, 80));""")
        self.assertEqual(unnamed, [])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--fixture", required=True, help="the program that writes the page")
    known, rest = parser.parse_known_args()
    PROGRAM = known.fixture
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
