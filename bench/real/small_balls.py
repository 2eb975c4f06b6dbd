"""Ping-pong balls and marbles, from public repositories (docs/real-images.md)."""
import cv2
import numpy as np

from clone import PrepareError, decode, file_name

PING_PONG = "source/yolov3-pytorch/datasets/train"
# The last numbers of the images of each of the three places.
PLACES = [("floor", 118), ("trolley", 312), ("walls", 10**6)]


def is_orange(image, x, y, width, height):
    """Whether the middle of a box is orange: the labels do not tell orange balls from white ones."""
    rows, columns = slice(max(0, int(y - height / 4)), int(y + height / 4) + 1), slice(max(0, int(x - width / 4)), int(x + width / 4) + 1)
    hsv = cv2.cvtColor(image[rows, columns], cv2.COLOR_BGR2HSV).reshape(-1, 3)
    hue, saturation, _ = np.median(hsv, axis=0)
    return saturation >= 80 and 5 <= hue <= 28


def make_ping_pong(out, clone, write_video, settings_of):
    """Single images, one per second: a guess. Centres of the owners' boxes, in parts of the image's size, of orange balls."""
    places = [({}, []) for _ in PLACES]
    for path in clone.files(f"{PING_PONG}/JPEGImages", ".jpg"):
        name, data = file_name(path), clone.read(path)
        number = int(name.rsplit(".", 1)[0][-3:])
        images, labels = next(places[k] for k, (_, last) in enumerate(PLACES) if number <= last)
        images[name] = data
        image = decode(data)
        size = np.array([image.shape[1], image.shape[0]] * 2)
        for line in clone.text(f"{PING_PONG}/Annotations/{name.rsplit('.', 1)[0]}.txt").splitlines():
            cells = line.split()
            if len(cells) != 5:
                continue
            x, y, width, height = np.array(cells[1:], float) * size
            if is_orange(image, x, y, width, height):
                labels.append((name, "orange", x - 0.5, y - 0.5))
    for number, ((place, _), (images, labels)) in enumerate(zip(PLACES, places), 1):
        write_video(out / f"pingpong{number}", settings_of(f"ping-pong ball, {place}", "test", 1, 28), images, labels)


def make_marbles(out, clone, write_video, settings_of):
    """Hand-labelled centres in MATLAB coordinates; the fields' names are exchanged. Two marbles are orange: either is right."""
    truth = clone.mat("gtSeq1.mat")
    labels = []
    for field in ("new_marbles_comingFromRight", "new_marbles_comingFromLeft"):
        for marble in truth[field].ravel():
            colour = str(marble["colour"][0]).split("_", maxsplit=1)[0]
            if colour in ("orange", "yellow"):
                numbers, xs, ys = (marble[key].ravel() for key in ("frame_numbers", "row_of_centers", "col_of_centers"))
                labels += [(f"{int(number):03d}.jpg", colour, x - 1, y - 1) for number, x, y in zip(numbers, xs, ys)]
    if not labels:
        raise PrepareError(f"{clone.path}: gtSeq1.mat has no orange or yellow marble. Give a complete clone.")
    images = {f"{int(file_name(path)[:-4]):03d}.jpg": clone.read(path) for path in clone.files("SEQ1", ".jpg")}
    labels.sort(key=lambda row: (row[1], row[0]))
    write_video(out / "marbles", settings_of("rolling marbles", "tuning", 15, 10), dict(sorted(images.items())), labels)
