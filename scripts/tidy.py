#!/usr/bin/env python3
"""clang-tidy on some source files, ten of a target in one unit: most of its time goes into headers.

    scripts/tidy.py BUILD FILE...     BUILD: a build tree of the preset `files`, configured

Prints what clang-tidy finds; exits 1 where that is anything.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

FILES_PER_UNIT = 10


def units(build, files):
    """(name, compiler's options, files) of every unit; files with kernels for Highway stand alone."""
    commands = {entry["file"]: entry for entry in json.loads((build / "compile_commands.json").read_text())}
    targets = collections.defaultdict(list)
    for file in files:
        if str(file) not in commands:
            print(f"tidy: {file} is in no target of {build}, left out")
            continue
        words = shlex.split(commands[str(file)]["command"])
        target = re.match(r"(.*)\.dir/", words[words.index("-o") + 1]).group(1)
        alone = file.name if "foreach_target" in file.read_text() else ""
        options = [word for word in words if re.match(r"-(D|I|std=)", word)]
        for at, word in enumerate(words):
            if word == "-isystem":
                options += words[at:at + 2]
        targets[target.replace("/", "_") + alone].append((file, options))
    for name, members in sorted(targets.items(), key=lambda target: -len(target[1])):
        for first in range(0, len(members), FILES_PER_UNIT):
            batch = members[first:first + FILES_PER_UNIT]
            yield f"{name}_{first}", batch[0][1], [file for file, _ in batch]


def tidy(folder, name, options, files):
    unit = folder / f"{name}.cc"
    unit.write_text("".join(f'#include "{file}"  // NOLINT(bugprone-suspicious-include)\n' for file in files))
    result = subprocess.run(
        ["clang-tidy", "--quiet", str(unit), "--", *options, "-Wno-everything"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    build = pathlib.Path(sys.argv[1]).resolve()
    files = [pathlib.Path(file).resolve() for file in sys.argv[2:]]
    folder = build / "tidy"
    folder.mkdir(exist_ok=True)
    (folder / ".clang-tidy").write_text(pathlib.Path(".clang-tidy").read_text())
    failed = False
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for code, text in pool.map(lambda unit: tidy(folder, *unit), list(units(build, files))):
            if code != 0:
                failed = True
                print(text, end="", flush=True)
    sys.exit(1 if failed else 0)


main()
