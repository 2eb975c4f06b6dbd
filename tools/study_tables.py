#!/usr/bin/env python3
"""Runs multireach-study, which it finds in PATH, for several arms, and prints tables of docs/ as Markdown.

Usage: study_tables.py tracking|throws|straightness|slow-joints

straightness and slow-joints need the arms of ../shared/robots.
"""
import json
import pathlib
import sys
import tempfile
import xml.etree.ElementTree

from markdown_tables import ROOT, head, output_of, print_chosen, row, section

OWN, SHARED = "robots", "../shared/robots"
ARMS = {"Hoap2": (f"{OWN}/hoap2/hoap2.urdf", "torso", "right_hand"),
        "Panda": (f"{SHARED}/panda.urdf", "panda_link0", "panda_hand"),
        "UR5": (f"{SHARED}/ur5_robot.urdf", "base_link", "ee_link"),
        "Kinova j2s6s200": (f"{SHARED}/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
        "Baxter, left": (f"{SHARED}/baxter.urdf", "base", "left_gripper"),
        "iiwa 14": (f"{SHARED}/iiwa14.urdf", "base", "iiwa_link_ee")}
TRACKING_ARMS = {"Panda": (f"{OWN}/panda/panda.urdf", "panda_link0", "panda_hand"), "Hoap2": ARMS["Hoap2"],
                 "UR5e": (f"{OWN}/ur5e/ur5e.urdf", "base_link", "tool0")}
LIFT = {"velocity": 0.013, "range": 0.31, "shorter range": 0.23}  # m/s, m: a slow torso lift


def study(arm, *options):
    """The JSON of one run."""
    urdf, base, tip = arm
    if not (ROOT / urdf).exists():
        sys.exit(f"study_tables.py: {urdf} is not here")
    return json.loads(output_of("multireach-study", *options, "--urdf", str(ROOT / urdf), "--base", base, "--tip", tip, "--json", "-"))


def mm(values):
    return [f"{1000 * values[p]:.1f}" for p in ("p50", "p95")]


def ms(values):
    return [f"{1000 * values[p]:.0f}" for p in ("p50", "p95")]


def tracking():
    results = {name: study(arm, "tracking", "--samples", "20", "--seed", "7") for name, arm in TRACKING_ARMS.items()}
    columns = ("arm", "path", "", "rms error, mm: p50", "p95", "largest error, mm: p50", "p95", "lag, ms: p50", "p95")
    for title, knows, paths in (("With the velocity", True, ("circle, 2 s", "figure 8, 2 s")), ("Positions only", False, ("circle, 2 s",)),
                                ("Too fast", True, ("circle, 0.5 s",))):
        section(title)
        head(*columns)
        for name, result in results.items():
            for each in result["rows"]:
                if each["path"] in paths and each["knows_velocity"] == knows:
                    row(f"{name}, {result['radius_m']:.3f} m", each["path"], each["tracker"], *mm(each["rms_m"]), *mm(each["max_m"]), *ms(each["lag_s"]))


def throws():
    head("arm", "noise, mm", "throws", "met within 30 mm", "a hand in time", "that sees the ball", "met of these", "closest of these, mm: p50", "p95")
    for name, arm in TRACKING_ARMS.items():
        for sigma in (0.0005, 0.003):
            result = study(arm, "throws", "--samples", "1000", "--seed", "9", "--sigma", str(sigma))
            seen, met = result["seen_in_time"], result["met_of_seen_in_time"]
            row(name, 1000 * sigma, result["throws"], result["met"], result["in_time"], seen, f"{met}, {100 * met / seen:.1f} %", *mm(result["closest_m"]))


def straightness():
    head("arm, targets", "reaches", "path of the hand", "arrived, %", "path p50", "p90", "p95", "p99", "settled, s: p50", "p95", "where DLS arrives: path p50", "p95")
    for name, arm in ARMS.items():
        space = name == "Hoap2"
        result = study(arm, "straightness", "--seed", "90", "--samples", "4000" if space else "1000", "--nodes", "4000")
        every, some = result["all"], result["where damped least squares arrives"]
        for key, shown in (("guarded", "guarded"), ("planned paths", "`path_work: 70`"), ("damped least squares", "DLS"),
                           ("upper bound of the optimum", "optimum ≤")):
            one = every[key]
            arrived = f"{100 * one['arrived'] / one['reaches']:.1f}" if "arrived" in one else "-"
            settled = [f"{one['settle_s'][p]:.2f}" if "settle_s" in one else "-" for p in ("p50", "p95")]
            row(f"{name}, {result['targets']}", one["reaches"], shown, arrived, *(f"{one['path_ratio'][p]:.3f}" for p in ("p50", "p90", "p95", "p99")),
                *settled, *(f"{some[key]['path_ratio'][p]:.3f}" for p in ("p50", "p95")))


def on_a_lift(arm, folder, range_m):
    """The arm with a slow vertical joint of some range below its base."""
    urdf, base, tip = arm
    tree = xml.etree.ElementTree.parse(ROOT / urdf)
    root = tree.getroot()
    children = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
    while base in children:  # the root of the tree
        base = children[base].find("parent").get("link")
    xml.etree.ElementTree.SubElement(root, "link", name="floor")
    joint = xml.etree.ElementTree.SubElement(root, "joint", name="lift", type="prismatic")
    for tag, attributes in (("parent", {"link": "floor"}), ("child", {"link": base}), ("axis", {"xyz": "0 0 1"}),
                            ("limit", {"lower": "0", "upper": str(range_m), "velocity": str(LIFT["velocity"]), "effort": "1000"})):
        xml.etree.ElementTree.SubElement(joint, tag, attributes)
    path = pathlib.Path(folder) / pathlib.Path(urdf).name
    tree.write(path)
    return str(path), "floor", tip


def slow_joints():
    options = ("--samples", "100000", "--targets", "postures")
    head("arm", "not arrived: equal weights", "by default", "by default, lift of " + str(LIFT["shorter range"]) + " m",
         "settled, s, p50: equal weights", "by default", "the arm alone")
    for name in ("Panda", "UR5", "iiwa 14"):
        with tempfile.TemporaryDirectory() as folder:
            lifted = on_a_lift(ARMS[name], folder, LIFT["range"])
            runs = [study(lifted, *options, "--joint-weights", "1"), study(lifted, *options), study(ARMS[name], *options)]
            shorter = study(on_a_lift(ARMS[name], folder, LIFT["shorter range"]), *options)["results"][0]
        equal, default, alone = (run["results"][0] for run in runs)
        row(name, equal["failures"], default["failures"], shorter["failures"], *(f"{each['settle_s']['p50']:.2f}" for each in (equal, default, alone)))


if __name__ == "__main__":
    print_chosen({"tracking": tracking, "throws": throws, "straightness": straightness, "slow-joints": slow_joints}, __doc__)
