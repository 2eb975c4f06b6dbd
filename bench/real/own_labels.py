"""Videos that were labelled for this project: labels/videos.csv lists them, labels/SET.csv has the centres.

An image has the number that it has in the video, from 0. `size`: images are made so many times as large; the centres
are in pixels of the video, the centre of the first one at (0, 0).
"""
import csv
import pathlib
import tempfile

import cv2

from clone import Clone, PrepareError, decode, file_name

LABELS = pathlib.Path(__file__).parent / "labels"
QUALITY = 95  # of the JPEGs


def read_rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def frames_of(clone, path, first, end):
    """The images [first, end) of a video, or of a sequence of image files, whose numbers begin at 1: 'folder/%03d.jpg'."""
    if "%" in path:
        return {number: decode(clone.read(path % (number + 1))) for number in range(first, end)}
    with tempfile.NamedTemporaryFile(suffix=pathlib.Path(path).suffix) as file:
        file.write(clone.read(path))
        file.flush()
        video = cv2.VideoCapture(file.name)
        images = {}
        for number in range(end):
            read, image = video.read()
            if not read:
                raise PrepareError(f"{clone.path}: {path} ends at image {number}, expected {end}.")
            if number >= first:
                images[number] = image
    return images


def jpeg(image, size):
    if size != 1:
        image = cv2.resize(image, None, fx=size, fy=size, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


def make_own(out, clones, write_video, settings_of):
    """Makes the sets whose repositories are in the folder `clones`, each under its name without the owner's."""
    if not clones.is_dir():
        raise PrepareError(f"{clones} is not a folder. Give the folder that contains the clones.")
    made = 0
    for row in read_rows(LABELS / "videos.csv"):
        path = clones / file_name(row["repository"])
        if not path.is_dir():
            print(f"{row['set']}: left out, because {path} (a clone of {row['repository']}) does not exist")
            continue
        frames = frames_of(Clone(path, row["commit"]), row["video"], int(row["first_image"]), int(row["end_image"]))
        size = float(row["size"])
        images = {f"{number:05d}.jpg": jpeg(image, size) for number, image in frames.items()}
        scaled = lambda pixels: (float(pixels) + 0.5) * size - 0.5
        labels = [
            (cells["image"], cells["object"], scaled(cells["x_px"]), scaled(cells["y_px"]))
            for cells in read_rows(LABELS / f"{row['set']}.csv")
        ]
        settings = settings_of(row["title"], row["use"], row["frames_per_s"], row["disparity_px"])
        if row["targets"]:
            settings.append("targets: {" + ", ".join(each.replace("=", ": ") for each in row["targets"].split()) + "}")
        write_video(out / row["set"], settings, images, labels)
        made += 1
    if made == 0:
        raise PrepareError(f"no set was made, for {clones} contains none of these clones.")
