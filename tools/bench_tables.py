#!/usr/bin/env python3
"""Runs programs, which it finds in PATH, and prints what they measure as tables of docs/, in Markdown.

Usage: bench_tables.py accuracy|vision-times|calibration|tags|moebius

calibration needs the Debian package opencv-doc, moebius the images of ../shared/data.
"""
import glob
import json
import pathlib
import sys
import tempfile

from markdown_tables import head, output_of, print_chosen, row, section

# The positions of the balls, and the walls behind them. No constant of vision was set on FRESH; many were set on the others.
FRESH = ("--seed", "960", "--walls", "401")
FAMILIAR = {"first": ("--seed", "101", "--walls", "1"), "second": ("--seed", "102", "--walls", "11")}


def accuracy_of(positions, *options):
    """The cases by their name."""
    said = output_of("multireach-bench-accuracy", "--positions", str(positions), *options, "--json", "-")
    return {case["name"]: case for case in json.loads(said[said.index("\n{"):])["cases"]}


def accuracy():
    # The mean of NEES/3 scatters by 0.04, the share inside by 1 %, of 95; by 0.13 and 3.4 % with 40 positions. One wall can
    # decide a row, hence the rooms.
    images = accuracy_of(480, *FRESH, "--rooms", "8", "--without", "motion")
    fresh = accuracy_of(40, *FRESH, "--only", "motion")  # rendering motion takes long
    familiar = {name: accuracy_of(40, *options, "--only", "motion") for name, options in FAMILIAR.items()}

    def errors(case):
        return [f"{case['median_mm']:.3f}", f"{case['rms_mm']:.3f}"]

    def covariance(case):
        return [f"{case['nees_per_dimension']:.2f}", f"{case['inside_95_percent']:.1f} %"]

    section("Images")
    head("case", "seen, of 480", "reported as occluded", "error, mm: median", "RMS", "goal of RMS", "NEES/3", "inside the 95 % ellipsoid")
    for case in images.values():
        row(case["name"], case["seen"], case["declared_occluded"], *errors(case), case["aim_rms_mm"] or "", *covariance(case))
    section("Motion")
    head("case", "set", "seen, of 40", "error, mm: median", "RMS", "NEES/3", "inside the 95 % ellipsoid")
    for name in fresh:
        for title, cases in {"no constant was set on it": fresh, **familiar}.items():
            row(name, title, cases[name]["seen"], *errors(cases[name]), *covariance(cases[name]))


def vision_times():
    said = output_of("multireach-bench-vision", "--benchmark_repetitions=12", "--benchmark_enable_random_interleaving=true",
                     "--benchmark_format=json")
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
    times("fitting the contour of the ball in both", "fit_contours/{}", "turbojpeg_pair/{}", "turbojpeg alone")
    times("message with these two JPEGs to `TARGET`, tracked", "pair_to_target/{}", "turbojpeg_pair/{}", "turbojpeg alone")
    times("the same, target lost before every pair", "pair_to_target_when_lost/{}", "turbojpeg_pair/{}", "turbojpeg alone")


def calibration():
    data = "/usr/share/doc/opencv-doc/examples/data"
    if not glob.glob(f"{data}/left*.jpg"):
        sys.exit("bench_tables.py: the chessboards of Debian's opencv-doc are not here")
    head("`--lens`", "pairs", "stereo RMS, px", "left-out corners, squares: median", "95 %", "max")
    for lens in ("radtan", "plumb_bob", "rational"):
        with tempfile.TemporaryDirectory() as folder:
            report = pathlib.Path(folder, "report.json")
            output_of("multireach-calibrate", "cameras", "--pattern", "9x6", "--square", "0.025", "--left", f"{data}/left[01]?.jpg",
                      "--right", f"{data}/right[01]?.jpg", "--lens", lens, "--leave-one-out", "--json", report, "-o", f"{folder}/cameras.yaml")
            found = json.loads(report.read_text())
        left_out = found["leave_one_out"]
        row(lens, found["pairs_used"], f"{found['stereo_rms_px']:.4f}", f"{left_out['median_squares']:.4f}", f"{left_out['p95_squares']:.4f}",
            f"{left_out['max_squares']:.3f}")


def print_rows_of_test(*tests):
    """The lines of tables that tests print."""
    said = output_of("multireach-table-tests", f"--gtest_filter={':'.join(tests)}")
    rows = [line for line in said.splitlines() if line.startswith("|")]
    if not rows:
        sys.exit(f"bench_tables.py: no table was printed by {', '.join(tests)}")
    print("\n".join(rows))


def tags():
    print_rows_of_test("TagAccuracy.OfRenderedTags", "TagAccuracy.FarAwayAnOrientationIsRightOrNotGiven")


def moebius():
    print_rows_of_test("Moebius.WhatIsLearnedFromARectangleIsWithinItsOwnRangeOfTrueDepth")


if __name__ == "__main__":
    print_chosen({"accuracy": accuracy, "vision-times": vision_times, "calibration": calibration, "tags": tags, "moebius": moebius}, __doc__)
