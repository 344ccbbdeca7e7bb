"""A pixel's spectrum, and its place in the chromaticity diagram.

    python python/examples/spectrum.py out/model1_00.exr
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import lampyris

image = lampyris.read_image(sys.argv[1])

# %% The brightest pixel's spectrum.
y, x = np.unravel_index(np.argmax(image.luminance), image.luminance.shape)
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5))
left.plot(image.wavelengths_nm, image.spectrum(x, y), color="firebrick")
left.set_xlabel("wavelength (nm)")
left.set_ylabel(f"radiance ({image.unit or 'relative'})")
left.set_title(f"pixel ({x}, {y})")

# %% All lit pixels in the chromaticity diagram.
xyz = image.xyz.reshape(-1, 3)
lit = xyz[xyz[:, 1] > 0.01 * xyz[:, 1].max()]
xy = lit[:, :2] / lit.sum(axis=1, keepdims=True)
cmf = Path(__file__).parents[2] / "data" / "cie" / "cie1931_2deg_cmf_5nm_380_780.csv"
locus = np.loadtxt(cmf, delimiter=",", skiprows=3)[:, 1:4]
locus = locus[:, :2] / locus.sum(axis=1, keepdims=True)
right.plot(*np.vstack([locus, locus[:1]]).T, color="black", linewidth=1, label="spectrum and purples")
srgb = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.64, 0.33]])
right.plot(*srgb.T, color="gray", label="sRGB")
right.plot(*xy.T, ".", markersize=2, label="lit pixels")
right.set_xlabel("x")
right.set_ylabel("y")
right.set_xlim(0, 0.8)
right.set_ylim(0, 0.9)
right.set_aspect("equal")
right.legend()
figure.tight_layout()
figure.savefig("spectrum.png", dpi=120)
