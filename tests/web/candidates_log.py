"""Writes a log with a TARGET_CANDIDATES after each TARGET: candidates_log.py TYPES IN OUT, where TYPES holds what `lcm-gen -p` wrote.

In the second half the target is AMBIGUOUS: two things are as good as one another, and a third is not."""
import struct
import sys

sys.path.insert(0, sys.argv[1])
from multireach import target_candidate_t, target_candidates_t, target_t  # noqa: E402

SYNC = 0xEDA1DA01
TERMS = ["still_score", "round_score", "colour_score", "stereo_score", "size_score", "history_score"]


def events(data):
    at = 0
    while at < len(data):
        sync, _, utime, channel, size = struct.unpack_from(">IqqII", data, at)
        assert sync == SYNC
        at += 28
        yield utime, data[at:at + channel].decode(), data[at + channel:at + channel + size]
        at += channel + size


def candidate(target, shift_m, shift_px, scores, chosen, reason):
    made = target_candidate_t()
    made.position_m = [target.position_m[0], target.position_m[1] + shift_m, target.position_m[2]]
    made.covariance_m2 = target.covariance_m2
    made.left_px = [target.left_px[0] + shift_px, target.left_px[1]]
    made.right_px = [target.right_px[0] + shift_px, target.right_px[1]]
    for term, score in zip(TERMS, scores):
        setattr(made, term, score)
    made.score = sum(scores)
    made.chosen = chosen
    made.reason = reason
    return made


with open(sys.argv[2], "rb") as source:
    all_events = list(events(source.read()))
middle = (all_events[0][0] + all_events[-1][0]) // 2
written = bytearray()
count = 0


def write(utime, channel, payload):
    global count
    written.extend(struct.pack(">IqqII", SYNC, count, utime, len(channel), len(payload)) + channel.encode() + payload)
    count += 1


for utime, channel, payload in all_events:
    if channel != "TARGET":
        write(utime, channel, payload)
        continue
    target = target_t.decode(payload)
    several = target_candidates_t()
    several.utime, several.sequence, several.run, several.name = target.utime, target.sequence, target.run, target.name
    ambiguous = utime > middle
    several.candidates = [
        candidate(target, 0, 0, [0, 2.4, 0.4, -0.1, -0.2, 0], not ambiguous, "others could be the target as well" if ambiguous else "chosen"),
        candidate(target, 0.08, 40, [0, 2.4, 0.4, -0.3, -0.4, 0] if ambiguous else [-3, 2.4, 0.1, -0.3, -0.4, 0], False,
                  "it could be the target as well" if ambiguous else "it was there before the target"),
        candidate(target, -0.08, -40, [-6, -1.2, 0.1, -0.2, -2, 0], False, "it belongs to the background"),
    ]
    several.num_candidates = len(several.candidates)
    if ambiguous:
        target.status, target.reason = target_t.STATUS_AMBIGUOUS, "several things could be the target"
    write(utime, channel, target.encode())
    write(utime, "TARGET_CANDIDATES", several.encode())
with open(sys.argv[3], "wb") as out:
    out.write(written)
