"""The sets `basketball-*`: pairs of images of a basketball in a hand, from two cameras 14 cm apart that are not synchronised.

The calibration is the owner's, and so are the boxes around the ball, which a neural network found. Near a box, the label
is the projected centre of the sphere whose contour fits the edges; no learned colour and no constant of vision is used.
"""
import io
import json

import cv2
import numpy as np

from clone import decode, new_folder, rig_lines

WIDTH, HEIGHT = 2304, 1296
RADIUS_M = 0.12
DIRECTIONS = 360  # in which an edge is looked for, from the middle of a box
LEAST_COVERED = 0.5  # of the directions around the centre, those with an edge on the contour
SEED = 1
# First and last pair of each set, and its use.
PARTS = {"indoors": (1, 83, "tuning"), "dark": (87, 105, "tuning"), "outdoors": (137, 216, "test")}
# Pairs whose label was seen to be beside the ball's contour in one image: it is blurred, or half of it is occluded.
WRONG = (57, 142, 159, 160, 161, 162, 183, 186)


class Camera:
    """One side of the owner's calibration: of the camera, and of the rectified images in which the boxes are."""

    def __init__(self, calibration, number, letter):
        self.matrix, self.distortion = calibration[f"mtx_{letter}"], calibration[f"dist_{letter}"].ravel()
        self.rotation, self.projection = calibration[f"R{number}"], calibration[f"P{number}"]

    def rays(self, pixels):
        at = cv2.undistortPoints(pixels.reshape(-1, 1, 2).astype(float), self.matrix, self.distortion).reshape(-1, 2)
        rays = np.c_[at, np.ones(len(at))]
        return rays / np.linalg.norm(rays, axis=1, keepdims=True)

    def pixels(self, rays):
        zero = np.zeros(3)
        return cv2.projectPoints(rays.reshape(-1, 1, 3), zero, zero, self.matrix, self.distortion)[0].reshape(-1, 2)

    def ellipse_in(self, box):
        """The ellipse in a box of the rectified image, as pixels of the camera's."""
        angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
        x = box["x"] + box["w"] * (0.5 + 0.5 * np.cos(angle))
        y = box["y"] + box["h"] * (0.5 + 0.5 * np.sin(angle))
        p = self.projection
        rectified = np.c_[(x - p[0, 2]) / p[0, 0], (y - p[1, 2]) / p[1, 1], np.ones(len(x))]
        return self.pixels(rectified @ self.rotation)


def edges(image, centre, size):
    """Strong edges of lightness or colour along lines from the centre, 0.7 to 1.35 sizes away."""
    blur = max(1.0, size / 60)
    lab = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_BGR2LAB).astype(np.float32), (0, 0), blur)
    step = max(2, round(2 * blur))
    found = []
    for angle in np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False):
        line = centre + np.arange(0.7 * size, 1.35 * size, 0.5)[:, None] * [np.cos(angle), np.sin(angle)]
        if line.min() < 2 or (line[:, 0] > WIDTH - 3).any() or (line[:, 1] > HEIGHT - 3).any():
            continue
        x, y = line.astype(np.float32).T
        along = cv2.remap(lab, x[:, None].copy(), y[:, None].copy(), cv2.INTER_LINEAR)[:, 0]
        change = np.linalg.norm(along[2 * step :] - along[: -2 * step], axis=1)
        highest = (change[1:-1] >= change[:-2]) & (change[1:-1] > change[2:]) & (change[1:-1] > 12)
        found.append(line[np.nonzero(highest)[0] + 1 + step])
    return np.concatenate(found) if found else np.empty((0, 2))


def sphere(camera, image, start, random):
    """Projected centre (px), angular radius (rad) and covered share of the sphere with the best contour near `start`, an
    ellipse (px)."""
    centre = start.mean(axis=0)
    size = np.sqrt(2 * np.mean((start - centre) ** 2))
    points = edges(image, centre, size)
    if len(points) < 60:
        return None
    rays = camera.rays(points)
    angle = size / camera.matrix[0, 0]
    middle = camera.rays(centre)[0]
    tolerance = 1.5 * max(1.0, size / 100) / camera.matrix[0, 0]
    sectors = ((np.arctan2(*(points - centre).T[::-1]) + np.pi) / (2 * np.pi) * 72).astype(int) % 72

    def on_contour(axis, radius):
        return abs(np.arccos(np.clip(rays @ axis, -1, 1)) - radius) < tolerance

    def cone(chosen):  # around an axis: ray . axis = cos(radius)
        scaled = np.linalg.lstsq(rays[chosen], np.ones(len(rays[chosen])), rcond=None)[0]
        length = np.linalg.norm(scaled)
        return (scaled / length, np.arccos(1 / length)) if length > 1 else None

    best = None
    for _ in range(3000):
        found = cone(random.choice(len(rays), 3, replace=False))
        if not found or not 0.75 * angle < found[1] < 1.3 * angle or middle @ found[0] < np.cos(0.4 * angle):
            continue
        on = on_contour(*found)
        score = len(set(sectors[on])) + 1e-4 * on.sum()
        if best is None or score > best[0]:
            best = score, on
    if best is None:
        return None
    on = best[1]
    for _ in range(5):
        found = cone(on)
        if not found:
            return None
        on = on_contour(*found)
        if on.sum() < 20:
            return None
    return camera.pixels(found[0])[0], found[1], len(set(sectors[on])) / 72


def label_all(clone, cameras, boxes):
    """Both images' spheres, by pair. The owner's boxes in right images are off sideways by a constant; it is found first."""
    shift = {"left": np.zeros(2), "right": np.zeros(2)}
    for last in (False, True):
        labels, off = {}, {"left": [], "right": []}
        for pair, box in boxes.items():
            found = {}
            for side, camera in cameras.items():
                start = camera.ellipse_in(box[side]) + shift[side]
                image = decode(clone.read(f"data/basketball_images/{side}/{side}_{pair:02d}.jpg"))
                one = sphere(camera, image, start, np.random.default_rng([SEED, pair]))
                if one and one[2] >= LEAST_COVERED:
                    found[side] = one
                    off[side].append(one[0] - start.mean(axis=0))
            if len(found) == 2:
                labels[pair] = found
        if not last:
            shift = {side: np.median(values, axis=0) for side, values in off.items()}
            print("boxes are off by", {side: np.round(value, 1).tolist() for side, value in shift.items()})
    return labels


def make_basketball(out, clone):
    with np.load(io.BytesIO(clone.read("data/calibrated_params/calibration2.npz"))) as calibration:
        cameras = {"left": Camera(calibration, 1, "l"), "right": Camera(calibration, 2, "r")}
        rotation, translation = calibration["R"], calibration["T"].ravel()
    boxes = {}
    for found in json.loads(clone.text("data/cropped_images/roi_metadata.json")).values():
        boxes.setdefault(int(found["image_pair_id"]), {})[found["side"]] = found["detection_bbox_in_rectified_image"]
    boxes = {pair: box for pair, box in sorted(boxes.items()) if len(box) == 2}
    labels = {pair: found for pair, found in label_all(clone, cameras, boxes).items() if pair not in WRONG}
    numbers = [int(path.rsplit("_", 1)[-1][:-4]) for path in clone.files("data/basketball_images/right", ".jpg")]
    rig = rig_lines((WIDTH, HEIGHT), [(camera.matrix, camera.distortion) for camera in cameras.values()], rotation, translation)
    for part, (first, last, use) in PARTS.items():
        folder = new_folder(out / f"basketball-{part}")
        lines = ["image,object,left_x_px,left_y_px,right_x_px,right_y_px"]
        for side in cameras:
            (folder / side).mkdir()
        for pair in sorted(number for number in numbers if first <= number <= last):
            for side in cameras:
                data = clone.read(f"data/basketball_images/{side}/{side}_{pair:02d}.jpg")
                (folder / side / f"{pair:03d}.jpg").write_bytes(data)
            if pair in labels:
                at = [*labels[pair]["left"][0], *labels[pair]["right"][0]]
                lines.append(f"{pair:03d}.jpg,ball," + ",".join(f"{value:.2f}" for value in at))
        (folder / "labels.csv").write_text("\n".join(lines) + "\n")
        settings = [f"name: basketball {part}", f"use: {use}", "left_images: left", "right_images: right"]
        settings += ["labels: labels.csv", "frames_per_s: 0.5", f"ball_radius_m: {RADIUS_M}", *rig]
        (folder / "set.yaml").write_text("\n".join(settings) + "\n")
        print(f"{folder}: {len(list((folder / 'left').iterdir()))} pairs of images, {len(lines) - 1} with labels")
