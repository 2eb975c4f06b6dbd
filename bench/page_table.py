#!/usr/bin/env python3
"""Prints what bench/page.sh has measured as tables of docs/, in Markdown: page_table.py FOLDER FOUR_TIMES OPENED..."""
import csv
import json
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
from markdown_tables import head, row, section  # noqa: E402


def late_ticks(folder, marks):
    """Late ticks of each node between the marks, from NODE_STATUS."""
    newest, rows, counts = {}, [], {}
    with open(f"{folder}/csv/NODE_STATUS.csv", newline="") as file:
        for line in csv.DictReader(file):
            rows.append((int(line["log_utime"]), line["node"], int(line["late"])))
    for mark in marks:
        for utime, node, late in rows:
            if utime <= mark:
                newest[node] = late
        for node, late in newest.items():
            counts.setdefault(node, []).append(late)
    return {node: [after - before for before, after in zip(late, late[1:])] for node, late in counts.items() if len(late) == len(marks)}


def main():
    folder, marks, opened = sys.argv[1], [int(text) for text in sys.argv[2:6]], sys.argv[6:]
    with open(f"{folder}/frames.json") as file:
        frames = json.load(file)
    section("Frames")
    head("", "median of the seconds", "worst second")
    row("frames a second, of 25 that are sent", f"{statistics.median(frames['frames']):.1f}", f"{min(frames['frames']):.1f}")
    row("script a frame, ms", f"{statistics.median(frames['script']):.2f}", f"{max(frames['script']):.2f}")
    section("Late ticks")
    without, with_browser, again = ((after - before) / 1e6 for before, after in zip(marks, marks[1:]))
    head("node", f"{without:.0f} s without a browser", f"{with_browser:.0f} s with one", f"{again:.0f} s without it again")
    for node, late in sorted(late_ticks(folder, marks).items()):
        row(f"`{node}`", *late)
    section("A log of a million messages")
    head("opening", "reading the file, s", "served after, s", "shown after, s", "of which the browser's start, s")
    for number, text in enumerate(opened, 1):
        read_us, ready_us, more = text.split(",", 2)
        browser = json.loads("{" + more + "}")
        row(number, f"{int(read_us) / 1e6:.2f}", f"{int(ready_us) / 1e6:.2f}", f"{int(ready_us) / 1e6 + browser['shown_s']:.2f}", f"{browser['browser_s']:.2f}")


main()
