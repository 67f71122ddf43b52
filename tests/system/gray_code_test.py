"""Gray code from patterns to a map: the stripes and their photographs are made here, and the map is read by oiiotool."""
import re
import subprocess

import harness
from harness import SystemTest, run, write_png

# 13 x 8 cells, of which the last column is 2 px wide: 4 and 3 bits.
WIDTH, HEIGHT, CELL = 50, 32, 4
SCREEN = ("--width-px", WIDTH, "--height-px", HEIGHT, "--cell-px", CELL)


def reflected(bits):
    """The code of every number, as text: the code of half as many, then that backwards with 1 in front."""
    codes = [""]
    for _ in range(bits):
        codes = ["0" + code for code in codes] + ["1" + code for code in reversed(codes)]
    return codes


COLUMNS, ROWS = reflected(4), reflected(3)


def is_white(pattern, u, v):
    if pattern >= 14:
        return pattern == 14
    if pattern < 8:
        bit = COLUMNS[u // CELL][pattern // 2]
    else:
        bit = ROWS[v // CELL][pattern // 2 - 4]
    return (bit == "1") != (pattern % 2 == 1)


def seen(x, y):
    """The screen's point that the photograph's pixel (x, y) sees: turned by a right angle, with a little shear."""
    return -2 + 0.9 * (y + 0.5) + 0.05 * (x + 0.5), -3 + 0.8 * (x + 0.5)


class GrayCodeTest(SystemTest):
    def photograph(self):
        """48 x 64 px in a lit room, named without leading zeros."""
        folder = self.dir / "photos"
        folder.mkdir()
        for pattern in range(16):
            def pixel(x, y):
                u, v = seen(x, y)
                white = 0 <= u < WIDTH and 0 <= v < HEIGHT and is_white(pattern, int(u), int(v))
                return (170, 180, 160) if white else (40, 40, 45)
            write_png(folder / f"im{pattern + 1}.png", 48, 64, pixel)
        return folder

    def test_patterns_are_drawn_in_the_order_in_which_they_are_read(self):
        drawn = run("calibrate", "gray-code-patterns", *SCREEN, "--out", self.dir / "patterns")
        self.assertEqual(drawn.code, 0, drawn.err)
        self.assertEqual(drawn.out.splitlines(), ["16 patterns", str(self.dir / "patterns")])
        read = run("calibrate", "gray-code", self.dir / "patterns", *SCREEN, "--out", self.dir / "map.exr")
        self.assertEqual(read.code, 0, read.err)
        self.assertIn("100.0 % of 50 x 32 px decoded: they see columns 2 to 49 of 50 px", read.out)

    def test_a_map_of_photographs_names_the_cell_that_every_pixel_sees(self):
        result = run("calibrate", "gray-code", self.photograph(), *SCREEN, "--out", self.dir / "map.exr")
        self.assertEqual(result.code, 0, result.err)
        share, steps, file = result.out.splitlines()
        self.assertIn("of 48 x 64 px decoded: they see columns 2 to 49 of 50 px and rows 2 to 30 of 32 px", share)
        self.assertEqual(steps, "0.0 % of the steps from cell to cell go back")
        self.assertEqual(file, str(self.dir / "map.exr"))
        # Channels by their names: sd_u, sd_v, u, v.
        dump = subprocess.run(["oiiotool", "--dumpdata", file], capture_output=True, text=True, check=True).stdout
        known = 0
        for x, y, values in re.findall(r"Pixel \((\d+), (\d+)\): (.*)", dump):
            sd_u, sd_v, u, v = map(float, values.split())
            true_u, true_v = seen(int(x), int(y))
            if not (0 <= true_u < WIDTH and 0 <= true_v < HEIGHT):
                self.assertEqual((u, v, sd_u, sd_v), (0, 0, 0, 0))
                continue
            known += 1
            first = int(true_u) // CELL * CELL
            last = min(first + CELL, WIDTH)
            self.assertAlmostEqual(u, (first + last) / 2)
            self.assertAlmostEqual(v, int(true_v) // CELL * CELL + CELL / 2)
            self.assertAlmostEqual(sd_u, (last - first) / 12 ** 0.5, 5)
            self.assertAlmostEqual(sd_v, CELL / 12 ** 0.5, 5)
        self.assertGreater(known, 2000)
        self.assertIn(f"{100 * known / (48 * 64):.1f} %", share)

    def test_mistakes_get_one_line_and_no_map(self):
        photos, out = self.photograph(), self.dir / "map.exr"
        command = ("calibrate", "gray-code", photos, *SCREEN, "--out")
        self.assert_refused(run(*command, self.dir / "map.png"), 2, "map.png", "exr")
        (photos / "im7.png").rename(self.dir / "im7.png")
        (photos / "im8.png").rename(photos / "im7.png")
        (self.dir / "im7.png").rename(photos / "im8.png")
        self.assert_refused(run(*command, out), 3, "go back", "order")
        self.assertFalse(out.exists())
        self.assertEqual(harness.half_written(self.dir), [])

    def test_help_is_enough(self):
        result = run("calibrate", "gray-code", "--help")
        self.assertEqual(result.code, 0, result.err)
        for words in ("OpenCV", "gray-code-patterns", "--cell-px", "--least-contrast", "sd_u", "Examples"):
            self.assertIn(words, result.out)


if __name__ == "__main__":
    harness.main()
