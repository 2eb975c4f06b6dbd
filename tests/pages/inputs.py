"""Folders in which scenes are played: a copy of the project that runs the programs under test, with the files that the pages name."""
import os
import shutil
import struct
import subprocess

from page_text import ROOT, SCRIPTS, project_files


def mcap_of_ros2(path, topics):
    """An MCAP file without chunks, of `sensor_msgs/msg/CompressedImage`: for each topic, (time in ns, JPEG) for each message."""
    def text(words):
        data = words.encode()
        return struct.pack("<I", len(data)) + data

    def record(opcode, data):
        return struct.pack("<BQ", opcode, len(data)) + data

    def cdr_text(words):
        data = words.encode() + b"\0"
        return struct.pack("<I", len(data)) + data

    def image(time_ns, jpeg):
        data = struct.pack("<iI", time_ns // 10**9, time_ns % 10**9) + cdr_text("camera")
        data += bytes(-len(data) % 4) + cdr_text("jpeg")
        return b"\0\1\0\0" + data + bytes(-len(data) % 4) + struct.pack("<I", len(jpeg)) + jpeg

    magic = b"\x89MCAP0\r\n"
    data = magic + record(1, text("ros2") + text("")) + record(3, struct.pack("<H", 1) + text("sensor_msgs/msg/CompressedImage") + text("ros2msg") + text(""))
    for channel, (topic, messages) in enumerate(topics.items(), 1):
        data += record(4, struct.pack("<HH", channel, 1) + text(topic) + text("cdr") + struct.pack("<I", 0))
        for k, (time_ns, jpeg) in enumerate(messages):
            data += record(5, struct.pack("<HIQQ", channel, k, time_ns, time_ns) + image(time_ns, jpeg))
    path.write_bytes(data + record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + magic)


def matrix(name, rows, columns, numbers):
    return f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {', '.join(map(str, numbers))} ]\n"


def write_inputs(folder, bin_folder):
    """What the commands read, in an empty folder; the pages say how a reader comes by each."""
    def call(*words):
        subprocess.run([bin_folder / words[0], *words[1:]], cwd=folder, check=True, capture_output=True)

    for name in ("run.lcm", "live.lcm"):
        shutil.copy(ROOT / "logs/load.lcm", folder / name)
    call("multireach-log", "cut", ROOT / "logs/reach.lcm", "-o", "session.lcm", "--until", "1")
    call("multireach-log", "cut", ROOT / "logs/reach.lcm", "-o", "other.lcm", "--until", "6")
    unfinished = folder / "home/.local/state/multireach/runs/DATE_TIME.PID"
    unfinished.mkdir(parents=True)
    call("multireach-log", "filter", "run.lcm", "-o", unfinished / "session.lcm", "--channel", "STEREO_IMAGES", "TARGET_TRUTH")
    call("multireach-log", "filter", "run.lcm", "-o", unfinished / "control.lcm", "--channel", "STEREO_IMAGES", "TARGET_TRUTH", "--without")
    for name in ("old.lcm", "new.lcm"):
        call("multireach-replay", "run", "session.lcm", "--robot", ROOT / "robots/hoap2", "-o", name)

    # Images: files with times, a folder as of EuRoC, a recording of ROS 2, and videos, which are also cameras.
    call("multireach-log", "export", "pairs", "session.lcm", "-o", "pictures")
    call("multireach-log", "export", "euroc", "session.lcm", "-o", "MH_01_easy")
    call("multireach-log", "images", "session.lcm", "-o", "png", "--channel", "STEREO_IMAGES")
    sides = {side: sorted((folder / "pictures").glob(f"{side}/*.jpg")) for side in ("left", "right")}
    mcap_of_ros2(folder / "run.mcap", {f"/{side}/image_raw": [(10**18 + k * 33_333_333, path.read_bytes()) for k, path in enumerate(paths)]
                                       for side, paths in sides.items()})
    for side in sides:
        shutil.copy(folder / f"png/000000_{side}.png", folder / f"{side}.png")
        call("multireach-test-video", "avi", f"{side}.avi", "300", "320", "240")
        shutil.copy(folder / f"{side}.avi", folder / f"{side}.mp4")  # what is in a video is not told by its name
    (folder / "cameras.yaml").write_text("left: left.avi\nright: right.avi\nwidth_px: 320\nheight_px: 240\n")

    # Configurations.
    (folder / "its").mkdir()
    for name in ("vision.yaml", "its/vision.yaml"):
        shutil.copy(ROOT / "robots/hoap2/vision.yaml", folder / name)
    shutil.copy(ROOT / "robots/ur5e/ur5e.urdf", folder / "FILE.urdf")
    head = "%YAML:1.0\n---\n"
    intrinsics = "".join(matrix(f"M{k}", 3, 3, (600, 0, 320, 0, 600, 240, 0, 0, 1)) + matrix(f"D{k}", 1, 5, (0.1, -0.2, 0, 0, 0)) for k in (1, 2))
    extrinsics = matrix("R", 3, 3, (1, 0, 0, 0, 1, 0, 0, 0, 1)) + matrix("T", 3, 1, (-60, 0, 0))
    for name, text in (("stereo", intrinsics + extrinsics), ("intrinsics", intrinsics), ("extrinsics", extrinsics)):
        (folder / f"{name}.yml").write_text(head + text)


def make_folder(folder, inputs, bin_folder):
    """A copy of the project, with the inputs, in which nothing is to be built: tools/setup.sh does nothing."""
    for name in project_files(ROOT):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target)
    shutil.copytree(inputs, folder, dirs_exist_ok=True)
    (folder / "tools/setup.sh").write_text("#!/bin/sh\n# Everything is built.\n")
    (folder / "build").mkdir()
    (folder / "build/release").symlink_to(bin_folder.parent)
    (folder / "build/web").symlink_to(bin_folder.parents[1] / "web")
    installed = folder / "installed"
    installed.mkdir()
    for name, script in {**SCRIPTS, "multireach": "tools/multireach"}.items():
        (installed / name).symlink_to(folder / script)
    return dict(os.environ, HOME=str(folder / "home"), PATH=os.pathsep.join([str(installed), str(folder / "build/release/bin"), os.environ["PATH"]]))


def is_there(need, bin_folder):
    """A program, the page, or a path in the folder of the build."""
    if need == "page":
        return (bin_folder / "multireach-page").exists() and (bin_folder.parents[1] / "web/index.html").exists()
    return bool(shutil.which(need)) or (bin_folder.parent / need).exists()
