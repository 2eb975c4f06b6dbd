#!/usr/bin/env python3
"""Repeats a log, its times going on, until it has so many events: repeat_log.py IN EVENTS OUT."""
import struct
import sys

SYNC, HEADER = 0xEDA1DA01, 28


def main():
    source, wanted, target = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    with open(source, "rb") as file:
        data = file.read()
    events, at = [], 0
    while at < len(data):
        _, _, utime, channel, size = struct.unpack_from(">IqqII", data, at)
        end = at + HEADER + channel + size
        events.append((utime, data[at + 20:end]))
        at = end
    turn_us = events[-1][0] - events[0][0] + 1000
    with open(target, "wb") as out:
        for number in range(wanted):
            turn, k = divmod(number, len(events))
            out.write(struct.pack(">Iqq", SYNC, number, events[k][0] + turn * turn_us) + events[k][1])


main()
