#!/usr/bin/env python3
"""Replays a session with several weights gamma of the hand's attractor, and compares what the hand does.

    examples/python/parameter_sweep.py logs/reach.lcm --robot robots/hoap2 --gamma 60 180 350
"""
import argparse
import json
import pathlib
import re
import shutil
import tempfile

import numpy as np

import multireach

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("session", help="recorded log with images or targets")
parser.add_argument("--robot", required=True, help="folder of the robot, with robot.yaml and vision.yaml")
parser.add_argument("--gamma", type=float, nargs="+", default=[60, 180, 350], help="rad^2/m^2")
parser.add_argument("--until", type=float, default=1e9, help="s, end of the replay")
parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
arguments = parser.parse_args()


def replayed(gamma, folder):
    """One row: the session replayed with this gamma."""
    shutil.copytree(arguments.robot, folder / "robot")
    file = folder / "robot/robot.yaml"
    text = re.sub(r"^\s*gamma_rad2_m2:.*\n", "", file.read_text(), flags=re.MULTILINE)
    file.write_text(text.replace("controller:\n", f"controller:\n  gamma_rad2_m2: {gamma}\n"))
    multireach.replay(arguments.session, folder / "robot", output=folder / "out.lcm", until_s=arguments.until, threads=2)
    report = multireach.report(folder / "out.lcm", folder / "robot")
    hand = multireach.Log(folder / "out.lcm").columns("CONTROLLER_STATE", ["utime", "hand_position_m"])
    settled = [reach["settle_s"] for reach in report["reaches"] if reach.get("settle_s") is not None]
    path = np.linalg.norm(np.diff(hand["hand_position_m"], axis=0), axis=1).sum()
    return {"gamma_rad2_m2": gamma, "reached": len(settled), "mean_settle_s": float(np.mean(settled)) if settled else None, "path_m": float(path)}


rows = []
for gamma in arguments.gamma:
    with tempfile.TemporaryDirectory() as folder:
        rows.append(replayed(gamma, pathlib.Path(folder)))
if arguments.json:
    print(json.dumps(rows))
else:
    for row in rows:
        print("  ".join(f"{key} {value:.4g}" for key, value in row.items()))
