#!/usr/bin/env python3
"""Compares three ways to solve the inverse kinematics: the nearest solution, the first one, and plain damped Newton steps.

    examples/python/ik_comparison.py --robot robots/hoap2
"""
import argparse
import time

import numpy as np

import multireach

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--robot", required=True, help="robot.yaml or its folder")
parser.add_argument("--targets", type=int, default=200)
parser.add_argument("--seed", type=int, default=1)
arguments = parser.parse_args()

arm = multireach.Chain.from_robot(arguments.robot)
ik = multireach.MultiStartIk(arm)
rng = np.random.default_rng(arguments.seed)
starts, goals = rng.uniform(arm.sample_lower, arm.sample_upper, (2, arguments.targets, arm.size))
targets = arm.position(goals)


def newton(target, theta):
    """Damped steps from one start, clamped to the limits."""
    for _ in range(100):
        error = target - arm.position(theta)
        if np.linalg.norm(error) < 1e-6:
            break
        jacobian = arm.jacobian(theta)
        theta = arm.clamped(theta + jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-6 * np.eye(3), error))
    return theta


print(f"{'method':<10}{'solved %':>10}{'distance':>10}{'ms each':>10}")
for name, solve in {"nearest": lambda target, start: ik.best(target, start)[0], "first": lambda target, start: ik.first(target, start)[0],
                    "newton": newton}.items():
    begin = time.perf_counter()
    solutions = np.array([solve(target, start) for target, start in zip(targets, starts)])
    took = time.perf_counter() - begin
    solved = np.linalg.norm(arm.position(solutions) - targets, axis=1) < 1e-5
    distance = np.linalg.norm(solutions - starts, axis=1)[solved].mean()
    print(f"{name:<10}{100 * solved.mean():>10.1f}{distance:>10.3f}{1000 * took / len(targets):>10.3f}")
