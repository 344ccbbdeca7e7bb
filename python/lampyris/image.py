"""Spectral images: EXR in the layout of Fichet, Pacanowski & Wilkie (JCGT 10(3), 2021)."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field

import numpy as np
import OpenEXR

_BAND = re.compile(r"^S0\.(\d+),(\d+)nm$")
_PREFIX = "lampyris."


@dataclass
class Image:
    """One spectrum a pixel; row 0 is on top."""

    bands: np.ndarray
    """height x width x bands, float32."""
    wavelengths_nm: np.ndarray
    """Of the bands, ascending."""
    photometry: str
    """"absolute" or "relative"."""
    channels: dict[str, np.ndarray] = field(default_factory=dict)
    """Whatever else the file holds, by name: colors, error, samples."""
    metadata: dict[str, str] = field(default_factory=dict)
    """What made the image, in plain words."""

    @property
    def unit(self) -> str | None:
        """Of the bands; None where the image has no absolute scale."""
        return "W m^-2 sr^-1 nm^-1" if self.photometry == "absolute" else None

    @property
    def step_nm(self) -> float:
        """Between two bands."""
        return float(self.wavelengths_nm[1] - self.wavelengths_nm[0])

    @property
    def xyz(self) -> np.ndarray:
        """Tristimulus values, height x width x 3, as the file holds them (CIE 1931 2°)."""
        return np.stack([self.channels[f"CIE.{name}"] for name in "XYZ"], axis=-1)

    @property
    def luminance(self) -> np.ndarray:
        """Y of each pixel: cd/m² in absolute photometry."""
        return self.channels["CIE.Y"]

    def spectrum(self, x: int, y: int, width: int = 1, height: int = 1) -> np.ndarray:
        """The mean spectrum of a region (0-based, from the top left)."""
        part = self.bands[y : y + height, x : x + width]
        if part.shape[:2] != (height, width):
            rows, columns = self.bands.shape[:2]
            raise ValueError(
                f"region x = {x}, y = {y}, {width} x {height} leaves the image of {columns} x {rows} pixels"
            )
        return part.reshape(-1, part.shape[2]).mean(axis=0, dtype=np.float64)


def read_image(path: str | os.PathLike) -> Image:
    """The image of an EXR file that `image:save` or a sweep wrote.

    Raises ValueError for a file without spectral bands (such as one saved with ``bands = "none"``).
    """
    with OpenEXR.File(os.fspath(path), separate_channels=True) as file:
        header = dict(file.header())  # closing the file empties its own
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    bands = {}
    for name in list(channels):
        match = _BAND.match(name)
        if match:
            bands[float(f"{match[1]}.{match[2]}")] = channels.pop(name)
    if not bands:
        raise ValueError(f"{path}: holds no spectral bands (channels: {', '.join(sorted(channels))})")
    wavelengths = sorted(bands)
    scale = np.float32(header.get(_PREFIX + "band_scale", 1.0))
    stack = np.stack([bands[nm] for nm in wavelengths], axis=-1).astype(np.float32)
    metadata = {
        key[len(_PREFIX) :]: value for key, value in header.items() if key.startswith(_PREFIX)
    }
    return Image(
        bands=stack * scale,
        wavelengths_nm=np.array(wavelengths),
        photometry=metadata.pop("photometry", "relative"),
        channels=channels,
        metadata=metadata,
    )
