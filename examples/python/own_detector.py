#!/usr/bin/env python3
"""A detector of your own: finds the pink pixels of each image with NumPy, and publishes them as the target "mine".

    examples/python/own_detector.py --vision robots/hoap2/vision.yaml

The controller follows it with `target_name: mine` in robot.yaml. docs/vision.md has the rules for such a process.
"""
import argparse
import random
import statistics

import numpy as np

import multireach
from multireach.messages import target_t

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--vision", required=True, help="vision.yaml, of which the cameras are used")
parser.add_argument("--pairs", type=int, default=0, help="end after so many; 0: never")
arguments = parser.parse_args()

vision = multireach.Vision(arguments.vision)
bus = multireach.Bus()
run, seen, truth, errors = random.getrandbits(40) + 2, 0, {}, []


PINK = np.array([220, 40, 110])  # red, green, blue


def chroma(red, green, blue):
    luma = (red + 2 * green + blue) / 4 + 1
    return np.array([(red - green) / luma, (blue - green) / luma]), luma


def centre(image):
    """The centre (x, y), pixels, of the ball's colour; None where that is less than 30 pixels."""
    blue, green, red = np.moveaxis(image.astype(np.float32), 2, 0)
    colour, luma = chroma(red, green, blue)
    similar = np.hypot(*(colour - chroma(*PINK)[0][:, None, None])) < 0.55
    pixels = np.argwhere(similar & (luma > 12))[:, ::-1]
    if len(pixels) < 30:
        return None
    found = np.median(pixels, axis=0)
    for _ in range(3):  # leaves out what lies elsewhere
        found = pixels[np.linalg.norm(pixels - found, axis=1) < 20].mean(axis=0)
    return found


pairs = 0


def on_images(channel, message):
    global pairs, seen
    left, right = multireach.images_of(multireach.encode(message))
    target = target_t(name="mine", run=run, sequence=pairs, utime=message.utime, left_frame_utime=message.utime,
                      right_frame_utime=message.utime, pair_sequence=-1, last_seen_utime=-1, reason="nothing pink is seen")
    pairs += 1
    pixels = [centre(image) if image is not None else None for image in (left, right)]
    point = None if any(each is None for each in pixels) else vision.triangulate(*pixels, sigma_px=1)
    if point:
        seen += 1
        target.status, target.reason, target.last_seen_utime = target_t.STATUS_TRACKED, "seen", message.utime
        target.position_m, target.covariance_m2 = point
        if message.utime in truth:
            errors.append(1000 * float(np.linalg.norm(point[0] - truth[message.utime])))
    bus.publish("TARGET", target)


def on_truth(channel, message):
    truth[message.utime] = message.position_m


bus.subscribe("TARGET_TRUTH", on_truth)  # sent before its images, where they are rendered
bus.subscribe("STEREO_IMAGES", on_images)
try:
    while not arguments.pairs or pairs < arguments.pairs:
        bus.handle(timeout_s=1)
except KeyboardInterrupt:  # Ctrl-C
    pass
print(f"{seen} of {pairs} pairs" + (f", median error {statistics.median(errors):.2f} mm" if errors else ""))
