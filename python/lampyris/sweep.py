"""Sweeps: a folder of views with a manifest."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

from .image import Image, read_image


@dataclass
class View:
    """One view of a sweep."""

    name: str
    folder: Path
    details: dict
    """View, quality, statistics and regions, as the manifest has them."""

    @property
    def image(self) -> Image:
        """Read anew at each call."""
        return read_image(self.folder / f"{self.name}.exr")


@dataclass
class Sweep:
    """What a sweep's folder holds."""

    folder: Path
    manifest: dict
    views: list[View]

    def __iter__(self) -> Iterator[View]:
        return iter(self.views)

    def __len__(self) -> int:
        return len(self.views)


def read_sweep(folder: str | os.PathLike) -> Sweep:
    """The sweep in a folder; raises ValueError if its manifest is of another format."""
    folder = Path(folder)
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    form = str(manifest.get("format", ""))
    if not form.startswith("lampyris sweep"):
        raise ValueError(f"{folder / 'manifest.json'}: format is {form!r}, expected a sweep's")
    views = [View(entry["name"], folder, entry["details"]) for entry in manifest["views"]]
    return Sweep(folder, manifest, views)
