"""Checks what multireach-page --drake has sent: drake_viewer.py TYPES LOG, where TYPES holds what `lcm-gen -p` wrote."""
import struct
import sys

sys.path.insert(0, sys.argv[1])
from drake import lcmt_viewer_draw, lcmt_viewer_geometry_data, lcmt_viewer_load_robot  # noqa: E402

failures = []


def check(holds, sentence):
    if not holds:
        failures.append(sentence)


# As published: the first eight bytes of each DRAKE_VIEWER_DRAW of Drake.
check(lcmt_viewer_draw._get_packed_fingerprint() == bytes.fromhex("414f0bfe5b2f4244"), "the fingerprint of lcmt_viewer_draw is not Drake's")

loads, draws, at = [], [], 0
data = open(sys.argv[2], "rb").read()
while at + 28 <= len(data):
    _, _, utime, channel, size = struct.unpack_from(">IqqII", data, at)
    at += 28
    name, payload = data[at:at + channel].decode(), data[at + channel:at + channel + size]
    at += channel + size
    if name == "DRAKE_VIEWER_LOAD_ROBOT":
        loads.append(lcmt_viewer_load_robot.decode(payload))
    if name == "DRAKE_VIEWER_DRAW":
        draws.append((utime, lcmt_viewer_draw.decode(payload)))

check(len(loads) >= 3, f"{len(loads)} loads; expected one at the start, one for the obstacle, and repetitions")
check(50 <= len(draws) <= 35 * 11, f"{len(draws)} drawings in 9 s")
names = [link.name for link in loads[-1].link]
check(names[:2] == ["torso", "right_SFE"] and "obstacle 1" in names, f"links {names}")
check(all(link.num_geom == len(link.geom) for link in loads[-1].link), "numbers of shapes")
capsules = [shape for link in loads[-1].link for shape in link.geom if shape.type == lcmt_viewer_geometry_data.CAPSULE]
check(len(capsules) >= 2 and all(abs(shape.float_data[0] - 0.02) < 1e-6 for shape in capsules), "links are no capsules of 20 mm, as in robot.yaml")
utime, last = draws[-1]
check(last.link_name == names, f"drawn {last.link_name}")
check(last.num_links == len(last.position) == len(last.quaternion) == len(last.robot_num), "lengths")
check(all(abs(sum(x * x for x in q) - 1) < 1e-5 for q in last.quaternion), "quaternions are not of length 1")
obstacle = names.index("obstacle 1")
check(max(abs(a - b) for a, b in zip(last.position[obstacle], [0.3, 0.1, 0.2])) < 1e-6, f"the obstacle is at {last.position[obstacle]}")
check(abs(loads[-1].link[obstacle].geom[0].float_data[0] - 0.05) < 1e-6, "the obstacle's radius")
check(abs(last.timestamp - utime / 1000) < 2000, "the time is not in milliseconds")
print(f"{len(loads)} loads, {len(draws)} drawings, links {', '.join(names)}")
for sentence in failures:
    print(f"FAILED: {sentence}")
sys.exit(1 if failures else 0)
