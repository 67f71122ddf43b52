"""The measurements of docs/accuracy.md, each as its figures; see accuracy.py.

A measurement is a few commands of the program. Its figures are kept in RECORDS/NAME.json, with the day and the commit
that they are of, and taken from there the next time; its workspace goes as soon as they are.
"""
import datetime
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

EXPERIMENTS = Path(__file__).parents[1] / "docs/experiments.md"
QUALITIES = ("draft", "balanced", "best")
STAGES = ("capture", "poses", "depth", "layers", "frames", "preview")
PITCH_MM = 0.3113158871666749
STEP_MM = 27.15  # between the eyes of neighbouring cameras of hci_antinous, with the placement below
PLACEMENT = ("--disparity-range", "2.689,-3.131", "--depth-budget", "20", "--mm-per-view-px", str(PITCH_MM),
             "--preview-positions", "5", "--preview-eye-box-mm", str(2 * STEP_MM))
# Whatever the quality, so that its figures can be compared.
SAME_PICTURES = ("--preview-width-px", "960")
# Generated scenes; "poses" of the handheld ones, "depth" of the grid's.
SCENES = {"room": "poses", "curved": "poses", "occluder": "poses", "glossy": "poses", "thin": "poses", "far-apart": "poses",
          "near-to-infinity": "poses", "slanted-plane": "depth", "charts": None}
# Eyes of the comparison with true depth, mm, and its displays: 540 x 540 emitters' worth of paper-two-layer's rays.
TRUE_DEPTH_EYES = "0,0;32,0;-32,0;54,0;-54,0"
TRUE_DEPTH_DISPLAYS = {"paper": "as paper-two-layer", "effective": "layers and border by the effective plane",
                       "lens": "square lenslets"}
SUBSET = [f"input_Cam{9 * row + column:03d}" for row in (0, 4, 8) for column in (0, 4, 8)]
TRIALS, FIRST_SEED = 20, 301  # of the calibration loop
# What its design does not know, and which group that asks for.
TERMS = {"nothing": ((), None), "panels bowed by 0.02 mm": (("--bow", "0.02"), "bow"),
         "a splitter's glass of 5 mm, as designed": (("--plate", "5"), None),
         "a splitter's glass of 5.4 mm, not 5": (("--plate", "5.4"), "plate thickness"),
         "air for spacers of index 1.49": (("--index", "1"), "index")}
TERM_GROUPS = ("bow", "plate thickness", "index")
LOOP_FIGURES = {"gap_error_mm": ("gap", "mm", 0.01), "rotation_error_deg": ("rotation", "°", 0.001),
                "ray_rms_px": ("rays, RMS", "panel px", 0.02), "ray_max_px": ("rays, largest", "panel px", 0.06)}


class Bench:
    """Runs the program and keeps the figures. `measures`: also what has no record yet."""

    def __init__(self, program, data, work, records, measures=True):
        self.program, self.data, self.work, self.records, self.measures = program, data, work, records, measures
        for folder in (work, records):
            folder.mkdir(parents=True, exist_ok=True)
        self.commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=Path(__file__).parent,
                                     capture_output=True, text=True, check=True).stdout.strip()

    def run(self, *words):
        """Standard output of `lamella WORDS`, with wall time and peak memory of the process."""
        command = [str(self.program), *map(str, words), "--quiet"]
        start = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)
        out = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        if os.waitstatus_to_exitcode(status) not in (0, 4):
            sys.exit(f"accuracy: failed: {' '.join(command)}")
        return out, {"seconds": time.monotonic() - start, "peak_mib": usage.ru_maxrss / 1024}

    def measure(self, name, take):
        """take(workspace) gives a dictionary, once. None where there is no record and nothing is to be measured."""
        path = self.records / f"{name}.json"
        if not path.exists():
            if not self.measures:
                return None
            print(f"accuracy: {name}", file=sys.stderr, flush=True)
            with tempfile.TemporaryDirectory(dir=self.work) as folder:
                figures = take(Path(folder) / "W")
            day = datetime.date.today().isoformat()
            path.write_text(json.dumps({"measured": day, "commit": self.commit, **figures}, indent=1) + "\n")
        return json.loads(path.read_text())

    def room(self):
        room = self.work / "room"
        if not (room / "transforms.json").exists():
            shutil.rmtree(room, ignore_errors=True)
            self.run("synth", "scene", "room", "--out", room)
        return room


def stages(workspace):
    """Seconds, peak memory and summary of every finished stage."""
    found = {}
    for stage in STAGES:
        path = workspace / stage / "stage.json"
        if path.exists():
            record = json.loads(path.read_text())
            found[stage] = {"seconds": record["seconds"], "peak_mib": record["peak_memory_mib"],
                            "summary": record["summary"]}
    return found


def number(text, name):
    return float(re.search(re.escape(name) + r" +(-?[\d.]+(?:e[-+]?\d+)?)", text).group(1))


# ---- The measurements ----

def poses_against(bench, workspace, truth):
    out, _ = bench.run("compare", "poses", workspace / "poses/transforms.json", truth)
    return {"rmse": number(out, "centre_rmse"), "max": number(out, "centre_max"),
            "rotation_deg": number(out, "rotation_mean_deg"), "views": number(out, "views")}


def fountain_poses(bench, quality):
    root = bench.data / "handheld_gt/fountain-P11"

    def take(workspace):
        bench.run("run", root / "images", "--workspace", workspace, "--until", "poses", "--quality", quality)
        return {"stages": stages(workspace), "poses": poses_against(bench, workspace, root / "gt_dense_cameras")}
    return take


def disparity_against(bench, workspace, capture):
    out, _ = bench.run("compare", "depth", workspace / "depth/input_Cam040.exr", capture / "gt_disp_lowres.pfm")
    return {name: number(out, name) for name in ("badpix_0.07", "badpix_0.03", "badpix_0.01")}


def antinous_views(bench, quality):
    """Nine views of hci_antinous; the other 72 are rendered from them."""
    capture = bench.data / "lightfield/hci_antinous"

    def take(workspace):
        bench.run("run", capture, "--workspace", workspace, "--views", ",".join(SUBSET), "--until", "depth",
                  "--quality", quality)
        out, cost = bench.run("views", "--workspace", workspace, "--cameras", capture,
                              "--views", ",".join(f"!{name}" for name in SUBSET), "--out", workspace / "out",
                              "--border", 15)
        return {"stages": stages(workspace), "depth": disparity_against(bench, workspace, capture),
                "views": {**cost, **means(out)}}
    return take


def means(table):
    """The last line of `lamella views`: share of seen pixels, dB of all and of these."""
    seen, psnr, seen_psnr = map(float, [line for line in table.splitlines() if line.startswith("mean")][-1].split()[1:4])
    return {"seen": seen, "psnr": psnr, "seen_psnr": seen_psnr}


def left_out(bench, quality):
    """fountain-P11 with known cameras, view 0005 rendered from the others at 1536 px."""
    root = bench.data / "handheld_gt/fountain-P11"

    def take(workspace):
        bench.run("run", root / "images", "--workspace", workspace, "--cameras", root / "gt_dense_cameras",
                  "--views", "!0005", "--until", "depth", "--quality", quality)
        out, cost = bench.run("views", "--workspace", workspace, "--cameras", root / "gt_dense_cameras",
                              "--images", root / "images", "--views", "0005", "--size", 1536,
                              "--out", workspace / "out")
        return {"stages": stages(workspace), "views": {**cost, **means(out)}}
    return take


def depth_against(bench, workspace, capture):
    """All views' depth against a generated capture's."""
    out, _ = bench.run("compare", "depth", workspace / "depth", capture / "depth")
    of_known, of_all = re.search(r"within_1_percent ([\d.]+) % of known, ([\d.]+) % of all", out).groups()
    return {"known": number(out, "known"), "median": number(out, "error_median"), "p90": number(out, "error_p90"),
            "within_1": float(of_known), "within_1_of_all": float(of_all)}


def room_depth(bench, quality):
    """The generated capture with its exact cameras: depth of all 14 views against the truth."""
    room = bench.room()

    def take(workspace):
        bench.run("run", room / "images", "--workspace", workspace, "--cameras", room / "transforms.json",
                  "--until", "depth", "--quality", quality)
        return {"stages": stages(workspace), **depth_against(bench, workspace, room)}
    return take


def extent_of(transforms):
    """The largest distance between two cameras."""
    centres = [[row[3] for row in frame["transform_matrix"][:3]] for frame in json.loads(transforms.read_text())["frames"]]
    return max(math.dist(a, b) for a in centres for b in centres)


def scene(bench, name, judged):
    """A generated capture, and what the program makes of it."""
    def take(workspace):
        folder = workspace.parent / name
        _, synth = bench.run("synth", "scene", name, "--out", folder)
        recipe = tomllib.loads((folder / "recipe.toml").read_text())
        cameras = recipe["cameras"]
        found = {"synth": synth, "description": recipe["description"], "views": len(list((folder / "images").iterdir())),
                 "width": cameras["width_px"], "height": cameras["height_px"] or cameras["width_px"] * 3 // 4}
        if judged == "poses":
            bench.run("run", folder / "images", "--workspace", workspace, "--until", "poses")
            found["poses"] = poses_against(bench, workspace, folder / "transforms.json")
            found["extent"] = extent_of(folder / "transforms.json")
        if judged == "depth":
            bench.run("run", folder, "--workspace", workspace, "--until", "depth")
            found["depth"] = depth_against(bench, workspace, folder)
        return found
    return take


def chain(bench, capture, display, quality, *options, also=lambda workspace: {}):
    """All stages; what the simulated eyes are worth, and what `also` finds in the workspace."""
    def take(workspace):
        _, cost = bench.run("run", capture, "--workspace", workspace, "--display", display, "--quality", quality,
                            *options)
        metrics = json.loads((workspace / "preview/metrics.json").read_text())
        return {"stages": stages(workspace), "run": cost, "mean": metrics["mean"],
                "captured": metrics["captured_views"], "page_mib": (workspace / "preview/index.html").stat().st_size / 2**20,
                **also(workspace)}
    return take


def two_layers(name, positions, border_offset_mm=None, lens=False):
    """A display's file: paper-two-layer's rays on 540 x 540 emitters per slot, with other positions or with lenses.

    The lens display has all slots' emitters at once: lenses as far apart as a barrier's openings of all slots, 2 px,
    with the same steps between directions over emitters of a quarter of the pitch at a quarter of the distance. The
    windows of such lenses do not follow the viewer, so they have 8 x 8 directions for a barrier's 6 x 6.
    """
    fine = 4 if lens else 1
    border = f"border_offset_mm = {border_offset_mm}\n" if border_offset_mm is not None else ""
    optics = ('[layer.lenslets]\nlattice = "square"\npitch_px = 8\nrays = 8\n' if lens
              else "[layer.barrier]\nperiod_px = 6\naperture_px = 2\nslots = 3\n")
    layers = "".join(f"\n[[layer]]\nposition_mm = {z}\nd0_mm = {5.0 / fine}\n{optics}" for z in positions)
    return (f'format_version = 1\nname = "{name}"\nviewing_distance_mm = 600\nborder_mm = 4\n{border}\n[panel]\n'
            f"width_px = {540 * fine}\nheight_px = {540 * fine}\npitch_mm = {PITCH_MM / fine}\n{layers}")


DISPLAY_FILES = {"paper": two_layers("two-layer-540", (-10, 10), 0), "effective": two_layers("effective-540", (-6, 14)),
                 "lens": two_layers("lens-540", (-10, 10), lens=True)}


def true_depth_options(depth):
    """Those of `lamella run` on hci_antinous; `depth`: given (from the centre view's true disparity) or estimate."""
    return ("--depth", depth, *PLACEMENT[:6], "--preview-positions", 1, "--preview-eyes", TRUE_DEPTH_EYES,
            "--preview-eye-pixel-mm", PITCH_MM)


def true_depth(bench, quality):
    """Antinous on displays: eyes from true and from estimated depth, both against direct rendering from true depth."""
    capture = bench.data / "lightfield/hci_antinous"

    def take(workspace):
        folders = {depth: workspace.parent / depth for depth in ("given", "estimate")}
        found = {}
        for display, text in DISPLAY_FILES.items():
            file = workspace.parent / "display.toml"
            file.write_text(text)
            found[display] = {"stages": {}, "psnr": {}}
            for depth, folder in folders.items():
                bench.run("run", capture, "--workspace", folder, "--display", file, "--quality", quality,
                          *true_depth_options(depth))
                found[display]["stages"][depth] = stages(folder)
                found[display]["psnr"][depth] = [
                    number(bench.run("compare", "images", folder / f"preview/views/eye_further_{i:02}.png",
                                     folders["given"] / f"preview/views/target_further_{i:02}.png", "--border", 24)[0], "mean")
                    for i in range(TRUE_DEPTH_EYES.count(";") + 1)]
        return found
    return take


def calibration_trials(bench, *options):
    """The twenty trials of scripts/calibration_loop.sh, two at a time, a line for each."""
    def take(workspace):
        half = TRIALS // 2
        loops = [subprocess.Popen([Path(__file__).parent / "calibration_loop.sh", "--program", bench.program, "--trials", str(half),
                                   "--first", str(FIRST_SEED + half * i), *options], stdout=subprocess.PIPE, text=True)
                 for i in range(2)]
        lines = [line for loop in loops for line in loop.communicate()[0].splitlines() if line.startswith("seed ")]
        if len(lines) != TRIALS:
            sys.exit(f"accuracy: {len(lines)} of {TRIALS} calibrations ended")
        return {"trials": [line.split(" ", 2)[2] for line in lines]}
    return take


def calibration_time(bench):
    """One trial's photographs, kept, and what the solve of all of them takes."""
    def take(workspace):
        seed = str(FIRST_SEED)
        # A calibration that is refused takes as long.
        subprocess.run([Path(__file__).parent / "calibration_loop.sh", seed, "--program", bench.program, "--out", workspace],
                       stdout=subprocess.DEVNULL, check=False)
        photos = workspace / seed / "taken/images"
        _, cost_ = bench.run("calibrate", "solve", workspace / seed / "patterns", photos, "--out", workspace / "again.json")
        return {"photographs": len(list(photos.iterdir())), **cost_}
    return take


def closed_loop(bench):
    """What eyes see beside the scene, of panels of full size: by the truth, then by photographs."""
    def take(workspace):
        done = subprocess.run([bench.program.parent / "tests/pipeline_test", "--gtest_filter=CalibratedDisplay.*"],
                              env={**os.environ, "LAMELLA_FULL_SIZE": "1"}, stdout=subprocess.PIPE, text=True, check=True)
        lines = [line for line in done.stdout.splitlines() if line.startswith("view error: ")]
        return {"known": lines[0], "photographs": lines[1]}
    return take


def take_calibration(bench):
    terms = {name: bench.measure("_".join(["calibration_trials", *options]).replace("--", ""),
                                 calibration_trials(bench, *options))
             for name, (options, _) in TERMS.items()}
    return {"terms": terms, "time": bench.measure("calibration_time", calibration_time(bench)),
            "closed_loop": bench.measure("closed_loop", closed_loop(bench))}


def take_true_depth(bench):
    return {q: bench.measure(f"true_depth_{q}", true_depth(bench, q)) for q in ("balanced", "best")}


def take_all(bench):
    antinous = bench.data / "lightfield/hci_antinous"
    room = bench.room()
    disparity = lambda workspace: {"depth": disparity_against(bench, workspace, antinous)}
    room_poses = lambda workspace: {"poses": poses_against(bench, workspace, room / "transforms.json")}
    results = {}
    for q in QUALITIES:
        for name, take in (
                ("fountain_poses", fountain_poses(bench, q)),
                ("antinous_views", antinous_views(bench, q)),
                ("fountain_views", left_out(bench, q)),
                ("room_depth", room_depth(bench, q)),
                ("antinous", chain(bench, antinous, "paper-two-layer", q, *PLACEMENT, also=disparity)),
                ("room", chain(bench, room / "images", "paper-two-layer", q, *SAME_PICTURES, also=room_poses))):
            results[name, q] = bench.measure(f"{name}_{q}", take)
    results["antinous_one"] = bench.measure("antinous_one", chain(bench, antinous, "paper-one-layer", "balanced",
                                                                  *PLACEMENT))
    results["sceaux"] = bench.measure("sceaux", chain(bench, bench.data / "handheld/sceaux_castle/images",
                                                      "paper-two-layer", "balanced"))
    results["true_depth"] = take_true_depth(bench)
    results["calibration"] = take_calibration(bench)
    results["trade"] = EXPERIMENTS.read_text()
    results["scenes"] = {name: bench.measure(f"scene_{name}", scene(bench, name, judged)) for name, judged in SCENES.items()}
    return results
