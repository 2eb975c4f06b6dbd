#!/usr/bin/env python3
"""What calls of the Python module cost: the table of docs/python.md.

    PYTHONPATH=build/release/python /usr/bin/python3 bench/python_bench.py
"""
import pathlib
import time
import timeit

import numpy as np

import multireach

ROOT = pathlib.Path(__file__).resolve().parents[1]


def row(what, call, items=1):
    """The least processor time of 25 series, microseconds for each item: other load of the machine only adds to it."""
    number = max(1, int(0.03 / max(1e-7, timeit.timeit(call, timer=time.process_time, number=3) / 3)))
    best = min(timeit.repeat(call, timer=time.process_time, number=number, repeat=25)) / number
    print(f"| {what} | {1e6 * best / items:.3g} |")


arm = multireach.Chain.from_robot(ROOT / "robots/hoap2")
rng = np.random.default_rng(1)
thetas = rng.uniform(arm.sample_lower, arm.sample_upper, (10000, arm.size))
theta, target = thetas[0], np.array([0.1, -0.12, 0.1])
law = multireach.GuardedLaw(arm)
law.start([0.2, -0.3, -0.2, -0.9])
law.set_target(target)
ik = multireach.MultiStartIk(arm)
batch = multireach.GuardedBatch(arm, 1000)
batch.start(thetas[:1000], arm.position(thetas[1000:2000]))
log = multireach.Log(ROOT / "logs/reach.lcm")
pair = next(iter(log.events(["STEREO_IMAGES"])))
truth = next(iter(log.events(["TARGET_TRUTH"])))
left, right = multireach.images_of(pair.data)
vision = multireach.Vision(ROOT / "robots/hoap2/vision.yaml")
utime = [0]


def update():
    utime[0] += 33333
    vision.update(left, right, utime[0])


print("| call | µs |\n|---|---|")
row("`arm.size`: a call that does nothing", lambda: arm.size)
row("`arm.position(theta)`", lambda: arm.position(theta))
row("`arm.jacobian(theta)`", lambda: arm.jacobian(theta))
row("`arm.position(thetas)`, 10⁴ rows, for each row", lambda: arm.position(thetas), 10000)
row("`arm.jacobian(thetas)`, 10⁴ rows, for each row", lambda: arm.jacobian(thetas), 10000)
row("`ik.nearest(target, theta)`, closed form", lambda: ik.nearest(target, theta))
row("`law.step()`", law.step)
row("`law.run(140)`, for each step", lambda: law.run(140), 140)
row("`law.theta`", lambda: law.theta)
row("`batch.step()`, 1000 arms, for each arm", batch.step, 1000)
row("`vision.update(left, right, utime)`, 320 × 240", update)
row("`multireach.decode(bytes)`, `target_t`", lambda: multireach.decode(truth.data))
message = truth.message
row("`multireach.encode(message)`, `target_t`", lambda: multireach.encode(message))
events = sum(1 for _ in log)
row("`for event in log`, for each event", lambda: [None for _ in log], events)
row("`log.columns(\"TARGET_TRUTH\")`, for each message", lambda: log.columns("TARGET_TRUTH"), 756)
