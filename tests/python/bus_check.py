"""What test_bus.py runs in a network namespace of its own: messages between two buses, datagrams that would crash LCM, and keys."""
import hashlib
import os
import socket
import struct
import sys
import tempfile

import numpy as np

import multireach
from multireach import messages

GROUP, PORT = "239.255.77.9", 8018
URL = f"udpm://{GROUP}:{PORT}?ttl=0"


def send_datagram(data):
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.sendto(data, (GROUP, PORT))
    sender.close()


def arrives(sender, channel, message, receiver):
    """Sends until it arrives: on a busy machine the network may drop a packet, and LCM does not send it again."""
    for _ in range(20):
        sender.publish(channel, message)
        if receiver.handle(1) >= 1:
            while receiver.handle(0.2):
                pass
            return True
    return False


def key_file(folder, name):
    line = "multireach-key-1:" + hashlib.blake2b(name.encode(), digest_size=32).hexdigest()
    line += ":" + hashlib.blake2b(line.encode(), digest_size=16).hexdigest()[:8]
    path = os.path.join(folder, name)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT, 0o600), "w") as file:
        file.write(line)
    return path


def check_keys(sent):
    """A bus with a key refuses what is unsigned or of another key; one without reads what is signed."""
    with tempfile.TemporaryDirectory() as folder:
        mine, other = key_file(folder, "mine"), key_file(folder, "other")
        plain, signed, keyed, stranger = multireach.Bus(URL), multireach.Bus(URL, key=mine), multireach.Bus(URL, key=mine), multireach.Bus(URL, key=other)
        for_keyed, for_plain = [], []
        keyed.subscribe("TARGET", lambda channel, message: for_keyed.append(message))
        plain.subscribe("TARGET", lambda channel, message: for_plain.append(message))
        keyed.handle(0)
        for unwelcome in (plain, stranger):
            before = keyed.refused
            for _ in range(20):
                unwelcome.publish("TARGET", sent)
                keyed.handle(0.2)
                if keyed.refused > before:
                    break
            assert keyed.refused > before and not for_keyed, (keyed.refused, for_keyed)
        assert arrives(signed, "TARGET", sent, keyed) and for_keyed[-1] == sent
        assert arrives(signed, "TARGET", sent, plain) and for_plain[-1] == sent and plain.refused == 0
        os.chmod(mine, 0o644)
        try:
            multireach.Bus(URL, key=mine)
        except multireach.InputError as error:
            assert "chmod 600" in str(error)
        else:
            raise AssertionError("a key that others may read was used")


def main():
    sender, receiver = multireach.Bus(URL), multireach.Bus(URL)
    got = []
    receiver.subscribe("TARGET", lambda channel, message: got.append((channel, message)))
    receiver.subscribe("STEREO_IMAGES", lambda channel, message: got.append((channel, message)))
    sent = messages.target_t(name="mine", position_m=np.array([0.1, -0.12, 0.1]), sequence=7)
    assert arrives(sender, "TARGET", sent, receiver) and got[-1] == ("TARGET", sent), got
    picture = messages.images_t(utime=5, image_types=[0], images=[messages.image_t(data=np.arange(200000, dtype=np.uint8) % 251)])
    assert arrives(sender, "STEREO_IMAGES", picture, receiver) and got[-1][1] == picture  # in fragments, on the other group

    # A fragment whose end overflows 32 bits, and a channel's name without an end: LCM alone writes beyond its memory.
    before = multireach.dropped_datagrams()
    send_datagram(struct.pack(">IIIIHH", 0x4C433033, 1, 1000, 0xFFFFFF00, 1, 2) + bytes(1000))
    send_datagram(struct.pack(">II", 0x4C433032, 2) + b"A" * 200)
    assert receiver.handle(0.3) == 0
    # Both buses hear the group.
    dropped = multireach.dropped_datagrams() - before
    assert dropped >= 2, f"{dropped} datagrams dropped"
    for _ in range(20):
        sender.publish("TARGET", b"no message")
        receiver.handle(0.3)
        if receiver.malformed:
            break
    assert receiver.malformed >= 1
    assert arrives(sender, "TARGET", multireach.encode(sent), receiver)

    # An exception of a handler is raised by handle(), and the bus goes on.
    failing = multireach.Bus(URL)

    def refuse(channel, message):
        raise KeyError("refused")

    failing.subscribe("TARGET", refuse)
    try:
        arrives(sender, "TARGET", sent, failing)
    except KeyError as error:
        assert error.args == ("refused",)
    else:
        raise AssertionError("the exception of a handler was lost")
    check_keys(sent)
    print("all held")


sys.exit(main())
