"""The set `plate`: a plate with a red square on a blue one on a green one, moved by hand before two different webcams.

The owner's photographs of a board at measured distances calibrate the cameras. Labels are the centres of the red square:
of the pixels that are more red than blue, surrounded by others that are not; no threshold of vision is used for them.
"""
import cv2
import numpy as np
from scipy.optimize import least_squares

from clone import PrepareError, decode, file_name, new_folder, rig_lines

WIDTH, HEIGHT = 640, 480
DISTANCES_CM = range(60, 130, 10)
ROWS = COLUMNS = 6  # inner corners of the board
# Standard deviations of the board's pose at each distance: its tilt, and its position sideways, up and away.
TILT_SIGMA_RAD, POSITION_SIGMA_M = 0.012, (0.003, 0.003, 0.002)
CORNER_SIGMA = 0.3  # px


def board_corners(image):
    """The inner corners of the board, row by row; None where they are not found."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    smooth = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), 2.5)
    xx, yy, xy = (cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3) for order in ((2, 0), (0, 2), (1, 1)))
    saddle = xy * xy - xx * yy
    rows, columns = np.nonzero(saddle == cv2.dilate(saddle, np.ones((9, 9))))
    strength = saddle[rows, columns]
    strongest = np.argsort(-strength)[:70]
    points, strength = np.stack([columns, rows], 1)[strongest].astype(float), strength[strongest]
    best = None
    for start in range(min(40, len(points))):
        for lattice in lattices_from(points, start):
            for left in range(-COLUMNS, 1):
                for top in range(-ROWS, 1):
                    cells = [(left + x, top + y) for y in range(ROWS) for x in range(COLUMNS)]
                    if all(cell in lattice for cell in cells):
                        chosen = [lattice[cell] for cell in cells]
                        if best is None or strength[chosen].min() > best[0]:
                            best = strength[chosen].min(), chosen
    if best is None:
        return None
    corners = points[best[1]].astype(np.float32).reshape(-1, 1, 2)
    window = max(3, int(0.14 * np.linalg.norm(corners[1] - corners[0])))
    return cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), (3, 50, 1e-4)).reshape(-1, 2)


def lattices_from(points, start):
    """Lattices of points by cell, grown from one point along its nearest neighbours in a row and in a column."""
    apart = points - points[start]
    length = np.linalg.norm(apart, axis=1)
    near = (length > 15) & (length < 80)
    along = [np.nonzero(near & (apart[:, k] > 0) & (abs(apart[:, 1 - k]) < 0.15 * apart[:, k]))[0] for k in (0, 1)]
    for first in sorted(along[0], key=lambda k: length[k])[:3]:
        for second in sorted(along[1], key=lambda k: length[k])[:3]:
            lattice, frontier = {(0, 0): start}, [(0, 0)]
            while frontier:
                cell = frontier.pop()
                for step, usual in (((1, 0), first), ((0, 1), second), ((-1, 0), first), ((0, -1), second)):
                    to = cell[0] + step[0], cell[1] + step[1]
                    back = cell[0] - step[0], cell[1] - step[1]
                    if to in lattice or max(map(abs, to)) > max(ROWS, COLUMNS):
                        continue
                    move = points[lattice[cell]] - points[lattice[back]] if back in lattice else sum(step) * apart[usual]
                    off = np.linalg.norm(points - points[lattice[cell]] - move, axis=1)
                    found = int(off.argmin())
                    if off[found] < 0.15 * length[usual] and found not in lattice.values():
                        lattice[to] = found
                        frontier.append(to)
            yield lattice


def calibrate(pattern_m, seen):
    """Both cameras from `seen`: corners (px) by camera, distance, corner and axis. Each camera has a focal length, a
    principal point and one coefficient of distortion. The board's pose is as measured, within its standard deviations."""
    distances = [centimetres / 100 for centimetres in DISTANCES_CM]

    def unpack(unknown):
        cameras = [(np.array([[f, 0, x], [0, f, y], [0, 0, 1.0]]), np.array([k, 0, 0, 0, 0])) for f, x, y, k in unknown[:8].reshape(2, 4)]
        return cameras, unknown[8:20].reshape(2, 6), unknown[20:].reshape(len(distances), 6)

    def residuals(unknown):
        cameras, poses, boards = unpack(unknown)
        blocks = [(boards[:, :3] / TILT_SIGMA_RAD).ravel(), (boards[:, 3:] / POSITION_SIGMA_M).ravel()]
        for k, distance in enumerate(distances):
            points = pattern_m @ cv2.Rodrigues(boards[k, :3])[0].T + boards[k, 3:] + [0, 0, distance]
            for (matrix, distortion), pose, corners in zip(cameras, poses, seen):
                projected, _ = cv2.projectPoints(points, pose[:3], pose[3:], matrix, distortion)
                blocks.append((projected.reshape(-1, 2) - corners[k]).ravel() / CORNER_SIGMA)
        return np.concatenate(blocks)

    points = np.concatenate([pattern_m + [0, 0, distance] for distance in distances]).astype(np.float32)
    begin = []
    for corners in seen:
        matrix = np.array([[900.0, 0, WIDTH / 2], [0, 900, HEIGHT / 2], [0, 0, 1]])
        _, rvec, tvec = cv2.solvePnP(points, np.concatenate(corners), matrix, None)
        begin.append((rvec.ravel(), tvec.ravel()))
    unknown = np.concatenate([np.tile([900.0, WIDTH / 2, HEIGHT / 2, 0], 2), *(np.concatenate(pose) for pose in begin), np.zeros(6 * len(distances))])
    solution = least_squares(residuals, unknown, x_scale="jac", loss="soft_l1")
    if not solution.success:
        raise PrepareError(f"The calibration of the cameras does not converge: {solution.message}")
    cameras, poses, boards = unpack(solution.x)
    rotations = [cv2.Rodrigues(pose[:3])[0] for pose in poses]
    rotation = rotations[1] @ rotations[0].T
    translation = poses[1, 3:] - rotation @ poses[0, 3:]
    off_px = residuals(solution.x)[boards.size:].reshape(-1, 2) * CORNER_SIGMA
    rms_px = np.sqrt((off_px**2).sum(axis=1).mean())
    print(f"cameras {1000 * np.linalg.norm(translation):.1f} mm apart; corners fit to {rms_px:.2f} px RMS")
    return cameras, rotation, translation


def red_square(image):
    """Centre and side (px) of the red square: the compact red component with a blue surround that has the highest
    contrast; None where there is none."""
    redder = image[:, :, 2].astype(int) - image[:, :, 0]
    count, labels, stats, centres = cv2.connectedComponentsWithStats((redder > 0).astype(np.uint8), connectivity=4)
    best = None
    for k in range(1, count):
        x, y, width, height, area = stats[k]
        if area < 60 or max(width, height) > 60 or area < 0.7 * width * height or not 0.6 < width / height < 1.6:
            continue
        around = np.zeros(redder.shape, np.uint8)
        cv2.rectangle(around, (x - 3, y - 3), (x + width + 2, y + height + 2), 1, 2)
        contrast = np.median(redder[labels == k]) - np.median(redder[around > 0])
        if np.mean(redder[around > 0] < 0) > 0.9 and (best is None or contrast > best[0]):
            best = contrast, centres[k], np.sqrt(area)
    return None if best is None else best[1:]


def make_plate(out, clone):
    folder = new_folder(out / "plate")
    pattern = np.loadtxt(clone.text("calibration_images/calibration_pattern_xy.csv").splitlines(), delimiter=",", skiprows=1) / 100
    seen = []
    for camera in (1, 2):
        seen.append([board_corners(decode(clone.read(f"calibration_images/camera_{camera}_{cm}cm.png"))) for cm in DISTANCES_CM])
        if any(corners is None for corners in seen[-1]):
            raise PrepareError(f"{clone.path}: the board is not found in all photographs of camera {camera}.")
    pattern_m = np.c_[pattern[:, 0], -pattern[:, 1], np.zeros(len(pattern))]
    cameras, rotation, translation = calibrate(pattern_m, seen)

    sides = {}
    for side, camera in (("left", 1), ("right", 2)):
        (folder / side).mkdir()
        sides[side] = {}
        for path in clone.files("red_square_images", ".png"):
            name = file_name(path)
            if name.startswith(f"camera_{camera}_"):
                (folder / side / name[9:]).write_bytes(clone.read(path))
                sides[side][name[9:]] = red_square(decode(clone.read(path)))
    if sides["left"].keys() != sides["right"].keys():
        raise PrepareError(f"{clone.path}: the cameras' images do not have the same names.")
    # Where to click above the centre, in sides of the red square: in the middle of the blue frame and of the green one.
    click_offsets = {"red": 0.0, "blue": 0.65, "green": 1.25}
    header = "image,object,left_x_px,left_y_px,right_x_px,right_y_px"
    labels, clicks = [header], [header]
    for image, left in sides["left"].items():
        right = sides["right"][image]
        if left is None or right is None:
            continue
        for thing, above in click_offsets.items():
            labels.append(f"{image},{thing}," + ",".join(f"{value:.2f}" for value in (*left[0], *right[0])))
            at = [centre - (0, above * size) for centre, size in (left, right)]
            clicks.append(f"{image},{thing}," + ",".join(f"{value:.0f}" for value in (*at[0], *at[1])))
    (folder / "labels.csv").write_text("\n".join(labels) + "\n")
    (folder / "clicks.csv").write_text("\n".join(clicks) + "\n")
    one_coefficient = [(matrix, distortion[:1]) for matrix, distortion in cameras]
    settings = ["name: squares on a plate", "use: tuning", "left_images: left", "right_images: right", "labels: labels.csv"]
    settings += ["clicks: clicks.csv", "frames_per_s: 15"]
    settings += rig_lines((WIDTH, HEIGHT), one_coefficient, rotation, translation)
    (folder / "set.yaml").write_text("\n".join(settings) + "\n")
    print(f"{folder}: {len(sides['left'])} pairs of images, {(len(labels) - 1) // len(click_offsets)} with labels")
