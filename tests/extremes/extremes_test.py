"""Extreme captures through the whole program: right, or refused with one clear line; never NaN, never a crash."""
import struct
import subprocess
import sys
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "system"))
import harness  # noqa: E402
from harness import SystemTest, run, write_grid, write_png  # noqa: E402


def oiiotool(*words):
    subprocess.run(["oiiotool", *map(str, words)], check=True, capture_output=True)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


class Extremes(SystemTest):
    def setUp(self):
        super().setUp()
        self.display = self.dir / "small.toml"
        self.display.write_text(harness.SMALL_DISPLAY)

    def whole(self, grid, *more):
        return run("run", grid, "--workspace", self.dir / "w", "--display", self.display, "--quality", "draft", *more)

    def assert_right_or_refused(self, result):
        """0 with the page there and no NaN in its numbers, or one line and an exit code that is not «a bug»."""
        if result.code == 0:
            self.assertTrue((self.dir / "w" / "preview" / "index.html").exists())
            self.assertNotIn("nan", (self.dir / "w" / "preview" / "metrics.json").read_text().lower())
            return
        self.assertIn(result.code, (2, 3, 4, 5), result.err)
        self.assertEqual(len(result.error_lines()), 1, result.err)

    def plain_grid(self, columns, rows, width, height, pixel=None):
        grid = self.dir / "grid"
        grid.mkdir()
        for i in range(columns * rows):
            dc, dr = i % columns, i // columns
            write_png(grid / f"input_Cam{i:03d}.png", width, height,
                      pixel or (lambda x, y, dc=dc, dr=dr: harness.texture(x + dc, y + dr)))
        harness.write_parameters(grid, columns, rows, width, height)
        return grid

    def converted_grid(self, extension, *words):
        grid = self.dir / "grid"
        grid.mkdir()
        for png in sorted(write_grid(self.dir / "png", size=32).glob("*.png")):
            oiiotool(png, *words, "-o", grid / (png.stem + extension))
        harness.write_parameters(grid, 3, 3, 32, 32)
        return grid

    def test_images_of_one_pixel(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(3, 3, 1, 1)))

    def test_images_of_one_row(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(3, 1, 40, 1)))

    def test_images_of_one_column(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(1, 3, 1, 40)))

    def test_images_30_000_pixels_wide(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(3, 1, 30000, 3)))

    def test_one_view_of_a_grid(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(1, 1, 32, 32)))

    def test_two_views_of_a_grid(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(2, 1, 48, 32)))

    def test_a_thousand_views(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(40, 25, 12, 12)))

    def test_views_without_texture(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(3, 3, 32, 32, lambda x, y: (90, 90, 90))))

    def test_black_views(self):
        self.assert_right_or_refused(self.whole(self.plain_grid(3, 3, 32, 32, lambda x, y: (0, 0, 0))))

    def test_half_floats(self):
        result = self.whole(self.converted_grid(".exr", "-d", "half"))
        self.assertEqual(result.code, 0, result.err)

    def test_16_bits(self):
        result = self.whole(self.converted_grid(".png", "-d", "uint16"))
        self.assertEqual(result.code, 0, result.err)

    def test_radiance_of_1e8(self):
        self.assert_right_or_refused(self.whole(self.converted_grid(".exr", "--mulc", "1e8", "-d", "float")))

    def test_radiance_of_1e_minus_8(self):
        self.assert_right_or_refused(self.whole(self.converted_grid(".exr", "--mulc", "1e-8", "-d", "float")))

    def test_infinity_in_an_exr_is_refused_with_the_file_and_the_pixel(self):
        grid = self.converted_grid(".exr", "-d", "float")
        # 1e30 squared overflows the float: the way in which an infinity gets into a file.
        oiiotool("--create", "32x32", "3", "--addc", "1e30", "--mulc", "1e30", "-d", "float", "-o", grid / "input_Cam004.exr")
        self.assert_refused(self.whole(grid), 3, "input_Cam004.exr", "not finite")

    def test_a_png_that_lies_about_its_size(self):
        grid = write_grid(self.dir / "grid", size=32)
        side = 1 << 19
        (grid / "input_Cam004.png").write_bytes(
            b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\0" * 100)) + chunk(b"IEND", b""))
        self.assert_refused(self.whole(grid), 3, "input_Cam004.png")

    def test_a_truncated_png(self):
        grid = write_grid(self.dir / "grid", size=64)
        whole = (grid / "input_Cam004.png").read_bytes()
        (grid / "input_Cam004.png").write_bytes(whole[: len(whole) // 2])
        self.assert_refused(self.whole(grid), 3, "input_Cam004.png")


if __name__ == "__main__":
    harness.main()
