"""Logs against a reader of their own, by the struct module."""
import struct

import numpy as np
import pytest

import multireach


def events_of(path):
    """(number, utime, channel, data) of every event of an undamaged log."""
    content, at = path.read_bytes(), 0
    while at < len(content):
        mark, number, utime, channel, size = struct.unpack_from(">IqqII", content, at)
        assert mark == 0xEDA1DA01
        at += 28
        yield number, utime, content[at:at + channel].decode(), content[at + channel:at + channel + size]
        at += channel + size


def test_events(root):
    log = multireach.Log(root / "logs/reach.lcm")
    expected = list(events_of(root / "logs/reach.lcm"))
    found = [(event.number, event.utime, event.channel, event.data.tobytes()) for event in log]
    assert found == expected
    assert log.channels() == {channel: sum(event[2] == channel for event in expected) for channel in {event[2] for event in expected}}
    assert [event.number for event in log.events(["TARGET_TRUTH"])] == [e[0] for e in expected if e[2] == "TARGET_TRUTH"]


def test_data_outlive_the_log_and_are_not_writable(root):
    data = next(iter(multireach.Log(root / "logs/reach.lcm"))).data
    assert data.tobytes() == next(events_of(root / "logs/reach.lcm"))[3]
    with pytest.raises(ValueError):
        data[0] = 1


def test_columns(root):
    """target_t begins with its fingerprint, seven int64, the status, and two texts."""
    columns = multireach.Log(root / "logs/reach.lcm").columns("TARGET_TRUTH")
    rows = []
    for _, utime, channel, data in events_of(root / "logs/reach.lcm"):
        if channel != "TARGET_TRUTH":
            continue
        integers = struct.unpack_from(">7q", data, 8)
        status, length = struct.unpack_from(">bi", data, 64)
        name = data[69:69 + length - 1].decode()
        at = 69 + length
        at += 4 + struct.unpack_from(">i", data, at)[0]
        rows.append((utime, *integers, status, name, struct.unpack_from(">3d", data, at), struct.unpack_from(">9d", data, at + 48)))
    assert len(rows) == 756
    utimes, utime, sequence, run, *_ = zip(*rows)
    np.testing.assert_array_equal(columns["log_utime"], utimes)
    np.testing.assert_array_equal(columns["utime"], utime)
    np.testing.assert_array_equal(columns["sequence"], sequence)
    np.testing.assert_array_equal(columns["status"], [row[8] for row in rows])
    assert list(columns["name"]) == [row[9] for row in rows]
    np.testing.assert_array_equal(columns["position_m"], [row[10] for row in rows])
    assert columns["covariance_m2"].shape == (756, 3, 3)
    np.testing.assert_array_equal(columns["covariance_m2"].reshape(756, 9), [row[11] for row in rows])


def test_columns_are_the_fields_of_the_messages(root):
    log = multireach.Log(root / "logs/load.lcm")
    for channel in ("JOINT_COMMAND", "CONTROLLER_STATE", "NODE_STATUS", "STEREO_IMAGES"):
        messages = [event.message for event in log.events([channel])]
        columns = log.columns(channel)
        for name in messages[0].fields:
            if name not in columns:
                continue
            for row, message in zip(columns[name], messages):
                np.testing.assert_array_equal(row, getattr(message, name), err_msg=f"{channel}.{name}")
    assert "images[0].data" not in log.columns("STEREO_IMAGES")
    assert list(log.columns("STEREO_IMAGES", fields=["images[1].utime"])) == ["images[1].utime"]


def test_damaged_logs_are_read(root):
    assert sum(1 for _ in multireach.Log(root / "logs/damaged.lcm")) > 1000


def test_errors_are_sentences(root, tmp_path):
    with pytest.raises(KeyError, match="no message on channel 'NOTHING'"):
        multireach.Log(root / "logs/reach.lcm").columns("NOTHING")
    (tmp_path / "no.lcm").write_text("no log")
    with pytest.raises(multireach.InputError, match="no.lcm"):
        multireach.Log(tmp_path / "no.lcm")
