"""Radiance's own tools on our pictures, and on the photometric files that we read.

Usage: radiance.py files | compare DIRECTIONS.csv; the first writes b.ies and c.ies. Needs Radiance in the
path or the Python package pyradiance, and numpy.
"""

import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

import numpy

PACKAGE = importlib.util.find_spec("pyradiance")
if PACKAGE:
    folder = pathlib.Path(PACKAGE.origin).parent
    os.environ["PATH"] = f"{folder / 'bin'}:{os.environ['PATH']}"
    os.environ.setdefault("RAYPATH", f".:{folder / 'lib'}")

# Brighter to one side and up, so that a mirrored lamp is another.
SHAPES = {
    # Type B: Radiance takes both angles by their tangents, which are right along either axis only.
    "b.ies": (2, range(-60, 61, 5), range(-60, 61, 5), lambda h, v: 3 + numpy.sin(h) + 0.5 * numpy.sin(v)),
    "c.ies": (
        1,
        range(0, 361, 10),
        range(0, 181, 5),
        lambda h, v: (2 + numpy.cos(h - 0.5) * numpy.sin(v)) * (1 + numpy.cos(v)),
    ),
}


def write(name):
    kind, horizontal, vertical, shape = SHAPES[name]
    candela = lambda h, v: f"{100 * shape(numpy.radians(h), numpy.radians(v)):.6g}"
    lines = ["IESNA:LM-63-1995", "[TEST] none", "[LUMINAIRE] made", "TILT=NONE"]
    lines += [f"1 1000 1 {len(vertical)} {len(horizontal)} {kind} 2 0 0 0", "1 1 0"]
    lines += [" ".join(map(str, angles)) for angles in (vertical, horizontal)]
    lines += [" ".join(candela(h, v) for v in vertical) for h in horizontal]
    pathlib.Path(name).write_text("\n".join(lines) + "\n")


def radiance(command, given=None):
    return subprocess.run(command, shell=True, check=True, capture_output=True, input=given, text=True).stdout


def intensities(name, directions):
    """cd of a file by ies2rad, toward directions about nadir, -Z."""
    stem = name.split(".")[0]
    radiance(f"ies2rad -o {stem} {name} && oconv {stem}.rad > {stem}.oct")
    rays = "\n".join(" ".join(map(str, [*d, *-d])) for d in directions)
    seen = radiance(f"rtrace -h -ov -ab 0 {stem}.oct", rays)
    return numpy.array([float(line.split()[0]) for line in seen.splitlines()])


def note(what, error, limit):
    print(f"decoders: Radiance: {what}: off by {error:.2g} at most, allowed {limit:g}")
    assert error <= limit, what


def compare(table):
    # Weights and lm/W of Radiance are not CIE's: 0.14 % for white.
    brightness = float(radiance("pvalue -h -H -b -d even.hdr").split()[0])
    note("pvalue: luminance", abs(179 * brightness / 50 - 1), 0.01)
    view = "VIEW= -vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180"
    radiance(f"getinfo -a '{view}' < even.hdr > fisheye.hdr")
    # Its exit status is 1 even so.
    illuminance = float(radiance("evalglare -V fisheye.hdr || true").split()[0])
    note("evalglare: illuminance", abs(illuminance / (50 * numpy.pi) - 1), 0.01)

    # Even by solid angle.
    count = 20000
    z = 1 - (2 * numpy.arange(count) + 1) / count
    turn = numpy.arange(count) * numpy.pi * (3 - 5**0.5)
    directions = numpy.stack([numpy.sqrt(1 - z * z) * f(turn) for f in (numpy.cos, numpy.sin)] + [z], 1)
    for line in pathlib.Path(table).read_text().splitlines():
        name, *ours = line.split(",")
        weights = intensities(name, directions)
        if name == "b.ies":  # nothing beyond the file's angles
            angles = [numpy.arctan2(-directions[:, 1], -directions[:, 2]), numpy.arcsin(directions[:, 0])]
            weights = weights * (numpy.abs(numpy.degrees(angles)) <= 60).all(0)
        theirs = weights @ directions / weights.sum()
        # Our axis is +Z: turned about Y.
        turned = numpy.array([-theirs[0], theirs[1], -theirs[2]])
        error = numpy.abs(numpy.array(ours, float) - turned).max()
        # A mirrored lamp is off by 0.1 and more.
        note(f"{name}: mean direction", error, {"b.ies": 0.03, "c.ies": 0.005}[name])


if not shutil.which("ies2rad"):
    print("decoders: Radiance is not there", file=sys.stderr)
elif sys.argv[1] == "files":
    [write(name) for name in SHAPES]
else:
    compare(sys.argv[2])
