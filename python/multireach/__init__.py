"""Arms from URDF, the reaching controller, stereo vision, logs and LCM messages of multireach, with NumPy arrays.

    >>> import multireach
    >>> arm = multireach.Chain.from_robot("robots/hoap2")
    >>> law = multireach.GuardedLaw(arm)
    >>> law.start([0.2, -0.3, -0.2, -0.9])
    >>> law.set_target([0.1, -0.12, 0.1])
    <TargetResult.REACHABLE: 0>
    >>> trajectory = law.run(steps=420, every=7)      # 3 s at 140 steps a second; shape (60, 4)

Positions are in metres, angles in radians, times in seconds; `utime` is in microseconds. docs/python.md has more.
"""
import os as _os
import sys as _sys

# The extension, and LCM with it, must find this module's recvmsg() before the C library's: it drops datagrams that would crash LCM.
_flags = _sys.getdlopenflags()
_sys.setdlopenflags(_os.RTLD_NOW | _os.RTLD_DEEPBIND)
try:
    from . import _core
finally:
    _sys.setdlopenflags(_flags)

from ._core import (
    Bus,
    Chain,
    GuardedBatch,
    GuardedLaw,
    InputError,
    Log,
    LogEvent,
    MultiStartIk,
    Obstacle,
    Obstruction,
    OutputError,
    PaperLaw,
    TargetReport,
    TargetResult,
    TaskTarget,
    Vision,
    build,
    decode,
    dropped_datagrams,
    encode,
    images_of,
    read_image,
    replay,
    report,
)
from . import messages

__all__ = [
    "Bus", "Chain", "GuardedBatch", "GuardedLaw", "InputError", "Log", "LogEvent", "MultiStartIk", "Obstacle", "Obstruction",
    "OutputError", "PaperLaw", "TargetReport", "TargetResult", "TaskTarget", "Vision", "build", "decode", "dropped_datagrams", "encode",
    "images_of", "messages", "read_image", "replay", "report",
]
