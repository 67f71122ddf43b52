#!/usr/bin/env python3
"""Checks who may include whom.

The folders form a small ladder (docs/architecture.md): lightfield includes nobody; depth,
distribute, calibration and datasets_synthetic include only lightfield; pipeline includes all.
Heavy third-party headers stay out of our headers, so that including one of ours stays cheap.

    scripts/check_includes.py [ROOT]        exits 1 and lists the offending lines
    scripts/check_includes.py --self-test   proves that each rule catches its counter-example
"""

import pathlib
import re
import sys
import tempfile

STAGES = {"depth", "distribute", "calibration", "datasets_synthetic"}
MAY_INCLUDE = {"lightfield": set(), "pipeline": STAGES | {"lightfield"}}
MAY_INCLUDE.update({folder: {"lightfield"} for folder in STAGES})

HEAVY = re.compile(r"^(opencv2|ceres|embree\d|nlohmann|CLI|toml\+\+|hwy|OpenImageIO|sqlite3)\b")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def complaints(root):
    """Yields 'file:line: what is wrong' for the tree below root."""
    for folder in sorted(MAY_INCLUDE):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            yield from complaints_of_file(root, folder, path)


def complaints_of_file(root, folder, path):
    allowed = MAY_INCLUDE[folder] | {folder}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        match = INCLUDE.match(line)
        if not match:
            continue
        where = f"{path.relative_to(root)}:{number}"
        quote, name = match.groups()
        target = name.split("/")[0]
        if quote == '"' and target in MAY_INCLUDE and target not in allowed:
            yield f"{where}: {folder} must not include {target} ({name})"
        elif quote == '"' and "/" not in name and not name.startswith("hwy"):
            yield f"{where}: write the whole path from the top folder ({name})"
        elif quote == '"' and target == "tests":
            yield f"{where}: {folder} must not include tests ({name})"
        elif path.suffix == ".h" and not path.name.endswith("-inl.h") and HEAVY.match(name):
            yield f"{where}: {name} is heavy: include it in the .cc file only"


COUNTER_EXAMPLES = [
    ("lightfield/a.h", '#include "depth/b.h"', "lightfield must not include depth"),
    ("depth/a.cc", '#include "distribute/b.h"', "depth must not include distribute"),
    ("distribute/a.cc", '#  include "pipeline/b.h"', "distribute must not include pipeline"),
    ("calibration/x/a.cc", '#include "datasets_synthetic/b.h"', "calibration must not include"),
    ("depth/a.cc", '#include "b.h"', "write the whole path"),
    ("depth/a.cc", '#include "tests/reference/b.h"', "must not include tests"),
    ("depth/a.h", "#include <nlohmann/json.hpp>", "is heavy"),
]
EXAMPLES = [
    ("pipeline/a.cc", '#include "depth/b.h"'),
    ("depth/a.h", '#include "lightfield/b.h"'),
    ("depth/a.h", '#include "depth/b.h"'),
    ("depth/a.cc", "#include <nlohmann/json.hpp>"),
    ("depth/a.h", "#include <Eigen/Core>"),
]


def complaints_about(name, text):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / name
        path.parent.mkdir(parents=True)
        path.write_text(text + "\n", encoding="utf-8")
        return list(complaints(pathlib.Path(folder)))


def self_test():
    wrong = []
    for name, text, expected in COUNTER_EXAMPLES:
        found = complaints_about(name, text)
        if len(found) != 1 or expected not in found[0] or not found[0].startswith(f"{name}:1:"):
            wrong.append(f"{name} with {text}: expected '{expected}', found {found}")
    for name, text in EXAMPLES:
        found = complaints_about(name, text)
        if found:
            wrong.append(f"{name} with {text}: expected no complaint, found {found}")
    return wrong


def main(arguments):
    if arguments == ["--self-test"]:
        found = self_test()
    else:
        default = pathlib.Path(__file__).resolve().parent.parent
        root = pathlib.Path(arguments[0]) if arguments else default
        found = list(complaints(root))
    for line in found:
        print(line, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
