"""Reads what Lampyris writes (images, sweeps, studies), and runs it."""

from .image import Image, read_image
from .program import LampyrisError, run
from .study import Study, read_study
from .sweep import Sweep, View, read_sweep

__all__ = [
    "Image",
    "LampyrisError",
    "Study",
    "Sweep",
    "View",
    "read_image",
    "read_study",
    "read_sweep",
    "run",
]
