#!/usr/bin/env python3
"""Runs the measurements of docs/accuracy.md and writes the page; see scripts/accuracy.sh.

A measurement is a few commands of the program. Its figures are kept in RECORDS/NAME.json, with the day and the commit
that they are of, and taken from there the next time; its workspace goes as soon as they are.
"""
import argparse
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
         "spacers of index 1.55, not 1.49": (("--index", "1.55"), "index")}
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
                bench.run("run", capture, "--workspace", folder, "--display", file, "--quality", quality, "--depth", depth,
                          *PLACEMENT[:6], "--preview-positions", 1, "--preview-eyes", TRUE_DEPTH_EYES,
                          "--preview-eye-pixel-mm", PITCH_MM)
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


# ---- The page ----

def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def cost(of):
    return [f"{of['seconds']:.0f} s" if of["seconds"] >= 9.5 else f"{of['seconds']:.1f} s", f"{of['peak_mib']:.0f} MiB"]


def cost_of_run(result):
    """A process's own mark of its peak starts anew with every stage."""
    peak = max(stage["peak_mib"] for stage in result["stages"].values())
    return cost({"seconds": result["run"]["seconds"], "peak_mib": max(peak, result["run"]["peak_mib"])})


def stage_rows(result):
    return [[stage, *cost(record)] for stage, record in result["stages"].items()]


def eyes(result, key):
    """Mean over the captured views that stand at the eyes of the centre row, sRGB dB."""
    row = [v for v in result["captured"] if abs(v["position_mm"][1]) < 0.1]
    values = [v[key]["psnr_srgb_db"] for v in row]
    return sum(values) / len(values) if None not in values else float("inf")


def by_quality(results, name, heads, figures, costs):
    rows = [[q, *figures(results[name, q]), *costs(results[name, q])] for q in QUALITIES]
    return table(["quality", *heads, "time", "peak memory"], rows)


def true_depth_section(results):
    mean = lambda values: sum(values) / len(values)
    rows = []
    for display, q in ((display, q) for display in TRUE_DEPTH_DISPLAYS for q in results):
        r = results[q][display]
        given, estimated = r["psnr"]["given"], r["psnr"]["estimate"]
        rows.append([f"{TRUE_DEPTH_DISPLAYS[display]}, {q}", f"{mean(given):.2f} dB ({min(given):.2f} to {max(given):.2f})",
                     f"{mean(estimated):.2f} dB", f"{mean(given) - mean(estimated):+.2f} dB",
                     *cost(r["stages"]["given"]["layers"])])
    return """## A real light field with true depth

Antinous on ±20 mm (disparities -3.131 to 2.689, one view pixel one panel pixel), eyes at 0, ±32 and ±54 mm, border
24 px; `--depth given` takes the true disparity of the centre view and warps it to the other 80. All against direct
rendering from true depth, the mean over each eye pixel. Displays of 540x540 emitters per slot, layers at ±10 mm, borders
of 4 mm; by the effective plane layers stand at -6 and 14 mm with the border on z = 0. The lenses are 2 panel
pixels apart, 8x8 directions each with a barrier's steps between them. Time and memory are of the stage layers:

""" + table(["display and quality", "true depth (worst to best eye)", "estimated depth", "loss", "time", "peak memory"], rows)


def loop_part(record):
    trials = record["trials"]
    solved = [line for line in trials if not line.startswith("refused")]
    rows = []
    for key, (name, unit, bound) in LOOP_FIGURES.items():
        values = sorted(number(line, key) for line in solved) or [math.nan]
        rows.append([f"{name}, {unit}", f"{values[len(values) // 2]:.2g}", f"{values[-1]:.2g}", f"{bound:g}",
                     f"{sum(v <= bound for v in values)} of {len(values)}"])
    return f"""`scripts/calibration_loop.sh --trials {TRIALS} --first {FIRST_SEED}`: two barrier layers of two panels each, one seen in a mirror, misaligned at
random by up to 20 mm, 5° and 0.5 %, gaps of 3 to 10 mm of acrylic; virtual photographs of 5 megapixels from 12
positions, distorted, blurred by 1 px and noisy. {len(solved)} of {TRIALS} calibrations were written, {len(trials) - len(solved)} refused by the gates:

""" + table(["error against the truth", "median", "largest", "asked for", "within"], rows)


def time_part(record):
    seconds, memory = cost(record)
    return f"""`lamella calibrate solve` of {record["photographs"]} such photographs, from files to calibration and report, takes {seconds} and
{memory}."""


def terms_part(terms):
    rows = terms_rows(terms)
    return """Which parameters beyond poses, gaps and scales photographs ask for, of such prototypes that differ from their design
(the same seeds and photographs; calibrations in which each was freed, of those written):

""" + table(["what the design does not know", *TERM_GROUPS], rows)


def closed_loop_part(record):
    return """Frames made by a calibration, shown on a prototype of paper-two-layer's size that is 20 mm and 5° off, and looked at
from 5 new positions (`LAMELLA_FULL_SIZE=1 build/release/tests/pipeline_test --gtest_filter='CalibratedDisplay.*'`): RMS
of what is seen beside the scene, linear, white 1. The two prototypes differ; in the second the reference panel, which is
a calibration's world, is in its place:

""" + table(["panels known", "corrected", "uncorrected", "a homography per layer", "a homography per panel"],
            [closed_loop_row("exactly", record["known"]), closed_loop_row("from 12 positions", record["photographs"])])


def calibration_section(results):
    """Of what is on record."""
    terms = {name: record for name, record in results["terms"].items() if record}
    parts = ["## A prototype calibrated from photographs"]
    if "nothing" in terms:
        parts.append(loop_part(terms["nothing"]))
    if results["time"]:
        parts.append(time_part(results["time"]))
    if len(terms) > 1:
        parts.append(terms_part(terms))
    if results["closed_loop"]:
        parts.append(closed_loop_part(results["closed_loop"]))
    if len(parts) == 1:
        sys.exit("accuracy: nothing of this section is on record; leave --recorded out")
    return "\n\n".join(parts)


def terms_rows(terms):
    rows = []
    for name, record in terms.items():
        wanted = TERMS[name][1]
        solved = [line for line in record["trials"] if not line.startswith("refused")]
        freed = lambda group: sum(group in line.partition("freed ")[2].split(", ") for line in solved)
        counts = [f"{freed(group)} of {len(solved)}" for group in TERM_GROUPS]
        rows.append([name, *(f"**{count}**" if group == wanted else count for group, count in zip(TERM_GROUPS, counts))])
    return rows


def closed_loop_row(name, line):
    keys = ("corrected", "uncorrected", "a homography per layer", "per panel")
    return [name, *(f"{float(re.search(rf'(?:^|[: ]){key} ([0-9.]+)', line)[1]):.4f}" for key in keys)]


def trade_section(text):
    """Of the page of experiments, which scripts/experiments.sh writes: its curves and its table."""
    section = re.search(r"^## Speed for accuracy\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)[1]
    curves = re.findall(r"^!\[.*\]\(.*\)$", section, re.MULTILINE)
    ways = re.search(r"^\| way \|.*?(?=\n\n)", section, re.MULTILINE | re.DOTALL)[0]
    return """## Speed for accuracy of the layers

Rays a display ray, kernels and implementations of the prefilter against seconds and PSNR, presets marked, on a scene in
closed form (`scripts/experiments.sh trade`; its [set-up](experiments.md#speed-for-accuracy)):

""" + "\n\n".join([*curves, ways])


def page(results):
    cores = len(os.sched_getaffinity(0))
    of_stage = lambda stage: lambda r: cost(r["stages"][stage])
    text = f"""# Accuracy against time and memory

Written by `scripts/accuracy.sh`, not by hand: {cores} cores, no GPU, release build. Times are wall times of one run
each, so they are good to a tenth or so. PSNR is of 8-bit sRGB codes. The captures: *fountain* (fountain-P11, Strecha
et al. 2008, 11 photographs of 3072x2048), *sceaux* (11 photographs of 2832x2128), *antinous* (HCI 4D light field
benchmark, 9x9 views of 512x512), *room* (`lamella synth scene room`: 14 photographs of 960x720, exact truth).

## Poses of photographs

`lamella run PHOTOGRAPHS --until poses`, then `lamella compare poses`: camera centres after the best similarity.

Fountain, against surveyed poses (mm):

"""
    text += by_quality(results, "fountain_poses", ["registered", "RMSE", "largest", "rotation"], lambda r: [
        f"{r['poses']['views']:.0f} of 11", f"{1000 * r['poses']['rmse']:.2f} mm", f"{1000 * r['poses']['max']:.2f} mm",
        f"{r['poses']['rotation_deg']:.3f}°"],
        of_stage("poses"))
    text += "\n\nRoom, against exact poses (the things are 2.5 to 5.5 m away):\n\n"
    text += by_quality(results, "room", ["registered", "RMSE", "largest", "rotation"], lambda r: [
        f"{r['poses']['views']:.0f} of 14", f"{1000 * r['poses']['rmse']:.2f} mm", f"{1000 * r['poses']['max']:.2f} mm",
        f"{r['poses']['rotation_deg']:.3f}°"],
        of_stage("poses"))
    text += """

## Depth

Antinous, all 81 views; the centre view by the benchmark's rule (share of pixels that are off by more than so many
pixels of disparity, 15 px border). Time and memory are of all 81 maps:

"""
    text += by_quality(results, "antinous", ["BadPix(0.07)", "BadPix(0.03)", "BadPix(0.01)"], lambda r: [
        f"{r['depth']['badpix_0.07']:.2f} %", f"{r['depth']['badpix_0.03']:.2f} %", f"{r['depth']['badpix_0.01']:.2f} %"], of_stage("depth"))
    text += """

Room with its exact cameras, all 14 views against exact depth; errors are relative to the depth. Unknown pixels are
those that other views do not confirm; the last share counts them as wrong:

"""
    text += by_quality(results, "room_depth", ["known", "median error", "90 % below", "within 1 %", "of all pixels"],
                       lambda r: [f"{r['known']:.1f} %", f"{r['median']:.3f} %", f"{r['p90']:.2f} %",
                                  f"{r['within_1']:.1f} %", f"{r['within_1_of_all']:.1f} %"], of_stage("depth"))
    text += """

## Views that were left out

Antinous from nine of its views (rows and columns 0, 4, 8): the other 72 rendered, 15 px border. The time is of
rendering them; `depth` says what the nine maps took:

"""
    text += by_quality(results, "antinous_views", ["BadPix(0.07)", "PSNR", "depth"], lambda r: [
        f"{r['depth']['badpix_0.07']:.2f} %", f"{r['views']['psnr']:.2f} dB",
        cost(r["stages"]["depth"])[0]], lambda r: cost(r["views"]))
    text += """

Fountain with its surveyed cameras and without view 0005, which is then rendered at 1536x1024. *Seen*: pixels
that at least one photograph saw; the others carry a plausible guess. Time and memory are of the ten depth maps:

"""
    text += by_quality(results, "fountain_views", ["PSNR of seen", "seen", "PSNR of all"], lambda r: [
        f"{r['views']['seen_psnr']:.2f} dB", f"{r['views']['seen']:.1f} %",
        f"{r['views']['psnr']:.2f} dB"], of_stage("depth"))
    text += """

## The whole chain

Antinous, 81 views, on `paper-two-layer`: disparities -3.131 to 2.689 on ±20 mm, one view pixel one panel pixel on
z = 0, so that neighbouring cameras are eyes 27.15 mm apart. Means over the eyes at 0, ±27.15 and ±54.3 mm, border
24 px. *Direct* is the capture rendered at the eye without a display, the mean over each eye pixel; the captured views
there are among its inputs. Time and memory are of `lamella run`, all stages, the full panel of 1920x1080:

"""
    figures = lambda r: [f"{eyes(r, 'simulated_to_direct'):.2f} dB", f"{eyes(r, 'simulated_to_captured'):.2f} dB",
                         f"{eyes(r, 'direct_to_captured'):.2f} dB"]
    rows = [["two layers, " + q, *figures(results["antinous", q]), *cost_of_run(results["antinous", q])]
            for q in QUALITIES]
    rows.append(["one layer, balanced", *figures(results["antinous_one"]), *cost_of_run(results["antinous_one"])])
    text += table(["display and quality", "eye against direct", "eye against captured", "direct against captured",
                   "time", "peak memory"], rows)
    text += "\n\nRoom, photographs to page; eyes against direct rendering, mean of 7x7 within ±54.3 mm, seen pixels:\n\n"
    text += by_quality(results, "room", ["PSNR", "SSIM", "seen"], lambda r: [
        f"{r['mean']['psnr_srgb_seen_db']:.2f} dB", f"{r['mean']['ssim_seen']:.3f}", f"{100 * r['mean']['seen']:.1f} %"],
        cost_of_run)
    sceaux = results["sceaux"]
    text += f"""

Sceaux, photographs to page, balanced: {sceaux['stages']['poses']['summary']['registered']} registered,
{100 * sceaux['mean']['seen']:.1f} % of the eyes' pictures seen (sky and lawn have no texture, so no depth), of these
{sceaux['mean']['psnr_srgb_seen_db']:.1f} dB against direct rendering; the page has {sceaux['page_mib']:.1f} MiB.

{true_depth_section(results["true_depth"])}

{calibration_section(results["calibration"])}

{trade_section(results["trade"])}

## Time and peak memory of every stage

`balanced`. A stage's peak is that of the whole process (COLMAP's, where that is larger) while it runs.

"""
    for title, key in (("Sceaux", "sceaux"), ("Antinous, 81 views", ("antinous", "balanced")),
                       ("Room", ("room", "balanced"))):
        text += f"{title}:\n\n" + table(["stage", "time", "peak memory"], stage_rows(results[key])) + "\n\n"
    return text.rstrip() + "\n"


def summary(results):
    """README's table, balanced."""
    poses_, depth, views = (results[n, "balanced"] for n in ("fountain_poses", "antinous", "antinous_views"))
    fountain, eye, room = (results[n, "balanced"] for n in ("fountain_views", "antinous", "room"))
    rows = [
        ["camera positions, fountain-P11, 11 photographs", f"{1000 * poses_['poses']['rmse']:.1f} mm RMSE", *cost(poses_["stages"]["poses"])],
        ["depth, HCI antinous, 81 views", f"{depth['depth']['badpix_0.07']:.2f} % of pixels off by more than 0.07 px",
         *cost(depth["stages"]["depth"])],
        ["72 views from 9, HCI antinous (rendering them)", f"{views['views']['psnr']:.1f} dB", *cost(views["views"])],
        ["a photograph left out, fountain-P11 (rendering it)", f"{fountain['views']['seen_psnr']:.1f} dB of what others saw, "
         f"{fountain['views']['psnr']:.1f} dB of all", *cost(fountain["views"])],
        ["an eye in front of two layers, HCI antinous, ±20 mm", f"{eyes(eye, 'simulated_to_captured'):.1f} dB against the "
         f"captured view ({eyes(results['antinous_one'], 'simulated_to_captured'):.1f} dB with one layer)", *cost_of_run(eye)],
        ["from 14 photographs to the page, generated room", f"{room['mean']['psnr_srgb_seen_db']:.1f} dB", *cost_of_run(room)],
    ]
    return table(["what, `--quality balanced`", "accuracy", "time, 2 cores", "peak memory"], rows)


def scenes(results):
    """README's table of generated scenes."""
    def expected(of):
        if "poses" in of:
            return (f"{of['poses']['views']:.0f} of {of['views']} registered, centres within {1000 * of['poses']['max']:.2f} mm "
                    f"(cameras over {of['extent']:.2f} m)")
        if "depth" in of:
            return f"depth: median {of['depth']['median']:.2f} %, {of['depth']['within_1']:.1f} % of known within 1 %"
        return "contrast 0.8 sinc(1/period in px), held by a test; not a scene for depth"
    rows = [[name, of["description"], f"{of['views']} views, {of['width']}x{of['height']}", f"{of['synth']['seconds']:.0f}", expected(of)]
            for name, of in results["scenes"].items()]
    return table(["scene", "what it tests", "size", "seconds", "what to expect"], rows)


def written(text, name, content):
    """`text` with what stands between the marks of `name` replaced."""
    start, end = f"<!-- {name}: by scripts/accuracy.sh -->\n", f"<!-- {name} ends -->"
    if start not in text:
        sys.exit(f"accuracy: README has no mark {start.strip()}")
    before, rest = text.split(start)
    return before + start + content + "\n" + end + rest.split(end)[1]


def with_section(text, section):
    """The page with a section in the place of that of its heading, or before the stages' costs where there is none."""
    heading = section.partition("\n")[0]
    if f"\n{heading}\n" in text:
        return re.sub(rf"^{re.escape(heading)}\n.*?(?=^## |\Z)", lambda _: section + "\n\n", text, flags=re.MULTILINE | re.DOTALL)
    before, mark, after = text.partition("## Time and peak memory")
    return before + section + "\n\n" + mark + after


SECTIONS = {"true-depth": lambda bench: true_depth_section(take_true_depth(bench)),
            "calibration": lambda bench: calibration_section(take_calibration(bench)),
            "trade": lambda bench: trade_section(EXPERIMENTS.read_text())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("program", "data", "work", "records", "page", "readme"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("--only", choices=SECTIONS, help="measure and write one section of the page")
    parser.add_argument("--recorded", action="store_true", help="with --only: write what is on record, measure nothing")
    arguments = parser.parse_args()
    if arguments.recorded and not arguments.only:
        parser.error("--recorded is for one section: give --only")
    bench = Bench(arguments.program.resolve(), arguments.data.resolve(), arguments.work.resolve(),
                  arguments.records.resolve(), measures=not arguments.recorded)
    if arguments.only:
        section = SECTIONS[arguments.only](bench)
        arguments.page.write_text(with_section(arguments.page.read_text(), section))
        print(section)
        return
    results = take_all(bench)
    arguments.page.write_text(page(results))
    text = written(arguments.readme.read_text(), "accuracy", summary(results))
    arguments.readme.write_text(written(text, "scenes", scenes(results)))
    print(f"accuracy: wrote {arguments.page}")


if __name__ == "__main__":
    main()
