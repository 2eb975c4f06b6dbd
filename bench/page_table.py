#!/usr/bin/env python3
"""Prints what bench/page.sh has measured: page_table.py FOLDER FOUR_TIMES OPENED..."""
import csv
import json
import statistics
import sys


def late_ticks(folder, marks):
    """Late and all messages of each node between the marks, from NODE_STATUS."""
    newest = {}
    rows = []
    with open(f"{folder}/csv/NODE_STATUS.csv", newline="") as file:
        for row in csv.DictReader(file):
            rows.append((int(row["log_utime"]), row["node"], int(row["late"]), int(row["sent"])))
    counts = {}
    for mark in marks:
        for utime, node, late, sent in rows:
            if utime <= mark:
                newest[node] = (late, sent)
        for node, counters in newest.items():
            counts.setdefault(node, []).append(counters)
    return counts


def main():
    folder, marks, opened = sys.argv[1], [int(text) for text in sys.argv[2:6]], sys.argv[6:]
    with open(f"{folder}/frames.json") as file:
        frames = json.load(file)
    print(f"frames a second: median {statistics.median(frames['frames']):.1f}, least {min(frames['frames']):.1f}; "
          f"script a frame: median {statistics.median(frames['script']):.2f} ms, most {max(frames['script']):.2f} ms")
    lengths = [(after - before) / 1e6 for before, after in zip(marks, marks[1:])]
    print("late ticks in " + ", ".join(f"{length:.0f} s" for length in lengths) + ": without, with, without a browser")
    for node, counters in sorted(late_ticks(folder, marks).items()):
        if len(counters) == len(marks) and node != "page":
            print(f"  {node:12}" + ", ".join(str(after[0] - before[0]) for before, after in zip(counters, counters[1:])))
    for text in opened:
        read_us, ready_us, more = text.split(",", 2)
        browser = json.loads("{" + more + "}")
        print(f"a log of a million messages: plain read {int(read_us) / 1e6:.2f} s, served after {int(ready_us) / 1e6:.2f} s, "
              f"shown {browser['shown_s']:.2f} s after the browser was started (of which the browser {browser['browser_s']:.2f} s)")


main()
