"""What the system tests share: running the program, making small captures, looking at folders.

Captures are made here and not by the program, so that they are truth of their own.
"""
import hashlib
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

PROGRAM = os.environ.get("LAMELLA", "lamella")


class Result:
    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err

    def error_lines(self):
        """The lines that the program says of its errors."""
        return [line for line in self.err.splitlines() if line.startswith("lamella: ")]


def run(*arguments, env=None, cwd=None, timeout=300):
    words = [PROGRAM, *[str(a) for a in arguments]]
    environment = {**os.environ, **(env or {})}
    done = subprocess.run(words, capture_output=True, text=True, env=environment, cwd=cwd, timeout=timeout,
                          stdin=subprocess.DEVNULL)
    return Result(done.returncode, done.stdout, done.stderr)


def write_png(path, width, height, pixel):
    """8-bit RGB; pixel(x, y) gives three codes."""
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 6)) +
                           chunk(b"IEND", b""))


def texture(u, v, seed=0):
    """A smooth pattern with detail of many sizes; codes 0..255."""
    total = 0.0
    for k in range(1, 6):
        f = 0.035 * 1.7 ** k
        total += math.sin(f * u * (1 + 0.13 * k) + seed + 1.7 * k) * math.cos(f * v + 0.9 * seed + 0.6 * k * k)
    value = 128 + 24 * total
    return tuple(int(max(0, min(255, value * w))) for w in (1.0, 0.8 + 0.1 * math.sin(0.05 * u), 0.9))


def write_parameters(folder, columns, rows, width, height):
    (Path(folder) / "parameters.cfg").write_text(
        "[intrinsics]\nfocal_length_mm = 100.0\n"
        f"image_resolution_x_px = {width}\nimage_resolution_y_px = {height}\nsensor_size_mm = 35.0\nfstop = 100.0\n"
        f"[extrinsics]\nnum_cams_x = {columns}\nnum_cams_y = {rows}\nbaseline_mm = 25.0\nfocus_distance_m = 4.0\n"
        "center_cam_x_m = 0.0\ncenter_cam_y_m = 0.0\ncenter_cam_z_m = 0.0\n"
        "center_cam_rx_rad = 0.0\ncenter_cam_ry_rad = 0.0\ncenter_cam_rz_rad = 0.0\n"
        "[meta]\nscene = test\ncategory = test\ndisp_min = -2\ndisp_max = 2\n")


def write_grid(folder, side=3, size=64, wrong_size_of=None):
    """An HCI-like grid: a background plane at disparity -1 and a square in front of it at +1."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    centre = side // 2
    for index in range(side * side):
        dr, dc = index // side - centre, index % side - centre

        def pixel(x, y):
            fx, fy = x + dc, y + dr  # disparity +1: the point of the centre view
            if size * 0.3 < fx < size * 0.7 and size * 0.35 < fy < size * 0.75:
                return texture(fx, fy, 2)
            return texture(x - dc, y - dr, 5)

        wide = size + (2 if index == wrong_size_of else 0)
        write_png(folder / f"input_Cam{index:03d}.png", wide, size, pixel)
    write_parameters(folder, side, side, size, size)
    return folder


SMALL_DISPLAY = """format_version = 1
name = "small"
viewing_distance_mm = 600
border_mm = 4

[panel]
width_px = 96
height_px = 96
pitch_mm = 0.3

[[layer]]
position_mm = -10
d0_mm = 5
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3

[[layer]]
position_mm = 10
d0_mm = 5
[layer.barrier]
period_px = 6
aperture_px = 2
slots = 3
"""


def fingerprint(folder):
    """File -> content, but for what may differ between equal runs: times and memory in stage.json and
    on the page."""
    prints = {}
    for path in sorted(Path(folder).rglob("*")):
        if not path.is_file():
            continue
        content = path.read_bytes()
        name = str(path.relative_to(folder))
        if path.name == "stage.json":
            lines = content.decode().splitlines()
            content = "\n".join(line for line in lines
                                if '"seconds"' not in line and '"peak_memory_mib"' not in line).encode()
            if name.startswith("preview"):  # holds the hash and the size of the page
                content = b"".join(line for line in content.splitlines(True) if b'"hash"' not in line and b'"size"' not in line)
        if name == "preview/index.html":
            continue
        prints[name] = hashlib.sha256(content).hexdigest()
    return prints


def half_written(folder):
    return [str(p) for p in Path(folder).rglob("*.partial*")] if Path(folder).exists() else []


class SystemTest(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="lamella-test-")
        self.dir = Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def assert_refused(self, result, code, *words):
        """One line, the exit code, and the words that a user needs."""
        self.assertEqual(result.code, code, result.err)
        lines = result.error_lines()
        self.assertEqual(len(lines), 1, result.err)
        for word in words:
            self.assertIn(word.lower(), lines[0].lower())


def main():
    if len(sys.argv) > 1 and sys.argv[1] == "--program":
        global PROGRAM
        PROGRAM = sys.argv[2]
        del sys.argv[1:3]
    unittest.main(verbosity=2)
