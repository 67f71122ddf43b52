#!/usr/bin/env python3
"""Runs the measurements of docs/accuracy.md and writes the page; see scripts/accuracy.sh.

What is measured is in accuracy_measurements.py, how it is written here.
"""
import argparse
import math
import os
import re
import sys
from pathlib import Path

from accuracy_measurements import (EXPERIMENTS, FIRST_SEED, LOOP_FIGURES, QUALITIES, TERMS, TERM_GROUPS, TRIALS,
                                   TRUE_DEPTH_DISPLAYS, Bench, number, take_all, take_calibration, take_true_depth)


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
