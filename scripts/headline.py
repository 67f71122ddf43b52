#!/usr/bin/env python3
"""lamella's whole chain beside COLMAP's sparse one on the same photographs; see scripts/headline.sh.

Rounds alternate between the two, so that both meet the same load of the machine; the median counts.
"""
import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STAGES = ("capture", "poses", "depth", "layers", "frames", "preview")
PHOTOGRAPHS = (".jpg", ".jpeg", ".png", ".tif", ".tiff")
ENVIRONMENT = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}


def run(command):
    """Standard output, wall time and peak memory of a program and what it starts."""
    start = time.monotonic()
    with tempfile.TemporaryFile(mode="w+") as out:
        process = subprocess.Popen(list(map(str, command)), stdout=out, stderr=subprocess.STDOUT,
                                   stdin=subprocess.DEVNULL, env=ENVIRONMENT)
        _, status, usage = os.wait4(process.pid, 0)
        cost = {"seconds": time.monotonic() - start, "cpu": usage.ru_utime + usage.ru_stime,
                "peak_mib": usage.ru_maxrss / 1024}
        out.seek(0)
        text = out.read()
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"headline: failed: {' '.join(map(str, command))}\n{text[-2000:]}")
    return text, cost


def lamella(arguments, photographs, folder):
    """Stages, and the whole: with the program's start and what lies between stages."""
    workspace = folder / "W"
    _, whole = run([arguments.program, "run", photographs, "--workspace", workspace, "--display", "paper-two-layer",
                    "--quality", arguments.quality, "--threads", arguments.threads, "--quiet"])
    stages = {}
    for stage in STAGES:
        record = json.loads((workspace / stage / "stage.json").read_text())
        stages[stage] = {"seconds": record["seconds"], "peak_mib": record["peak_memory_mib"]}
    whole["peak_mib"] = max(whole["peak_mib"], *(stage["peak_mib"] for stage in stages.values()))
    return {"stages": stages, "whole": whole, "model": workspace / "poses/colmap"}


def colmap(arguments, photographs, folder):
    """COLMAP's defaults, on the processor."""
    database, sparse, threads = folder / "colmap.db", folder / "sparse", arguments.threads
    sparse.mkdir()
    stages = {}
    for stage, options in (
            ("feature_extractor", ["--database_path", database, "--image_path", photographs,
                                   "--SiftExtraction.use_gpu", 0, "--SiftExtraction.num_threads", threads]),
            ("exhaustive_matcher", ["--database_path", database, "--SiftMatching.use_gpu", 0,
                                    "--SiftMatching.num_threads", threads]),
            ("mapper", ["--database_path", database, "--image_path", photographs, "--output_path", sparse,
                        "--Mapper.num_threads", threads])):
        _, stages[stage] = run(["colmap", stage, *options])
    whole = {"seconds": sum(stage["seconds"] for stage in stages.values()),
             "cpu": sum(stage["cpu"] for stage in stages.values()),
             "peak_mib": max(stage["peak_mib"] for stage in stages.values())}
    return {"stages": stages, "whole": whole, "model": sparse / "0"}


def describe(model):
    """What COLMAP's own analyser says of a sparse model."""
    text, _ = run(["colmap", "model_analyzer", "--path", model])
    figure = lambda name: float(re.search(name + r": ([\d.]+)", text).group(1))
    return {"images": int(figure("Registered images")), "points": int(figure("Points")),
            "observations": int(figure("Observations")), "track": figure("Mean track length"),
            "error_px": figure("Mean reprojection error")}


def compare(arguments, mine, theirs):
    """How far the cameras of the two are apart, after the best similarity."""
    text_model = theirs.parent / "text"
    text_model.mkdir()
    run(["colmap", "model_converter", "--input_path", theirs, "--output_path", text_model, "--output_type", "TXT"])
    return run([arguments.program, "compare", "poses", mine, text_model])[0].strip()


def median(rounds):
    """Of the rounds' times; memory's largest."""
    def of(costs):
        costs = list(costs)
        times = {key: statistics.median(c[key] for c in costs) for key in ("seconds", "cpu") if key in costs[0]}
        return {**times, "peak_mib": max(c["peak_mib"] for c in costs)}
    stages = {stage: of(r["stages"][stage] for r in rounds) for stage in rounds[0]["stages"]}
    return {"stages": stages, "whole": of(r["whole"] for r in rounds)}


def rows(name, result):
    def row(stage, cost):
        processor = f"{cost['cpu']:9.1f}" if "cpu" in cost else " " * 9  # of lamella's stages: not recorded
        return f"{name + ' ' + stage:26}{cost['seconds']:9.1f}{processor}{cost['peak_mib']:10.0f}"
    return "\n".join(row(stage, cost) for stage, cost in (*result["stages"].items(), ("in all", result["whole"])))


def quality(name, model):
    return (f"{name:10}{model['images']:4} registered {model['points']:7} points {model['observations']:8} observations, "
            f"mean track {model['track']:.2f}, mean reprojection error {model['error_px']:.3f} px")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--photographs", type=Path, required=True)
    parser.add_argument("--quality", default="balanced")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--rounds", type=int, default=1)
    arguments = parser.parse_args()
    if shutil.which("colmap") is None:
        sys.exit("headline: COLMAP is not installed; install it with: sudo apt-get install colmap")
    files = sorted(f for f in arguments.photographs.resolve().glob("*") if f.suffix.lower() in PHOTOGRAPHS)
    if not files:
        sys.exit(f"headline: no photographs in {arguments.photographs}; name a folder with --photographs")
    mine, theirs = [], []
    with tempfile.TemporaryDirectory() as scratch:
        photographs = Path(scratch) / "photographs"  # nothing else is in there
        photographs.mkdir()
        for file in files:
            (photographs / file.name).symlink_to(file)
        for turn in range(arguments.rounds):
            folder = Path(scratch) / str(turn)
            folder.mkdir()
            print(f"round {turn + 1}: load {os.getloadavg()[0]:.2f} before lamella", end="", flush=True)
            mine.append(lamella(arguments, photographs, folder))
            print(f", {os.getloadavg()[0]:.2f} before COLMAP", end="", flush=True)
            theirs.append(colmap(arguments, photographs, folder))
            print(f", {os.getloadavg()[0]:.2f} at the end", flush=True)
        models = describe(mine[0]["model"]), describe(theirs[0]["model"])
        apart = compare(arguments, mine[0]["model"], theirs[0]["model"])
    ours, colmaps = median(mine), median(theirs)
    ratio = ours["whole"]["seconds"] / colmaps["whole"]["seconds"]
    print(f"\n{len(files)} photographs, {arguments.threads} threads, {arguments.quality}, {arguments.rounds} round(s)\n")
    print(f"{'':26}{'seconds':>9}{'of cores':>9}{'peak MiB':>10}")
    print(rows("lamella", ours), "", rows("COLMAP", colmaps), "", sep="\n")
    print(f"lamella / COLMAP: time {ratio:.2f} (of cores {ours['whole']['cpu'] / colmaps['whole']['cpu']:.2f}), "
          f"lamella's peak memory {ours['whole']['peak_mib']:.0f} MiB\n")
    print(quality("lamella", models[0]), quality("COLMAP", models[1]), "", "lamella's cameras against COLMAP's:", apart, sep="\n")


if __name__ == "__main__":
    main()
