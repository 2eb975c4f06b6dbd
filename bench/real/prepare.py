#!/usr/bin/python3
"""Makes the folders that multireach-bench-real measures from public repositories (docs/real-images.md).

    prepare.py OUT --av2 CLONE --AV CLONE --ball-tracking CLONE --RVA_VisionChallenge CLONE --Detect CLONE
                   --robocup_ml CLONE --PRiMEStereoMatch CLONE --stereo-matching CLONE --kfct CLONE --depthFinderPy CLONE
                   --tutorial_calibrate_stereo_vision CLONE --Disparity CLONE --pingpong-ball-detection CLONE
                   --Advanced-Vision-1 CLONE --vtest VIDEO --videos FOLDER

Each CLONE is a local clone of that GitHub repository, bare or not; its files are read from git, not from the work tree.
Repositories that are not given are left out. The commits are those below, on which the tables were measured. Needs the
Debian packages git, python3-numpy, python3-opencv and python3-scipy. VIDEO is vtest.avi of the Debian package opencv-doc,
in /usr/share/doc/opencv-doc/examples/data: makes street. FOLDER contains clones of the repositories in labels/videos.csv:
makes the videos that were labelled for this project.

    FlaviusPopescu/av2                      cdd09d4   juggled1, juggled2
    crunchiness/AV                          69fd198   table
    EilidhHendry/ball-tracking              d19f12b   thrown
    AlvaroNavarroMora/RVA_VisionChallenge   7159b27   vot1, book, tiger
    SYSU-QuadCopter-2014-Team/Detect        22723f6   vot2 (later commits no longer have the images)
    andrepool/robocup_ml                    45430e3   football1 to football5
    PRiME-project/PRiMEStereoMatch          3a28bb6   still/Art, Books, Dolls, Laundry, Reindeer
    2b-t/stereo-matching                    a1a3ac2   still/Adirondack
    apennisi/kfct                           0dca73c   can
    maheriya/depthFinderPy                  c1c5ea4   cage (later commits no longer have the image; the positions: 1c8aee5)
    sebastiengilbert73/tutorial_calibrate_stereo_vision   8708a5a   plate
    saibhakta/Disparity                     3d48942   basketball-indoors, basketball-dark, basketball-outdoors (some minutes)
    winterbloooom/pingpong-ball-detection   7cb5e91   pingpong1 to pingpong3
    robevans/Advanced-Vision-1              114f27a   marbles
"""
import argparse
import json
import pathlib
import re
import sys
from collections import Counter

import cv2
import numpy as np

from basketball import make_basketball
from clone import Clone, PrepareError, decode, file_name, new_folder
from own_labels import make_own
from plate import make_plate
from small_balls import make_marbles, make_ping_pong
from street import make_street


# Writing folders


def write_video(folder, settings, images, labels, clicks=None):
    """Writes a video. `settings`: lines of YAML; `images`: bytes by file name; `labels`: (image, object, x, y)."""
    new_folder(folder)
    (folder / "frames").mkdir()
    for name, data in images.items():
        (folder / "frames" / name).write_bytes(data)
    lines = ["image,object,x_px,y_px", *(f"{image},{thing},{x:.2f},{y:.2f}" for image, thing, x, y in labels)]
    (folder / "labels.csv").write_text("\n".join(lines) + "\n")
    settings = ["images: frames", "labels: labels.csv", *settings]
    if clicks:
        settings.append("clicks:")
        settings += [f"  {thing}: [{', '.join(names)}]" for thing, names in clicks.items()]
    (folder / "set.yaml").write_text("\n".join(settings) + "\n")
    counts = ", ".join(f"{count} of {thing}" for thing, count in sorted(Counter(row[1] for row in labels).items()))
    print(f"{folder}: {len(images)} images; labels: {counts}")


def settings_of(name, use, frames_per_s, disparity_px):
    return [f"name: {json.dumps(name)}", f"use: {use}", f"frames_per_s: {frames_per_s}", f"disparity_px: {disparity_px}"]


# Juggled balls


def highest_in_each_quarter(names, labels):
    """For each object and each quarter of the video, the image in which the object is highest."""
    clicks = {}
    for thing in sorted({row[1] for row in labels}):
        height = {image: y for image, other, _, y in labels if other == thing}
        quarters = [names[len(names) * k // 4 : len(names) * (k + 1) // 4] for k in range(4)]
        clicks[thing] = [min((name for name in quarter if name in height), key=height.get) for quarter in quarters]
    return clicks


def make_juggled(out, clone):
    """Centres are MATLAB coordinates, so the first pixel is 1."""
    # gt1: image number, then row and column of the red, green and yellow ball.
    # tracks: column and row of the yellow, green and red ball.
    truth, tracks = clone.mat("gt1.mat")["gt1"].astype(float), clone.mat("track.mat")["tracks"]
    videos = [
        (1, {"red": truth[[2, 1]], "green": truth[[4, 3]], "yellow": truth[[6, 5]]}),
        (2, {"yellow": tracks.T[:2], "green": tracks.T[2:4], "red": tracks.T[4:]}),
    ]
    for number, centres in videos:
        source = f"juggle{number}"
        images = {file_name(path): clone.read(path) for path in clone.files(source, ".jpg")}
        names = list(images)
        labels = []
        for thing, points in centres.items():
            if points.shape[1] != len(names):
                count = points.shape[1]
                raise PrepareError(f"{clone.path}: {source} has {len(names)} images, but {count} labels of {thing}.")
            labels += [(image, thing, x - 1, y - 1) for image, x, y in zip(names, *points) if np.isfinite(x + y)]
        settings = settings_of(f"juggled balls {number}", "tuning", 25, 28)
        write_video(out / f"juggled{number}", settings, images, labels, highest_in_each_quarter(names, labels))


# Balls on a table


def make_table(out, clone):
    """Ten balls with hand-labelled centres, in MATLAB coordinates. The fields' names are exchanged: rows are columns.

    Ball by ball, because a click is at the first label of an object and image, but where it has several targets.
    """
    objects = [None, None, "pink", "pink", *["orange"] * 6]  # the first two are white, like the table
    balls = clone.mat("balls_loc.mat")["new_balls"][0]
    labels = []
    for thing, (x, y, number) in zip(objects, balls):
        if thing:
            labels += [(f"{int(k):08d}.jpg", thing, a - 1, b - 1) for a, b, k in zip(x.flat, y.flat, number.flat)]
    images = {file_name(path): clone.read(path) for path in clone.files("set1", ".jpg") if "bgframe" not in path}
    settings = [*settings_of("balls on a table", "tuning", 30, 28), "targets: {orange: 6, pink: 2}"]
    write_video(out / "table", settings, images, labels)


# Balls thrown in a room


# Of each object: lowest and highest mean hue (OpenCV's, 0 to 180) and lowest median chroma. They leave out a white box,
# a paper and a brown toy, which are thrown too.
THROWN = {
    "red": (-6, 5, 18),
    "orange": (6, 15, 60),
    "yellow": (24, 32, 60),
    "blue": (105, 117, 50),
    "pink": (160, 173, 45),
}


def moving_contours(image, background):
    """Contours of what differs from the background, of at least 60 pixels.

    The threshold is just above the noise: the lower side of a dark ball hardly differs from the dark cloth behind it.
    """
    difference = cv2.GaussianBlur(cv2.absdiff(image, background), (0, 0), 1)
    moving = (difference.max(axis=2) > 12).astype(np.uint8)
    moving = cv2.morphologyEx(moving, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    moving = cv2.morphologyEx(moving, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7)))
    contours, _ = cv2.findContours(moving, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return [contour for contour in contours if cv2.contourArea(contour) >= 60]


def colour_name(image, contour):
    """The name of the object of this colour, or None. The hue is the mean of the pixels' hues, weighted with chroma."""
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.drawContours(mask, [contour], -1, 1, cv2.FILLED)
    pixels = image[mask > 0]
    chroma = pixels.max(axis=1).astype(float) - pixels.min(axis=1)
    hues = cv2.cvtColor(pixels[None], cv2.COLOR_BGR2HSV)[0, :, 0]
    hue = np.angle((chroma * np.exp(1j * np.pi * hues / 90)).sum()) * 90 / np.pi % 180
    for name, (low, high, least) in THROWN.items():
        if (hue - low) % 180 <= high - low and np.median(chroma) >= least:
            return name
    return None


def is_whole_ball(contour, size):
    """Whether a contour is compact, nearly an ellipse, of a ball's size, and away from the image border."""
    x, y, width, height = cv2.boundingRect(contour)
    if x < 2 or y < 2 or x + width > size[0] - 2 or y + height > size[1] - 2:
        return False
    area = cv2.contourArea(contour)
    _, axes, _ = cv2.fitEllipse(contour)
    return (
        200 <= area <= 4000
        and area > 0.9 * cv2.contourArea(cv2.convexHull(contour))
        and area > 0.9 * np.pi / 4 * axes[0] * axes[1]
        and max(axes) < 1.7 * min(axes)
    )


def make_thrown(out, clone):
    """Labels are the centroids of moving blobs. Images without a coloured one are left out.

    A blob at the image border, or of which a part is not told from the background, has no label, but its image stays.
    """
    data = {file_name(path): clone.read(path) for path in clone.files("Video5", ".jpg")}
    every_tenth = [decode(one) for one in list(data.values())[::10]]
    background = np.median(every_tenth, axis=0).astype(np.uint8)
    images, labels = {}, []
    for name, one in data.items():
        image = decode(one)
        blobs = [(colour_name(image, contour), contour) for contour in moving_contours(image, background)]
        blobs = [(thing, contour) for thing, contour in blobs if thing]
        if blobs:
            images[name] = one
        things = [thing for thing, _ in blobs]
        for thing, contour in blobs:
            if things.count(thing) == 1 and is_whole_ball(contour, image.shape[1::-1]):
                m = cv2.moments(contour)
                labels.append((name, thing, m["m10"] / m["m00"], m["m01"] / m["m00"]))
    settings = settings_of("thrown in a room", "tuning", 30, 28)
    # A picture of 16 : 9 in 640 x 480 pixels: a ball at rest is four thirds as high as wide.
    write_video(out / "thrown", settings + ["fx_px: 600", "fy_px: 800"], images, labels)


# Sequences of the visual object tracking challenge


def half_size(data):
    """A JPEG of half the size, of a JPEG."""
    smaller = cv2.resize(decode(data), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", smaller, [cv2.IMWRITE_JPEG_QUALITY, 97])[1].tobytes()


def write_vot(folder, clone, source, images_in, name, thing="ball", disparity_px=10, half=False):
    """Centres of the boxes in groundtruth.txt, one line for each image: x, y of four corners.

    They are measured from the image's corner, so the centre of the first pixel is at 0.5. `half`: at half the size, for
    large objects: the centre of their box may be more than 10 px from that of their colour.
    """
    lines = clone.text(f"{source}/groundtruth.txt").split()
    images = {file_name(path): clone.read(path) for path in clone.files(images_in, ".jpg")}
    labels = []
    for image, line in zip(images, lines):
        corners = np.array(line.split(","), float).reshape(4, 2)
        if np.isfinite(corners).all():
            labels.append((image, thing, *(corners.mean(axis=0) * (0.5 if half else 1) - 0.5)))
    if half:
        images = {image: half_size(data) for image, data in images.items()}
    write_video(folder, settings_of(name, "test", 30, disparity_px), images, labels)


def make_vot1(out, clone):
    write_vot(out / "vot1", clone, "sequences/ball1", "sequences/ball1/color", "red football outdoors")
    write_vot(out / "book", clone, "sequences/book", "sequences/book/color", "violet book", "book", 28, half=True)
    write_vot(out / "tiger", clone, "sequences/tiger", "sequences/tiger/color", "toy tiger", "tiger", 28, half=True)


def make_vot2(out, clone):
    write_vot(out / "vot2", clone, "ball", "ball", "red football indoors")


# A sequence of the object tracking benchmark OTB


def make_can(out, clone):
    """Centres of the boxes in groundtruth_rect.txt, one line for each image: x, y of the first pixel (from 1), width, height."""
    images = {file_name(path): clone.read(path) for path in clone.files("data/Coke/img", ".jpg")}
    boxes = [[float(cell) for cell in line.split(",")] for line in clone.text("data/Coke/groundtruth_rect.txt").split()]
    labels = [(image, "can", x - 1 + (w - 1) / 2, y - 1 + (h - 1) / 2) for image, (x, y, w, h) in zip(images, boxes)]
    write_video(out / "can", settings_of("silver can", "test", 30, 28), images, labels)


# Robot football

FOOTBALL = [
    ["20190606/r2", "20190606/r4"],
    ["20220715/r7"],
    ["20230709/r5", "20230709/r6"],
    ["20220716/r2", "20220716/r4", "20220716/r6"],
    ["20240222/r12", "20240222/r14"],
]


def balls_in(text, width, height):
    """Centres of the balls in a label file: lines of class (0: ball), centre and size, in parts of the image's size."""
    rows = [[float(cell) for cell in line.split()] for line in text.splitlines() if line.strip()]
    return [(x * width - 0.5, y * height - 0.5) for kind, x, y, w, _ in rows if kind == 0 and w * width >= 12]


def make_football(out, clone):
    """Balls of at least 12 px have labels; images without one stay."""
    for number, folders in enumerate(FOOTBALL, 1):
        images, labels = {}, []
        for path in (path for folder in folders for path in clone.files(folder, ".txt")):
            data = clone.read(path[:-4] + ".jpg")
            name = "_".join(path[:-4].split("/")[1:]) + ".jpg"
            height, width = decode(data).shape[:2]
            images[name] = data
            labels += [(name, "ball", *ball) for ball in balls_in(clone.text(path), width, height)]
        settings = settings_of(f"robot football {number}", "test", 0.1, 10)
        write_video(out / f"football{number}", settings, images, labels)


# Still scenes

# Name, click, region (left, top, width, height) and whether it is whole.
STILL = {
    "Art": [
        ("pink end of the crayon", (275, 315), (250, 279, 68, 76), True),
        ("pink cone", (228, 250), (198, 183, 64, 98), True),
        ("teal tip of the brush", (92, 113), (85, 102, 20, 25), True),
    ],
    "Dolls": [
        ("pink pig", (140, 337), (117, 318, 50, 46), True),
        ("green hat", (70, 30), (8, 0, 136, 68), False),
        ("orange hair", (420, 125), (350, 103, 113, 125), False),
        ("red horse", (281, 322), (262, 282, 38, 78), True),
        ("orange cow", (401, 338), (385, 302, 39, 65), True),
    ],
    "Laundry": [("red top of the spray bottle", (335, 188), (289, 150, 60, 47), True)],
    "Reindeer": [
        ("red parcel", (153, 208), (140, 189, 37, 38), True),
        ("yellow parcel", (120, 203), (111, 188, 23, 31), True),
        ("red antler", (165, 108), (136, 83, 47, 48), True),
    ],
    "Books": [("orange stroke on a cover", (290, 303), (259, 290, 50, 42), True)],
}


ADIRONDACK = [
    ("yellow mug", (360, 135), (340, 104, 64, 66), True),
    ("dark red book", (180, 295), (104, 262, 150, 80), True),
    ("red scarf", (660, 330), (532, 224, 150, 165), False),
]


def write_objects(folder, lines, objects):
    """Writes the set.yaml of a still scene."""
    lines.append("objects:")
    for name, click, region, whole in objects:
        where = f"click: {list(click)}, region: {list(region)}"
        lines.append(f"  - {{name: {name}, {where}, whole: {'true' if whole else 'false'}}}")
    (folder / "set.yaml").write_text("\n".join(lines) + "\n")
    print(f"{folder}: {len(objects)} objects")


def make_adirondack(out, clone):
    """Middlebury 2014 at a quarter of its size: f = 1040.3 px, a baseline of 176.252 mm, 52.265 columns cut off."""
    folder = new_folder(out / "still" / "Adirondack")
    for name, source in (("left", "left"), ("right", "right"), ("disparity", "gt")):
        (folder / f"{name}.png").write_bytes(clone.read(f"data/Adirondack_{source}.png"))
    lines = ["name: Adirondack", "use: test", "left: left.png", "right: right.png", "disparity: disparity.png"]
    lines += ["disparity_scale: 1", "disparity_offset_px: 52.265", "fx_px: 1040.3", "baseline_m: 0.176252"]
    write_objects(folder, lines, ADIRONDACK)


def make_still(out, clone):
    """Middlebury 2005 at a third of its size: f = 3740 px and a baseline of 160 mm at full size.

    Disparities of the full size, less dmin columns that are cut off, are the values of the disparity image.
    """
    for pair, objects in STILL.items():
        folder = new_folder(out / "still" / pair)
        for name in ("view1.png", "view5.png", "disp1.png"):
            (folder / name).write_bytes(clone.read(f"data/{pair}/{name}"))
        cut_off = float(clone.text(f"data/{pair}/dmin.txt")) / 3
        lines = [f"name: {pair}", "use: test", "left: view1.png", "right: view5.png", "disparity: disp1.png"]
        lines += ["disparity_scale: 3", f"disparity_offset_px: {cut_off:.3f}", "fx_px: 1246.67", "baseline_m: 0.16"]
        write_objects(folder, lines, objects)


# Balls in a cage

CAGE_POSITIONS = "1c8aee5b1a7f30183d8012250c9b22130f2c8639"
CAGE_CALIBRATION = "data/calib/"
CAGE_RADIUS_MM = 35  # the height of the balls' centres above the floor in depth_tester_final.py
CAGE_WIDTH_MM = 3420  # from the left wall, the origin of the pose file, to the right one, that of final_measurements.txt


def without_marks(image):
    """The picture with what is red and thin painted over: most of the numbers and boxes that were drawn into it."""
    blue, green, red = (channel.astype(int) for channel in cv2.split(image))
    reddish = ((red > green + 25) & (red > blue + 25)).astype(np.uint8) * 255
    thick = cv2.morphologyEx(reddish, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9)))
    thin = cv2.subtract(reddish, cv2.dilate(thick, np.ones((3, 3), np.uint8)))
    return cv2.inpaint(image, cv2.dilate(thin, np.ones((3, 3), np.uint8)), 3, cv2.INPAINT_TELEA)


def matrix_in(text, name):
    """A matrix of an OpenCV file."""
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    matrix = storage.getNode(name).mat()
    if matrix is None:
        raise PrepareError(f"An OpenCV file of the clone has no matrix {name}. Give a complete clone.")
    return matrix


def cage_pose(clone):
    """Rotation and translation (mm) from the left camera to the cage, whose axes point left, up and away."""
    rectifying = matrix_in(clone.text(CAGE_CALIBRATION + "extrinsics.yml"), "R1")
    pose = clone.text(CAGE_CALIBRATION + "pose_Z5300_2.yml")
    turn = np.diag([-1.0, -1.0, 1.0])  # positions count x from the right wall to the left, y upwards
    rotation = turn @ matrix_in(pose, "R") @ rectifying
    return rotation, turn @ matrix_in(pose, "T").ravel() + [CAGE_WIDTH_MM, 0, 0]


def make_cage(out, clone):
    """Sixteen balls on the floor, at positions that the owners measured, before two cameras that they calibrated.

    The picture is a view of both images, cut off by 6 pixels, with marks. The ball in the air is left out, as of the RMS
    in the owners' last test: its measured position and the triangulated one are 17 cm apart there.
    """
    folder = new_folder(out / "cage")
    for name in ("intrinsics.yml", "extrinsics.yml"):
        (folder / name).write_bytes(clone.read(CAGE_CALIBRATION + name))
    view = decode(clone.read("data/images/17-balls-coordinates.jpg"))
    panes = {name: np.zeros((1024, 1280, 3), np.uint8) for name in ("left", "right")}
    panes["left"][:, 6:] = view[53:1077, :1274]
    panes["right"][:, :1274] = view[53:1077, 1274:]
    for name, pane in panes.items():
        cv2.imwrite(str(folder / f"{name}.png"), pane)
        cv2.imwrite(str(folder / f"learn_{name}.png"), without_marks(pane))
    number = r"\s*([\d.]+)\s*"
    pattern = r"\[" + ",".join([number] * 2) + r"\],\s*\[" + ",".join([number] * 2) + r"\]\s*\[" + ",".join([number] * 3) + r"\]"
    text = Clone(clone.path, CAGE_POSITIONS).text("final_measurements.txt")
    rows = [[float(cell) for cell in row] for row in re.findall(pattern, text)]
    lines = ["left_x_px,left_y_px,right_x_px,right_y_px,x_m,y_m,z_m"]
    for *pixels, x, y, z in rows:
        if y == 0:
            position = (x / 1000, CAGE_RADIUS_MM / 1000, z / 1000)
            lines.append(",".join([*(f"{pixel:.1f}" for pixel in pixels), *(f"{metres:.4f}" for metres in position)]))
    if len(lines) == 1:
        raise PrepareError(f"{clone.path}: final_measurements.txt has no position of a ball on the floor.")
    (folder / "positions.csv").write_text("\n".join(lines) + "\n")
    rotation, translation = cage_pose(clone)
    pose = f"{{rotation: {rotation.ravel().round(9).tolist()}, translation_m: {(translation / 1000).round(6).tolist()}}}"
    cameras = f"{{files: [intrinsics.yml, extrinsics.yml], unit: mm, width_px: 1280, height_px: 1024, left_to_robot: {pose}}}"
    settings = ["name: balls in a cage", "use: tuning", "left: left.png", "right: right.png", "learn_left: learn_left.png"]
    settings += ["learn_right: learn_right.png", f"cameras: {cameras}", "positions: positions.csv"]
    settings.append(f"ball_radius_m: {CAGE_RADIUS_MM / 1000}")
    (folder / "set.yaml").write_text("\n".join(settings) + "\n")
    print(f"{folder}: {len(lines) - 1} positions")


# Command line


def make_balls(make):
    return lambda out, clone: make(out, clone, write_video, settings_of)


SOURCES = [
    ("FlaviusPopescu/av2", "cdd09d4095a9b283635b13be0bfce906b4701e2b", make_juggled, "juggled1, juggled2"),
    ("crunchiness/AV", "69fd1988fa35489c5edd283fca1cbea8534ab39b", make_table, "table"),
    ("EilidhHendry/ball-tracking", "d19f12b61bd7cbb957c60b8bd41c1bf331e681e1", make_thrown, "thrown"),
    ("AlvaroNavarroMora/RVA_VisionChallenge", "7159b27592e3cf9c0a0f38c95e20d1b020d947f2", make_vot1, "vot1, book, tiger"),
    ("SYSU-QuadCopter-2014-Team/Detect", "22723f628a9d8f75ed27e9c47e370ea0a20f664e", make_vot2, "vot2"),
    ("andrepool/robocup_ml", "45430e3b36ea937e4ec1da62f0d4a7cb3490618b", make_football, "football1 to football5"),
    ("PRiME-project/PRiMEStereoMatch", "3a28bb633cbe455286a48a39912d7a6c1f328063", make_still, "still/*"),
    ("2b-t/stereo-matching", "a1a3ac2d687711b87841bf7695d3f36bf5759992", make_adirondack, "still/Adirondack"),
    ("apennisi/kfct", "0dca73c621f86c70be2415339051d36b2850440f", make_can, "can"),
    ("maheriya/depthFinderPy", "c1c5ea4d264c2c40121525079ab5c7e6deb19979", make_cage, "cage"),
    ("sebastiengilbert73/tutorial_calibrate_stereo_vision", "8708a5ad46c440ed433e9dd53ed2e10c84209cae", make_plate, "plate"),
    ("saibhakta/Disparity", "3d48942a7c1b7f86d4dbb48c7c513a5b2912361b", make_basketball, "basketball-*"),
    ("winterbloooom/pingpong-ball-detection", "7cb5e917ad1efe10773a2683a68f58fc00bda83e", make_balls(make_ping_pong), "pingpong1 to pingpong3"),
    ("robevans/Advanced-Vision-1", "114f27a848185a15b281151450e81c6ed95a2644", make_balls(make_marbles), "marbles"),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", metavar="OUT", type=pathlib.Path, help="folder to write the sets into")
    for repository, _, _, folders in SOURCES:
        option = "--" + file_name(repository)
        parser.add_argument(option, metavar="CLONE", dest=repository, help=f"clone of {repository}: makes {folders}")
    parser.add_argument("--vtest", metavar="VIDEO", help="vtest.avi of the Debian package opencv-doc: makes street")
    parser.add_argument("--videos", metavar="FOLDER", type=pathlib.Path, help="folder with clones of the repositories in labels/videos.csv")
    arguments = vars(parser.parse_args())
    if not any(arguments[source] for source in ["vtest", "videos", *(repository for repository, _, _, _ in SOURCES)]):
        parser.error("give at least one clone, or a video")
    for repository, revision, make, folders in SOURCES:
        path = arguments[repository]
        if path is None:
            print(f"{folders}: left out, because --{file_name(repository)} is not given")
            continue
        clone = Clone(path, revision)
        print(f"{repository}: commit {clone.commit[:7]}")
        make(arguments["out"], clone)
    if arguments["vtest"]:
        settings = settings_of("street", "test", 10, 10)
        make_street(arguments["out"], arguments["vtest"], write_video, settings)
    if arguments["videos"]:
        make_own(arguments["out"], arguments["videos"], write_video, settings_of)


if __name__ == "__main__":
    try:
        main()
    except PrepareError as fault:
        sys.exit(f"prepare.py: {fault}")
