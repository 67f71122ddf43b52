#!/usr/bin/env python3
"""Makes docs/experiments.md and its figures of what lamella_experiments measured; see
scripts/experiments.sh. Without --page it prints the rows."""
import argparse
import html
import json
import math
from pathlib import Path

COLORS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17768f", "#8c564b", "#e377c2", "#111111", "#bcbd22")
WIDTH, HEIGHT = 680, 360
LEFT, TOP, BOTTOM = 64, 44, 46
LETTER = 6.4  # width of one, mean of the figures' font


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


def minus(words):
    """Numbers with a true minus sign."""
    return words.replace("-", "\u2212")


class Plot:
    """Where numbers lie in the picture."""

    def __init__(self, figure):
        curves = figure["curves"]
        self.log = figure["log_x"]
        self.right = WIDTH - 46 - LETTER * max(len(curve["name"]) for curve in curves)
        xs = [x for curve in curves for x in curve["x"]]
        ys = [y for curve in curves for y in curve["y"]]
        self.x = (min(xs), max(xs))
        low, high = min(ys), max(ys)
        if "dB" not in figure["y_label"] or abs(high) < 0.1 * (high - low):
            low, high = min(low, 0), max(high, 0)
        margin = 0.06 * ((high - low) or 1)
        self.y = (low - (margin if low else 0), high + margin)
        reach = {}
        for curve in curves:
            reach[curve["name"]] = max(curve["x"][-1], reach.get(curve["name"], -math.inf))
        self.ends = all(x > self.x[1] - 0.02 * (self.x[1] - self.x[0]) for x in reach.values())

    def along(self, x):
        return math.log(x) if self.log else x

    def at(self, x, y):
        low, high = self.along(self.x[0]), self.along(self.x[1])
        u = (self.along(x) - low) / ((high - low) or 1)
        v = (y - self.y[0]) / (self.y[1] - self.y[0])
        return LEFT + u * (self.right - LEFT), HEIGHT - BOTTOM - v * (HEIGHT - TOP - BOTTOM)


def text(x, y, words, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{html.escape(words)}</text>'


def axes(plot, figure):
    parts = []
    marks = ticks(*plot.x)
    if plot.log:
        marks = sorted({x for curve in figure["curves"] for x in curve["x"]})
        if len(marks) > 8:
            decades = range(math.floor(math.log10(plot.x[0])), math.ceil(math.log10(plot.x[1])) + 1)
            marks = [m * 10.0 ** k for k in decades for m in (1, 2, 5) if plot.x[0] <= m * 10.0 ** k <= plot.x[1]]
    for value in marks:
        x, _ = plot.at(value, 0)
        parts.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" class="grid"/>')
        parts.append(text(x, HEIGHT - BOTTOM + 16, minus(f"{round(value, 12):g}")))
    for value in ticks(*plot.y):
        value = round(value, 12)
        _, y = plot.at(plot.x[0], value)
        parts.append(f'<path d="M{LEFT} {y:.1f}H{plot.right:.1f}" class="grid"/>')
        parts.append(text(LEFT - 6, y + 4, minus(f"{value:g}"), "end"))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    parts.append(text((LEFT + plot.right) / 2, HEIGHT - 10, figure["x_label"]))
    parts.append(text(16, middle, figure["y_label"], extra=f' transform="rotate(-90 16 {middle:.0f})"'))
    parts.append(text(LEFT, 18, figure["title"], "start", ' class="title"'))
    return parts


def thinned(curve, most=140):
    """Points of the curve, of which there need not be more than pixels; means of neighbours."""
    step = max(1, len(curve["x"]) // most)
    points = list(zip(curve["x"], curve["y"]))
    groups = [points[i:i + step] for i in range(0, len(points), step)]
    return [(sum(x for x, _ in g) / len(g), sum(y for _, y in g) / len(g)) for g in groups]


def dotted(curve):
    return curve["stroke"] == "measured" and len(curve["x"]) <= 60


def spread(places, step=15):
    """The same order, at least a step apart, inside the picture."""
    order = sorted(range(len(places)), key=lambda i: places[i])
    spread_out = list(places)
    last = TOP + 4 - step
    for i in order:
        last = spread_out[i] = max(places[i], last + step)
    last = HEIGHT - BOTTOM + 4 + step
    for i in reversed(order):
        last = spread_out[i] = min(spread_out[i], last - step)
    return spread_out


def legend(plot, figure, colors, joined):
    """Names beside the ends of their curves, or below each other where curves end elsewhere."""
    named = {}
    for curve in figure["curves"]:
        named.setdefault(curve["name"], []).append(curve)
    places = []
    for i, curves in enumerate(named.values()):
        last = max(((curve["x"][-1], curve["y"][-1]) for curve in curves), key=lambda end: end[0])
        places.append(plot.at(*last)[1] if plot.ends else TOP + 8 + 17 * i)
    parts = []
    x = plot.right + 10
    for y, (name, curves) in zip(spread(places), named.items()):
        color = colors[name]
        strokes = {curve["stroke"] for curve in curves}
        if strokes != {"measured"} or name in joined:
            dash = ' stroke-dasharray="5 4"' if "second" in strokes else ""
            width = 1 if "closed form" in strokes else 2
            parts.append(f'<path d="M{x:.1f} {y:.1f}h18" stroke="{color}" stroke-width="{width}"{dash}/>')
        if any(dotted(curve) for curve in curves):
            parts.append(f'<circle cx="{x + 9:.1f}" cy="{y:.1f}" r="2.6" fill="{color}"/>')
        parts.append(text(x + 23, y + 4, minus(name) if "= -" in name else name, "start"))
    strokes = {curve["stroke"] for curve in figure["curves"]}
    if {"measured", "closed form"} <= strokes:
        parts.append(text(LEFT, 34, "points: measured; thin lines: closed form", "start", ' class="note"'))
    return parts


def peak_names(plot, figure):
    """What tells curves apart, above their peaks, where they are short; single points in full."""
    parts = []
    for curve in figure["curves"]:
        if len(curve["x"]) == 1:
            at_x, at_y = plot.at(curve["x"][0], curve["y"][0])
            end = max(at_x, LEFT + 4 + LETTER * len(curve["name"]))
            parts.append(text(end, at_y - 9, curve["name"], "end"))
            continue
        if plot.log or curve["stroke"] != "measured":
            continue
        if curve["x"][-1] - curve["x"][0] < 0.3 * (plot.x[1] - plot.x[0]):
            y = max(curve["y"])
            at_x, at_y = plot.at(curve["x"][curve["y"].index(y)], y)
            parts.append(text(at_x, at_y - 6, minus(curve["name"].split(", ")[-1])))
    return parts


def svg(figure):
    """Points are measured; thin lines are closed forms; dashed curves are a second set of measurements."""
    plot = Plot(figure)
    parts = axes(plot, figure)
    colors, joined = {}, set()
    for curve in figure["curves"]:
        key = curve["color_of"] or curve["name"]
        color = colors.setdefault(key, COLORS[len(set(colors.values())) % len(COLORS)])
        colors[curve["name"]] = color
    closed = {c["name"] for c in figure["curves"] if c["stroke"] == "closed form"}
    for curve in figure["curves"]:
        color = colors[curve["name"]]
        points = [plot.at(x, y) for x, y in thinned(curve)]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        if curve["stroke"] != "measured" or curve["name"] not in closed:
            dash = ' stroke-dasharray="5 4"' if curve["stroke"] == "second" else ""
            width = 1 if curve["stroke"] == "closed form" else 1.6
            parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="{width}"{dash}/>')
            joined.add(curve["name"])
        if dotted(curve):
            radius = 5 if len(points) == 1 else 2.6
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{color}"/>' for x, y in points]
    if not plot.ends:
        parts += peak_names(plot, figure)
    parts += legend(plot, figure, colors, joined)
    style = ("<style>text{font:11px sans-serif;fill:#222}.title{font-weight:bold}.note{fill:#666}"
             ".grid{stroke:#ddd;stroke-width:1}</style>"
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


def closeness(row):
    """0 far from the limit, 1 at it, more beyond."""
    measured, expected = row["measured"], row["expected"]
    if row["relation"] == "near":
        return abs(measured - expected) / (row["tolerance"] * abs(expected))
    if row["relation"] == "at least":
        measured, expected = expected, measured
    if expected < 0:
        measured, expected = -expected, -measured
    return measured / expected if expected else math.inf * (measured > 0)


def closest(experiment):
    """The row that is nearest to its limit, or beyond it: value and expectation."""
    rows = [row for row in experiment["rows"] if row["relation"] != "reported"]
    if not rows:
        return "see below", ""
    row = max(rows, key=closeness)
    return f"{cell(row['what'])}: {number(row['measured'])}", expectation(row)


def name_of(experiment):
    return {"mtf": "MTF", "trade": "Speed for accuracy"}.get(experiment["id"], f"Experiment {experiment['id']}")


def anchor(experiment):
    return name_of(experiment).lower().replace(" ", "-")


def section(experiment, figures):
    lines = [f"## {name_of(experiment)}", "", experiment["claim"], "", f"*Set-up.* {experiment['set_up']}", "",
             f"*Again:* `scripts/experiments.sh {experiment['id']}`", ""]
    lines += ["| measured | value | expected | |", "| --- | --- | --- | --- |"]
    for row in experiment["rows"]:
        mark = "" if row["relation"] == "reported" else "holds" if row["holds"] else "**fails**"
        lines.append(f"| {cell(row['what'])} | {number(row['measured'])} | {expectation(row)} | {mark} |")
    lines.append("")
    if experiment["reason"]:
        lines += [f"*Note.* {experiment['reason']}", ""]
    for figure, name in zip(experiment["figures"], figures):
        lines += [f"![{figure['title']}](experiments/{name})", ""]
    for table in experiment["tables"]:
        lines += ["<details>", f"<summary>{table['title']}</summary>", "",
                  "| " + " | ".join(table["columns"]) + " |", "|" + " --- |" * len(table["columns"])]
        names = [[name] for name in table["names"]] or [[]] * len(table["rows"])
        lines += ["| " + " | ".join(name + [number(value) for value in row]) + " |"
                  for name, row in zip(names, table["rows"])]
        lines += ["", "</details>", ""]
    return lines


def write_page(experiments, page, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.svg"):
        old.unlink()
    lines = ["# The paper's claims, measured", "",
             "What Ranieri et al. 2012 claim of multi-layered displays, and the MTF that their geometry "
             "gives, measured on what this program distributes to layers and on its simulated eye. "
             "`scripts/experiments.sh` measures everything anew and writes this page; "
             "`scripts/experiments.sh ID` measures one experiment and prints it. A claim that comes out "
             "otherwise says so. Numbers are those of the list of claims that the program was built to; 13, the "
             "limit of as many layers as views, is not among them.", "",
             "Lengths are mm, frequencies cycles per mm, z is positive towards the viewer. Pinholes are "
             "those of `paper-two-layer` (period 6 px, openings of 2 px, 9 slots); lenses have the same "
             "lattice, field of view and sharp range. The table shows, of each experiment, the "
             "measurement that is nearest to its limit.", "",
             "| | claim | measured | expected | verdict | command |", "| --- | --- | --- | --- | --- | --- |"]
    for e in experiments:
        measured, expected = closest(e)
        lines.append(f"| [{name_of(e)}](#{anchor(e)}) | {cell(e['claim'])} | {measured} | {expected} | "
                     f"{verdict(e)} | `scripts/experiments.sh {e['id']}` |")
    lines.append("")
    for e in experiments:
        names = [f"{e['id']}{'' if i == 0 else chr(ord('a') + i)}.svg" for i in range(len(e["figures"]))]
        for figure, name in zip(e["figures"], names):
            (folder / name).write_text(svg(figure), encoding="utf-8")
        lines += section(e, names)
    words = "\n".join(lines).rstrip() + "\n"
    page.write_text(words.replace("+-", "±").replace("<= ", "≤ "), encoding="utf-8")


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
