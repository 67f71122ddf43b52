"""Bad input gets one clear line (what, where, what to do) and the right exit code, and leaves no half-written file."""
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import harness
from harness import SystemTest, run, write_grid, write_png


def photograph(path, seed=1, width=96, height=72):
    write_png(path, width, height, lambda x, y: harness.texture(3 * x, 3 * y, seed))


class CommandLine(SystemTest):
    def test_an_unknown_option_offers_the_nearest_one(self):
        self.assert_refused(run("run", self.dir, "--workspace", self.dir / "w", "--qualty", "draft"), 2, "--qualty", "--quality")

    def test_an_unknown_verb_offers_the_nearest_one(self):
        self.assert_refused(run("previw"), 2, "previw", "preview")

    def test_an_unknown_display_offers_the_nearest_one(self):
        write_grid(self.dir / "grid")
        result = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--display", "paper-two-layers")
        self.assert_refused(result, 2, "paper-two-layers", "paper-two-layer")
        self.assertFalse((self.dir / "w" / "capture" / "capture.json").exists())

    def test_an_unknown_key_of_a_config_file_offers_the_nearest_one_with_file_and_line(self):
        write_grid(self.dir / "grid")
        config = self.dir / "my.toml"
        config.write_text("[poses]\nfeatures = 1000\nimage_size = 3\n")
        result = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--config", config)
        self.assert_refused(result, 2, "my.toml:3", "image_size", "did you mean")

    def test_an_unknown_quality_is_refused(self):
        self.assert_refused(run("run", self.dir, "--workspace", self.dir / "w", "--quality", "bst"), 2, "bst", "best")

    def test_a_display_with_a_mistake_is_refused_before_any_work_in_one_line(self):
        write_grid(self.dir / "grid")
        display = run("displays", "show", "paper-two-layer").out
        file = self.dir / "mine.toml"
        for key, wrong, *words in (
                ("d0_mm", "-1", "d0_mm = -1", "give"), ("d0_mm", "inf", "d0_mm = inf", "give"),
                ("pitch_mm", "0", "pitch_mm = 0", "give"), ("pitch_mm", "nan", "pitch_mm = nan", "give"),
                ("position_mm", "4", "layers 0 and 1 are at 4 and 4 mm", "position_mm"),
                ("slots", "4", "slots = 4", "divide the period"), ("aperture_px", "3", "aperture_px = 3", "parity"),
                ("period_px", "0", "period_px = 0", "give"), ("width_px", "600000000", "pixels", "at most"),
                ("border_mm", "21", "border_mm = 21", "give at most"),
                ("viewing_distance_mm", "3", "viewing_distance_mm = 3", "in front"),
                ("binning_px", "1\ngapp = 3", "gapp", "did you mean")):
            with self.subTest(key=key, wrong=wrong):
                file.write_text(re.sub(rf"(?m)^{key} = .*$", f"{key} = {wrong}", display))
                result = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--display", file)
                self.assert_refused(result, 2, "mine.toml", *words)
                self.assertFalse((self.dir / "w" / "capture").exists())

    def test_a_display_of_lenses_gets_its_frames(self):
        write_grid(self.dir / "grid")
        result = run("run", self.dir / "grid", "--workspace", self.dir / "w", "--display", "paper-varifocal",
                     "--quality", "draft", "--until", "frames")
        self.assertEqual(result.code, 0, result.err)
        self.assertEqual(len(list((self.dir / "w" / "frames").glob("stroke_*.png"))), 16)

    def test_a_value_out_of_range_names_its_flag(self):
        self.assert_refused(run("run", self.dir, "--workspace", self.dir / "w", "--poses-features", "-5"), 2, "--poses-features")

    def test_help_is_enough_and_ends_with_0(self):
        for verb in ("run", "capture", "poses", "depth", "layers", "frames", "preview", "status", "views", "compare", "displays", "doctor"):
            result = run(verb, "--help")
            self.assertEqual(result.code, 0, verb)
            self.assertIn("--help", result.out)

    def test_a_stage_before_its_inputs_says_what_to_run(self):
        (self.dir / "w").mkdir()
        self.assert_refused(run("depth", "--workspace", self.dir / "w"), 3, "poses", "lamella run")


class Input(SystemTest):
    def refuse(self, code, *words, options=()):
        result = run("run", self.dir / "in", "--workspace", self.dir / "w", *options)
        self.assert_refused(result, code, *words)
        self.assertEqual(harness.half_written(self.dir), [])

    def setUp(self):
        super().setUp()
        (self.dir / "in").mkdir()

    def test_a_folder_that_is_not_there(self):
        (self.dir / "in").rmdir()
        self.refuse(3, str(self.dir / "in"))

    def test_an_empty_folder(self):
        self.refuse(3, str(self.dir / "in"), "no image")

    def test_one_image(self):
        photograph(self.dir / "in" / "a.png")
        self.refuse(3, "one")

    def test_a_truncated_jpeg(self):
        for i, name in enumerate("abc"):
            photograph(self.dir / f"{name}.png", i)
            subprocess.run(["oiiotool", self.dir / f"{name}.png", "-o", self.dir / "in" / f"{name}.jpg"], check=True)
        whole = (self.dir / "in" / "b.jpg").read_bytes()
        (self.dir / "in" / "b.jpg").write_bytes(whole[: len(whole) // 2])
        self.refuse(3, "b.jpg", "truncated")

    def test_a_text_file_named_png(self):
        photograph(self.dir / "in" / "a.png")
        photograph(self.dir / "in" / "b.png", 2)
        (self.dir / "in" / "c.png").write_text("this is no picture\n")
        self.refuse(3, "c.png")

    def test_an_empty_file_named_jpg(self):
        photograph(self.dir / "in" / "a.png")
        photograph(self.dir / "in" / "b.png", 2)
        (self.dir / "in" / "c.jpg").write_text("")
        self.refuse(3, "c.jpg", "empty")

    def test_a_grid_with_images_of_different_sizes(self):
        shutil.rmtree(self.dir / "in")
        write_grid(self.dir / "in", wrong_size_of=4)
        self.refuse(3, "input_Cam004", "size")

    def test_photographs_without_overlap(self):
        for i in range(4):
            photograph(self.dir / "in" / f"photo{i}.png", 10 * i + 1, 320, 240)
        self.refuse(3, "overlap")

    def test_two_views_of_one_name(self):
        photograph(self.dir / "in" / "a.png")
        photograph(self.dir / "in" / "b.png", 2)
        subprocess.run(["oiiotool", self.dir / "in" / "a.png", "-o", self.dir / "in" / "a.jpg"], check=True)
        self.refuse(3, "a.")

    def test_a_views_pattern_that_meets_nothing(self):
        photograph(self.dir / "in" / "first.png")
        photograph(self.dir / "in" / "second.png", 2)
        self.refuse(2, "frist", "first", options=("--views", "frist"))


class Machine(SystemTest):
    def test_a_read_only_destination(self):
        """Root may write everywhere but on a file system that is mounted read-only."""
        write_grid(self.dir / "grid")
        place = self.dir / "read-only"
        place.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro,size=1m", "tmpfs", place], capture_output=True).returncode:
            self.skipTest("mounting a tmpfs is not allowed here")
        try:
            self.assert_refused(run("run", self.dir / "grid", "--workspace", place / "w"), 5, str(place), "read-only")
        finally:
            subprocess.run(["umount", place], check=True)

    def test_a_full_disk_ends_with_5_and_goes_on_when_there_is_space(self):
        write_grid(self.dir / "grid")
        (self.dir / "small.toml").write_text(harness.SMALL_DISPLAY)
        place = self.dir / "small-disk"
        place.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", place], capture_output=True).returncode:
            self.skipTest("mounting a tmpfs is not allowed here")
        command = ("run", self.dir / "grid", "--workspace", place / "w", "--display", self.dir / "small.toml", "--quality", "draft")
        try:
            self.assert_refused(run(*command), 5, str(place), "space")
            self.assertEqual(harness.half_written(place), [])
            subprocess.run(["mount", "-o", "remount,size=200m", place], check=True)
            result = run(*command)
            self.assertEqual(result.code, 0, result.err)
        finally:
            subprocess.run(["umount", place], check=True)

    def test_colmap_absent_is_found_by_doctor_and_before_any_work(self):
        (self.dir / "in").mkdir()
        for i in range(3):
            photograph(self.dir / "in" / f"p{i}.png", i)
        with tempfile.TemporaryDirectory() as empty:
            doctor = run("doctor", env={"PATH": empty})
            self.assertEqual(doctor.code, 5)
            self.assertIn("MISSING", doctor.out)
            self.assertIn("apt-get install colmap", doctor.out)
            result = run("run", self.dir / "in", "--workspace", self.dir / "w", env={"PATH": empty})
        self.assert_refused(result, 5, "colmap", "apt-get install")
        self.assertFalse((self.dir / "w" / "poses").exists())

    def test_a_workspace_that_holds_files_of_the_users_is_not_emptied(self):
        write_grid(self.dir / "grid")
        (self.dir / "w" / "capture").mkdir(parents=True)
        (self.dir / "w" / "capture" / "precious.txt").write_text("mine")
        self.assert_refused(run("run", self.dir / "grid", "--workspace", self.dir / "w"), 3, "capture", "not written")
        self.assertEqual((self.dir / "w" / "capture" / "precious.txt").read_text(), "mine")


if __name__ == "__main__":
    harness.main()
