"""A Display P3 picture in Chromium: a page's canvas reads the digits that the file holds.

Usage: wide.py BROWSER PROFILE_FOLDER PNG. Needs nothing beyond Python's own library.
"""

import base64
import os
import struct
import sys
import time
import zlib

import drive

PAGE = """<!doctype html><img id="image" src="data:image/png;base64,%s"><script>
function digits(colorSpace) {
  const image = document.getElementById("image");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  const context = canvas.getContext("2d", { colorSpace });
  context.drawImage(image, 0, 0);
  return [...context.getImageData(3, 3, 1, 1, { colorSpace }).data].slice(0, 3);
}
</script>"""


def first_pixel(png):
    """Its 8-bit digits: in the first pixel of the first row every filter predicts 0."""
    data, place = b"", 8
    while place < len(png):
        length, kind = struct.unpack(">I4s", png[place : place + 8])
        if kind == b"IDAT":
            data += png[place + 8 : place + 8 + length]
        place += 12 + length
    assert png[24:26] == bytes([8, 2]), "8-bit RGB"
    return list(zlib.decompress(data)[1:4])


def main(browser, profile, path):
    png = open(path, "rb").read()
    page = os.path.join(os.path.dirname(path), "wide.html")
    with open(page, "w") as file:
        file.write(PAGE % base64.b64encode(png).decode())
    with drive.opened(browser, profile, "file://" + os.path.abspath(page)) as tab:
        end = time.monotonic() + 30
        while not tab.evaluate("document.images.length === 1 && document.images[0].complete"):
            assert time.monotonic() < end, "the page does not load"
            time.sleep(0.05)
        shown, narrow = (tab.evaluate(f"digits({space!r})") for space in ("display-p3", "srgb"))
    expected = first_pixel(png)
    assert all(abs(a - b) <= 1 for a, b in zip(shown, expected)), f"{shown}, expected {expected}"
    print("page: digits", shown, "in the file", expected, "in sRGB", narrow)
    # The color is one that sRGB does not hold.
    assert narrow != shown and 0 in narrow, narrow


main(*sys.argv[1:])
