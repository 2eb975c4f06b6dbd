#!/usr/bin/env python3
"""An arm reaches for a position: the guarded law, step by step.

    examples/python/reach.py --robot robots/hoap2 --target 0.1 -0.12 0.1
"""
import argparse

import numpy as np

import multireach

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--robot", required=True, help="robot.yaml or its folder")
parser.add_argument("--target", type=float, nargs=3, required=True, help="position in W, m")
parser.add_argument("--seconds", type=float, default=3)
arguments = parser.parse_args()

arm = multireach.Chain.from_robot(arguments.robot)
law = multireach.GuardedLaw(arm)
law.start(arm.clamped(np.full(arm.size, -0.3)))
if law.set_target(arguments.target) == multireach.TargetResult.UNREACHABLE:
    print("unreachable: the arm goes as near as it can")
for tick in range(1, round(20 * arguments.seconds) + 1):
    law.step(7)  # 140 steps a second, 20 set-points a second
    print(f"{tick / 20:5.2f} s  theta", np.array2string(law.theta, precision=4, suppress_small=True), " hand",
          np.array2string(law.x, precision=4, suppress_small=True))
print(f"error {1000 * np.linalg.norm(law.x - arguments.target):.4f} mm")
