"""Decodes the patches of patches.lua and compares their light. Usage: check.py patches.csv"""

import csv
import shutil
import subprocess
import sys
import warnings

warnings.simplefilter("ignore")  # of optional parts of the library

import colour
import numpy
import OpenImageIO as oiio

try:
    import OpenEXR
except ImportError:
    OpenEXR = None

REC709 = colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_RGB_to_XYZ
REC2020 = colour.RGB_COLOURSPACES["ITU-R BT.2020"].matrix_RGB_to_XYZ
# cd/m² of the displays, by default.
PEAK = 1000
P3 = colour.RGB_COLOURSPACES["Display P3"].matrix_RGB_to_XYZ


def pixels(path, kind=oiio.FLOAT):
    image = oiio.ImageBuf(path)
    assert not image.has_error, image.geterror()
    values = image.get_pixels(kind)
    assert (values == values[0, 0]).all(), f"{path}: a patch is not even"
    return image, values[0, 0].astype(float)


def png(path, matrix, points):
    data = open(path, "rb").read()
    place = data.index(b"cICP")
    assert tuple(data[place + 4 : place + 8]) == points, f"{path}: cICP"
    digits = pixels(path, oiio.UINT16)[1] / 65535
    if points[1] == 16:
        return matrix @ colour.models.eotf_ST2084(digits)
    return matrix @ colour.models.eotf_sRGB(digits) * 80


def itp(xyz):
    rgb = numpy.linalg.inv(REC2020) @ xyz
    return colour.RGB_to_ICtCp(numpy.maximum(rgb, 0), L_p=10000)


def delta_e_itp(a, b):
    difference = itp(a) - itp(b)
    difference[1] /= 2
    return 720 * numpy.linalg.norm(difference)


def pfs_rgb(path):
    """What pfstools reads of the first pixel, linear Rec. 709."""
    reader = "pfsinexr" if path.endswith(".exr") else "pfsintiff"
    subprocess.run(f"{reader} {path} | pfsoutpfm pfs.pfm", shell=True, check=True, capture_output=True)
    _, _, scale, data = open("pfs.pfm", "rb").read().split(b"\n", 3)
    return numpy.frombuffer(data[:12], "<f4" if float(scale) < 0 else ">f4").astype(float)


# Of each kind of band: the compression, the type of a band, and its relative error.
EXR_BANDS = {
    ".exr": ("ZIP_COMPRESSION", "float32", 1e-6),
    "_half.exr": ("ZIP_COMPRESSION", "float16", 2**-11),
    "_pxr24.exr": ("PXR24_COMPRESSION", "float32", 2**-16),
    "_none.exr": ("ZIP_COMPRESSION", None, 0),
}


def color_error(ending):
    """PXR24 keeps 24 bits of a float, of the colors too."""
    return 2**-16 if ending == "_pxr24.exr" else 1e-6


def openexr(path, row, worst):
    """The same by OpenEXR's own library: it names compression and types, and reads the bands."""
    ending = path[len(row["name"]) :]
    compression, kind, limit = EXR_BANDS[ending]
    color_limit = color_error(ending)
    with OpenEXR.File(path, separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        assert header["compression"] == getattr(OpenEXR, compression), header["compression"]
        primaries = numpy.array(header["chromaticities"], float).ravel()
        rec709 = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]
        assert abs(primaries - rec709).max() < 1e-4, primaries
        assert header["whiteLuminance"] == 1, header["whiteLuminance"]
        luminance = float(channels["CIE.Y"].pixels[0, 0])
        worst.note(f"OpenEXR: Y{ending}", abs(luminance / float(row["Y"]) - 1), color_limit)
        bands = [channel for channel in channels if channel.startswith("S0.")]
        assert len(bands) == (81 if kind else 0), bands
        if kind:
            band = channels["S0.600,000000nm"].pixels
            assert band.dtype == kind, band.dtype
            scale = float(header.get("lampyris.band_scale", 1))
            value = float(band[0, 0]) * scale
            worst.note(f"OpenEXR: band{ending}", abs(value / float(row["600nm"]) - 1), limit)


class Worst(dict):
    def note(self, what, value, limit):
        self[what] = max(self.get(what, (0, limit)), (value, limit))


def check(row, worst):
    name = row["name"]
    xyz = numpy.array([float(row[c]) for c in "XYZ"])
    relative = lambda luminance: abs(luminance / xyz[1] - 1)
    for display, matrix, points in [
        ("rec2020_pq", REC2020, (9, 16, 0, 1)),
        ("p3_pq", P3, (12, 16, 0, 1)),
    ]:
        shown = png(f"{name}_{display}.png", matrix, points)
        rgb = numpy.linalg.inv(matrix) @ xyz
        if rgb.min() >= 0 and rgb.max() <= PEAK:
            worst.note(f"{display}: luminance", relative(shown[1]), 0.005)
            worst.note(f"{display}: ΔE_ITP", delta_e_itp(shown, xyz), 1)
    if (numpy.linalg.inv(P3) @ xyz).min() >= 0 and xyz[1] * 0.1 < 80 / 4:
        shown = png(f"{name}_p3.png", P3, (12, 13, 0, 1)) / 0.1
        worst.note("p3: luminance", relative(shown[1]), 0.005)
    for ending in [".exr", "_half.exr", "_pxr24.exr", "_none.exr"]:
        image, _ = pixels(name + ending)
        spec = image.spec()
        values = dict(zip(spec.channelnames, image.getpixel(0, 0)))
        rgb = numpy.array([values[c] for c in "RGB"])
        worst.note("EXR: RGB", relative((REC709 @ rgb)[1]), 0.01)
        worst.note(f"EXR: Y{ending}", relative(values["CIE.Y"]), color_error(ending))
        assert spec.get_float_attribute("whiteLuminance") == 1, "whiteLuminance"
        assert spec.getattribute("chromaticities") is not None, "chromaticities"
        if OpenEXR:
            openexr(name + ending, row, worst)
    if shutil.which("pfsinexr"):
        for ending in [".exr", "_half.exr", ".tif"]:
            luminance = (REC709 @ pfs_rgb(name + ending))[1]
            worst.note(f"pfstools: {ending}", relative(luminance), 0.01)
    # Radiance's own weights and lm/W.
    rgb = pixels(f"{name}.hdr")[1]
    worst.note("Radiance: luminance", relative(179 * rgb @ [0.265, 0.670, 0.065]), 0.01)
    rgb = pixels(f"{name}.tif")[1]
    worst.note("TIFF: luminance", relative((REC709 @ rgb)[1]), 0.001)


def main(table):
    worst = Worst()
    rows = list(csv.DictReader(open(table)))
    assert len(rows) == 20
    for row in rows:
        check(row, worst)
    for what, (value, limit) in worst.items():
        print(f"decoders: {what}: off by {value:.2g} at most, allowed {limit:g}")
        assert value <= limit, what


main(*sys.argv[1:])
