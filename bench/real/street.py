"""The set `street`: somebody in a red coat on a street from above, who leaves the view and comes back, while others in
dark red and brown walk by. Of OpenCV's examples: vtest.avi of the Debian package opencv-doc.

Labels are the centroids of what is red and moves: pixels that differ from the median image, and in which red exceeds the
larger of green and blue; no threshold of vision is used for them. From image to image, the nearest one is the coat.
"""
import cv2
import numpy as np

from clone import PrepareError

FIRST, END = 405, 795  # images of the video: before the coat comes, and before it leaves again
COMES = {424: (690, 768), 606: (0, 60)}  # image from which the coat is seen; columns where it appears
LEAVES = 580  # image from which it is outside the view, checked by eye
ENTERS_ABOVE = 320  # rows; below, others walk
MOVING, RED, LEAST_PX = 35, 45, 60  # grey levels, grey levels, pixels: choices
STEP_PX = 17  # farthest from one image to the next; 5 more for each image in which it is not found
QUALITY = 90  # of the JPEGs


def read_video(path):
    video = cv2.VideoCapture(str(path))
    images = []
    while True:
        read, image = video.read()
        if not read:
            break
        images.append(image)
    if len(images) < END:
        raise PrepareError(f"{path}: expected vtest.avi of the Debian package opencv-doc, {END} images or more")
    return images


def red_things(image, still):
    """Centroids (x, y) of what is red and moves, the largest first."""
    levels = image.astype(np.int16)
    moving = np.abs(levels - still).max(2) > MOVING
    red = levels[..., 2] - levels[..., :2].max(2) > RED
    mask = cv2.morphologyEx((red & moving).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5)))
    count, _, stats, centroids = cv2.connectedComponentsWithStats(mask)
    large = [k for k in range(1, count) if stats[k, cv2.CC_STAT_AREA] > LEAST_PX]
    return [centroids[k] for k in sorted(large, key=lambda k: -stats[k, cv2.CC_STAT_AREA])]


def coat_in(images):
    """Where the coat is, by number of the image."""
    still = np.median(np.stack(images[::8]), 0).astype(np.int16)
    centres, last, columns = {}, None, None
    for number in range(FIRST, END):
        if number in COMES:
            columns = COMES[number]
        if number == LEAVES:
            last = columns = None
        things = red_things(images[number], still)
        if last is not None:
            reach = STEP_PX + 5 * (number - last - 1)
            distance = lambda thing: np.hypot(*(thing - centres[last]))
            things = sorted((thing for thing in things if distance(thing) < reach), key=distance)
        elif columns:
            things = [(x, y) for x, y in things if columns[0] <= x <= columns[1] and y < ENTERS_ABOVE]
        else:
            things = []
        if things:
            centres[number], last = np.array(things[0]), number
    return centres


def make_street(out, path, write_video, settings):
    images = read_video(path)
    centres = coat_in(images)
    name = "{:05d}.jpg".format
    encoded = {
        name(k): cv2.imencode(".jpg", images[k], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
        for k in range(FIRST, END)
    }
    labels = [(name(k), "coat", x, y) for k, (x, y) in centres.items()]
    write_video(out / "street", settings, encoded, labels)
