#!/usr/bin/env python3
"""Makes docs/experiments.md and its figures of what lamella_experiments measured; see
scripts/experiments.sh. Without --page it prints the rows."""
import argparse
import html
import json
import math
from pathlib import Path

COLORS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17768f", "#8c564b", "#e377c2")
WIDTH, HEIGHT = 640, 360
LEFT, RIGHT, TOP, BOTTOM = 64, 190, 34, 46


def number(value):
    """At most four digits that count."""
    if value is None:
        return ""
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.4g}"
        return text if "e" not in text else f"{value:.0f}"
    return f"{value:.2e}"


def ticks(low, high, most=6):
    """Round numbers from low to high."""
    step = 10 ** math.floor(math.log10((high - low) / most))
    for factor in (1, 2, 5, 10):
        if (high - low) / (factor * step) <= most:
            step *= factor
            break
    first = math.ceil(low / step - 1e-9)
    return [(first + i) * step for i in range(int((high - first * step) / step + 1e-9) + 1)]


class Plot:
    """Where numbers lie in the picture."""

    def __init__(self, curves):
        xs = [x for curve in curves for x in curve["x"]]
        ys = [y for curve in curves for y in curve["y"]]
        self.x = (min(xs), max(xs))
        low, high = min(ys + [0]), max(ys + [0])
        margin = 0.05 * ((high - low) or 1)
        self.y = (low - (margin if low < 0 else 0), high + margin)

    def at(self, x, y):
        u = (x - self.x[0]) / ((self.x[1] - self.x[0]) or 1)
        v = (y - self.y[0]) / (self.y[1] - self.y[0])
        return LEFT + u * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - v * (HEIGHT - TOP - BOTTOM)


def text(x, y, words, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{html.escape(words)}</text>'


def axes(plot, figure):
    parts = []
    for value in ticks(*plot.x):
        x, _ = plot.at(value, 0)
        parts.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" class="grid"/>')
        parts.append(text(x, HEIGHT - BOTTOM + 16, f"{value:g}"))
    for value in ticks(*plot.y):
        value = round(value, 12)
        _, y = plot.at(plot.x[0], value)
        parts.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" class="grid"/>')
        parts.append(text(LEFT - 6, y + 4, f"{value:g}", "end"))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    parts.append(text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 10, figure["x_label"]))
    parts.append(text(16, middle, figure["y_label"], extra=f' transform="rotate(-90 16 {middle:.0f})"'))
    parts.append(text(LEFT, 20, figure["title"], "start", ' font-weight="bold"'))
    return parts


def thinned(curve, most=160):
    """Points of the curve, of which there need not be more than pixels."""
    step = max(1, len(curve["x"]) // most)
    return list(zip(curve["x"], curve["y"]))[::step]


def svg(figure):
    """Measured curves full with their points, closed forms and second sets dashed."""
    plot = Plot(figure["curves"])
    parts = axes(plot, figure)
    colors = {}
    for i, curve in enumerate(figure["curves"]):
        color = colors.setdefault(curve["name"], COLORS[len(colors) % len(COLORS)])
        points = [plot.at(x, y) for x, y in thinned(curve)]
        dash = ' stroke-dasharray="5 4"' if curve["expected"] else ""
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="1.6"{dash}/>')
        if not curve["expected"] and len(points) <= 60:
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.4" fill="{color}"/>' for x, y in points]
    dashed = {c["name"] for c in figure["curves"] if c["expected"]}
    full = {c["name"] for c in figure["curves"] if not c["expected"]}
    for i, (name, color) in enumerate(colors.items()):
        y = TOP + 8 + 17 * i
        x = WIDTH - RIGHT + 12
        dash = ' stroke-dasharray="5 4"' if name not in full else ""
        parts.append(f'<path d="M{x} {y}h18" stroke="{color}" stroke-width="2"{dash}/>')
        parts.append(text(x + 24, y + 4, name, "start"))
    if dashed & full:
        parts.append(text(WIDTH - RIGHT + 12, HEIGHT - BOTTOM, "dashed: closed form", "start"))
    style = ("<style>text{font:11px sans-serif;fill:#222}.grid{stroke:#ddd;stroke-width:1}</style>"
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>')
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
            f'viewBox="0 0 {WIDTH} {HEIGHT}">{style}{"".join(parts)}</svg>\n')


def cell(words):
    """Words in a table of Markdown."""
    return words.replace("|", "\\|")


def expectation(row):
    if row["relation"] == "reported":
        return "reported"
    if row["relation"] == "near":
        tolerance = 100 * row["tolerance"]
        return number(row["expected"]) + (f" ± {tolerance:.2g} %" if tolerance >= 0.01 else " exactly")
    return {"at least": "≥ ", "at most": "≤ "}[row["relation"]] + number(row["expected"])


def verdict(experiment):
    asked = [row for row in experiment["rows"] if row["relation"] != "reported"]
    failed = [row for row in asked if not row["holds"]]
    if not asked:
        return "reported"
    return "holds" if not failed else f"**fails in {len(failed)} of {len(asked)}**"


def name_of(experiment):
    return "MTF" if experiment["id"] == "mtf" else f"Experiment {experiment['id']}"


def anchor(experiment):
    return name_of(experiment).lower().replace(" ", "-")


def section(experiment, figures):
    lines = [f"## {name_of(experiment)}", "", experiment["claim"], "", f"*Set-up.* {experiment['set_up']}", ""]
    lines += ["| measured | value | expected | |", "| --- | --- | --- | --- |"]
    for row in experiment["rows"]:
        mark = "" if row["relation"] == "reported" else "holds" if row["holds"] else "**fails**"
        lines.append(f"| {cell(row['what'])} | {number(row['measured'])} | {expectation(row)} | {mark} |")
    lines.append("")
    if experiment["reason"]:
        lines += [f"*Note.* {experiment['reason']}", ""]
    for figure, name in zip(experiment["figures"], figures):
        lines += [f"![{figure['title']}](figures/experiments/{name})", ""]
    for table in experiment["tables"]:
        lines += ["<details>", f"<summary>{table['title']}</summary>", "",
                  "| " + " | ".join(table["columns"]) + " |", "|" + " --- |" * len(table["columns"])]
        lines += ["| " + " | ".join(map(number, row)) + " |" for row in table["rows"]]
        lines += ["", "</details>", ""]
    return lines


def write_page(experiments, page, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.svg"):
        old.unlink()
    lines = ["# The paper's claims, measured", "",
             "What Ranieri et al. 2012 claim of multi-layered displays, and the MTF that their geometry "
             "gives, measured on what this program distributes to layers and on its simulated eye. "
             "`scripts/experiments.sh` measures everything anew and writes this page; a claim that "
             "comes out otherwise says so.", "",
             "Lengths are mm, frequencies cycles per mm, z is positive towards the viewer. Pinholes are "
             "those of `paper-two-layer` (period 6 px, openings of 2 px, 9 slots); lenses have the same "
             "lattice, field of view and sharp range.", "",
             "| | claim | verdict |", "| --- | --- | --- |"]
    for e in experiments:
        lines.append(f"| [{name_of(e)}](#{anchor(e)}) | {cell(e['claim'])} | {verdict(e)} |")
    lines.append("")
    for e in experiments:
        names = [f"{e['id']}{'' if i == 0 else chr(ord('a') + i)}.svg" for i in range(len(e["figures"]))]
        for figure, name in zip(e["figures"], names):
            (folder / name).write_text(svg(figure), encoding="utf-8")
        lines += section(e, names)
    page.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("json", type=Path)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--figures", type=Path)
    arguments = parser.parse_args()
    experiments = json.loads(arguments.json.read_text(encoding="utf-8"))
    if arguments.page:
        write_page(experiments, arguments.page, arguments.figures)
        return
    for e in experiments:
        print(f"{name_of(e)}: {verdict(e)}")
        for row in e["rows"]:
            mark = "" if row["holds"] else "  FAILS"
            print(f"  {row['what']}: {number(row['measured'])} ({expectation(row)}){mark}")


if __name__ == "__main__":
    main()
