"""Files of local git clones, and the folders that are made of them."""
import io
import pathlib
import shutil
import subprocess

import cv2
import numpy as np
import scipy.io


class PrepareError(Exception):
    """A fault that the user can act on."""


class Clone:
    """A local git repository; files are read from one commit."""

    def __init__(self, path, revision="HEAD"):
        self.path = path
        if not pathlib.Path(path).is_dir():
            raise PrepareError(f"{path} is not a folder. Give the folder of a git clone.")
        self.revision = revision
        self.commit = self._git("rev-parse", "--verify", f"{revision}^{{commit}}").decode().strip()

    def _git(self, *arguments):
        done = subprocess.run(["git", "-C", str(self.path), *arguments], capture_output=True, check=False)
        if done.returncode != 0:
            why = done.stderr.decode(errors="replace").strip()
            advice = f"Give a complete clone of the repository, not a shallow one: commit {self.revision} is read."
            raise PrepareError(f"{self.path}: git {arguments[0]} failed: {why}\n{advice}")
        return done.stdout

    def files(self, folder, ending):
        """Paths in `folder` that end with `ending`, sorted."""
        names = self._git("ls-tree", "-r", "-z", "--full-tree", "--name-only", self.commit, f"{folder}/")
        found = sorted(name for name in names.decode().split("\0") if name.endswith(ending))
        if not found:
            raise PrepareError(f"{self.path}: commit {self.commit[:7]} has no {ending} file in {folder}/.")
        return found

    def read(self, path):
        return self._git("cat-file", "blob", f"{self.commit}:{path}")

    def text(self, path):
        return self.read(path).decode("utf-8-sig")

    def mat(self, path):
        return scipy.io.loadmat(io.BytesIO(self.read(path)))


def file_name(path):
    return path.rsplit("/", 1)[-1]


def decode(data):
    """The pixels of an image file's bytes."""
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if pixels is None:
        raise PrepareError("An image of the clone cannot be decoded (a Git LFS pointer?). Give a complete clone.")
    return pixels


def rig_lines(size, cameras, rotation, translation):
    """The section `cameras` of a set.yaml. `cameras`: matrix and distortion of the left and of the right camera."""
    lines = ["cameras:"]
    for side, (matrix, distortion) in zip(("left", "right"), cameras):
        values = dict(width_px=size[0], height_px=size[1], fx_px=matrix[0, 0], fy_px=matrix[1, 1], cx_px=matrix[0, 2], cy_px=matrix[1, 2])
        listed = ", ".join(f"{key}: {value:.7g}" for key, value in values.items())
        lines.append(f"  {side}: {{{listed}, distortion: [{', '.join(f'{value:.7g}' for value in distortion)}]}}")
    listed = ", ".join(f"{value:.9f}" for value in rotation.ravel())
    moved = ", ".join(f"{value:.7f}" for value in translation)
    return [*lines, f"  left_to_right: {{rotation: [{listed}], translation_m: [{moved}]}}"]


MADE_HERE = "made-by-prepare.py"


def new_folder(folder):
    """An empty folder. One of an earlier run is replaced, anything else is left untouched."""
    if folder.exists():
        if not (folder / MADE_HERE).is_file():
            raise PrepareError(f"{folder} exists and has no {MADE_HERE}, so this script did not make it. Remove it first.")
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    (folder / MADE_HERE).touch()
    return folder
