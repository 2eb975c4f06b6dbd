#!/usr/bin/env python3
"""Runs a benchmark of vision, which it finds in PATH, and prints its table of docs/ as Markdown.

Usage: bench_tables.py accuracy|vision-times
"""
import json
import subprocess
import sys


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"bench_tables.py: failed: {' '.join(command)}")
    return done.stdout


def head(*columns):
    print("| " + " | ".join(columns) + " |\n" + "|---" * len(columns) + "|")


def row(*cells):
    print("| " + " | ".join(map(str, cells)) + " |")


def accuracy():
    said = run("multireach-bench-accuracy", "--positions", "40", "--seed", "909", "--walls", "191", "--json", "-")
    report = json.loads(said[said.index("\n{"):])
    head("case", "seen, of 40", "reported as occluded", "error, mm: median", "RMS", "goal of RMS", "NEES/3; 1 for a consistent covariance", "inside of 95 %")
    for case in report["cases"]:
        row(case["name"], case["seen"], case["declared_occluded"], f"{case['median_mm']:.3f}", f"{case['rms_mm']:.3f}", case["aim_rms_mm"] or "",
            f"{case['nees_per_dimension']:.2f}", f"{case['inside_95_percent']:.0f} %")
    row("all", "", "", "", "", "", f"{report['nees_per_dimension']:.2f}", "")


def vision_times():
    said = run("multireach-bench-vision", "--benchmark_repetitions=12", "--benchmark_enable_random_interleaving=true", "--benchmark_format=json")
    best = {}
    for each in json.loads(said)["benchmarks"]:
        if each["run_type"] == "iteration":
            best[each["run_name"]] = min(best.get(each["run_name"], float("inf")), each["cpu_time"])
    sizes = ("640x480", "1920x1080")
    head("what", *(f"{size.replace('x', '×')}, µs" for size in sizes))

    def times(what, name, beside=None, of=""):
        if f"{name.format(sizes[0])}" in best:
            row(what, *(f"{best[name.format(size)]:.0f}" +
                        (f" ({best[name.format(size)] / best[beside.format(size)]:.2f} × {of})" if beside else "") for size in sizes))

    for name, shown in (("AVX3", "AVX-512"), ("AVX2", "AVX2"), ("SSE4", "SSE4")):
        times(f"find, {shown}", f"find/{{}}/{name}", "opencv_find/{}", "OpenCV")
    times("find in a quarter-size window", "find_in_window/{}")
    times("OpenCV: HSV, inRange, open, findContours", "opencv_find/{}")
    times("turbojpeg alone: decode two JPEGs (q 90)", "turbojpeg_pair/{}")
    times("message with these two JPEGs to `TARGET`, tracked", "pair_to_target/{}", "turbojpeg_pair/{}", "turbojpeg alone")
    times("the same, target lost before every pair", "pair_to_target_when_lost/{}", "turbojpeg_pair/{}", "turbojpeg alone")


TABLES = {"accuracy": accuracy, "vision-times": vision_times}
if __name__ == "__main__":
    if sys.argv[1:] in (["--help"], ["-h"]):
        print(__doc__.strip())
    elif len(sys.argv) == 2 and sys.argv[1] in TABLES:
        TABLES[sys.argv[1]]()
    else:
        sys.exit("bench_tables.py: expected one of: " + ", ".join(TABLES))
