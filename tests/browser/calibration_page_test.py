"""The pages of calibrations in a real browser: what they draw is there, readable, and asks for nothing."""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import unittest

from webdriver import Browser

PROGRAM = None
PAGES = [f"{kind}-{end}" for kind in ("panels", "sheets", "varifocal") for end in ("good", "open")]


class CalibrationPageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="lamella-page-")
        subprocess.run([PROGRAM, cls.folder.name], check=True)
        cls.browser = Browser().__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.folder.cleanup()

    def page(self, name):
        return (pathlib.Path(self.folder.name) / f"{name}.html").as_uri()

    def show(self, name):
        self.browser.open(self.page(name))

    def text(self):
        return self.browser.run("return document.body.innerText;")

    def test_loads_without_console_messages_or_network(self):
        for page in PAGES:
            self.show(page)
            self.assertEqual(self.browser.messages(), [])
            self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').length;"), 0)

    def test_says_first_whether_the_calibration_may_be_used(self):
        first = "return document.querySelector('main > section').innerText;"
        for kind, known in [("panels", "Rays are known to"), ("sheets", "Lenses of layer 0 are known to"),
                            ("varifocal", "Depths are known to")]:
            self.show(f"{kind}-good")
            self.assertIn("Certain enough", self.browser.run(first))
            self.assertIn(known, self.browser.run(first))
            self.show(f"{kind}-open")
            self.assertIn("Not certain", self.browser.run(first))
            self.assertIn("Cure:", self.text())

    def counts(self, label, mark):
        """Of marks in every drawing whose label begins so."""
        return self.browser.run("""
            return [...document.querySelectorAll('svg')].filter((s) =>
              s.getAttribute('aria-label').startsWith(arguments[0])).map((s) =>
              s.querySelectorAll(arguments[1]).length);""", label, mark)

    def test_draws_every_panel_and_every_view(self):
        self.show("panels-good")
        self.assertEqual(self.counts("Residuals", "rect"), [40] * 4)
        self.assertEqual(self.counts("Standard deviation of rays", "rect"), [35] * 3)
        self.assertEqual(self.counts("Directions", 'circle[r="5"]'), [12])

    def test_draws_a_sheet_and_where_a_further_camera_is_asked_for(self):
        ring = 'circle[r="11"]'
        self.show("sheets-good")
        self.assertEqual(self.counts("Residuals", "rect"), [40])
        self.assertEqual(self.counts("Standard deviation of lenses", "rect"), [9])
        self.assertEqual(self.counts("Directions", 'circle[r="5"]'), [4])  # two of the board alone
        self.assertEqual(self.counts("Directions", 'circle[fill="var(--ink)"]'), [2])
        self.assertEqual(self.counts("Directions", ring), [0])
        self.show("sheets-open")
        self.assertEqual(self.counts("Directions", ring), [1])
        self.assertIn("there is one camera position only", self.text())

    def test_draws_every_plane(self):
        self.show("varifocal-good")
        for label in ("Depth less the designed", "Magnification less the designed", "Depth less the mirror"):
            self.assertEqual(self.counts(label, "circle"), [24])
        beyond = 'rect[fill="#e08a1e"]'
        for label in ("Standard deviation of depth", "Standard deviation of magnification", "Chi squared of planes"):
            self.assertEqual(self.counts(label, "rect"), [24])
            self.assertEqual(self.counts(label, beyond), [0])
        self.assertEqual(self.counts("Residuals", "rect"), [40])
        self.assertEqual(self.counts("Standard deviation of rays", "rect"), [35])
        self.assertEqual(self.counts("Directions", 'circle[r="5"]'), [14])  # two of the sheet alone
        self.show("varifocal-open")
        self.assertEqual(self.counts("Standard deviation of depth", beyond), [24])

    def test_text_of_figures_stays_inside(self):
        for page in PAGES:
            self.show(page)
            outside = self.browser.run("""
                return [...document.querySelectorAll('svg')].flatMap((svg) => {
                  const frame = svg.getBoundingClientRect();
                  return [...svg.querySelectorAll('text')].filter((t) => {
                    const box = t.getBoundingClientRect();
                    return box.left < frame.left - 1 || box.right > frame.right + 1 ||
                           box.top < frame.top - 1 || box.bottom > frame.bottom + 1;
                  }).map((t) => t.textContent);
                });""")
            self.assertEqual(outside, [])

    def test_names_are_only_text(self):
        for page in PAGES:
            self.show(page)
            self.assertIn("<i>7.png</i>: take again", self.text())
            self.assertEqual(self.browser.run("return document.querySelectorAll('main i, main b').length;"), 0)

    def test_fits_a_phone(self):
        with Browser(390, 800, True) as phone:
            for page in PAGES:
                phone.open(self.page(page))
                width, window = phone.run("return [document.documentElement.scrollWidth, innerWidth];")
                self.assertLessEqual(width, window)
                facts = phone.run("return [...document.querySelectorAll('dd')].map((d) => d.clientWidth);")
                self.assertGreater(min(facts), 0.7 * window)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--fixture", required=True, help="the program that writes the pages")
    known, rest = parser.parse_known_args()
    PROGRAM = known.fixture
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
