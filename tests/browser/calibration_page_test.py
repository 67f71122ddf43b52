"""The page of a calibration in a real browser: what it draws is there, readable, and asks for nothing."""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import unittest

from webdriver import Browser

PROGRAM = None


class CalibrationPageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="lamella-page-")
        cls.good, cls.open = (pathlib.Path(cls.folder.name) / name for name in ("good.html", "open.html"))
        subprocess.run([PROGRAM, cls.good, cls.open], check=True)
        cls.browser = Browser().__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.folder.cleanup()

    def show(self, page):
        self.browser.open(page.as_uri())

    def text(self):
        return self.browser.run("return document.body.innerText;")

    def test_loads_without_console_messages_or_network(self):
        for page in (self.good, self.open):
            self.show(page)
            self.assertEqual(self.browser.messages(), [])
            self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').length;"), 0)

    def test_says_first_whether_the_calibration_may_be_used(self):
        first = "return document.querySelector('main > section').innerText;"
        self.show(self.good)
        self.assertIn("Certain enough", self.browser.run(first))
        self.assertIn("Rays are known to", self.text())
        self.show(self.open)
        self.assertIn("Not certain", self.browser.run(first))
        self.assertIn("Cure:", self.text())

    def test_draws_every_panel_and_every_view(self):
        self.show(self.good)
        counts = self.browser.run("""
            const of = (label) => [...document.querySelectorAll('svg')].filter((s) =>
              s.getAttribute('aria-label').startsWith(label));
            return [of('Residuals').map((s) => s.querySelectorAll('rect').length),
                    of('Standard deviation').map((s) => s.querySelectorAll('rect').length),
                    of('Directions')[0].querySelectorAll('circle[r="5"]').length];""")
        self.assertEqual(counts, [[40] * 4, [35] * 3, 12])

    def test_text_of_figures_stays_inside(self):
        for page in (self.good, self.open):
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
        self.show(self.good)
        self.assertIn("<i>7.png</i>: take again", self.text())
        self.assertEqual(self.browser.run("return document.querySelectorAll('main i, main b').length;"), 0)

    def test_fits_a_phone(self):
        for page in (self.good, self.open):
            with self.subTest(page=page.name), Browser(390, 800, True) as phone:
                phone.open(page.as_uri())
                width, window = phone.run("return [document.documentElement.scrollWidth, innerWidth];")
                self.assertLessEqual(width, window)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--fixture", required=True, help="the program that writes the pages")
    known, rest = parser.parse_known_args()
    PROGRAM = known.fixture
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
