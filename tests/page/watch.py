"""Edits a script under `lampyris watch` and reads the page in Chromium.

Usage: watch.py BROWSER PROFILE_FOLDER PROGRAM. Needs nothing beyond Python's own library.
"""

import os
import re
import subprocess
import sys
import tempfile
import time

from drive import opened

SCRIPT = """
local lampyris = require "lampyris"
local reflectance = 0.5
local mesh = lampyris.mesh.surface { nu = 4, nv = 4,
  point = function(u, v) return 20 * u - 10, 20 * v - 10, 0 end }
local scene = lampyris.scene {
  objects = { { mesh = mesh, material = lampyris.material { reflectance = reflectance, k_d = 1 } } },
  lights = { lampyris.cylinder { center = { 0, 0, 30 }, axis = { 0, 1, 0 }, radius = 1, length = 4,
    samples = 200, flux = 100, spectrum = lampyris.spectrum.blackbody(2856) } },
}
local image = scene:render(lampyris.view { distance = 200, fov = 8, width = 320, height = 240 })
image:save("sheet.png", { exposure = 1 })
print("reflectance is " .. reflectance)
"""

# The middle pixel of the picture as the browser shows it, and how much smaller the picture is.
SHOWN = """(() => {
  const figure = document.querySelector("figure"), image = figure && figure.querySelector("img");
  if (!image || !image.complete || !image.naturalWidth) return "nothing";
  const canvas = new OffscreenCanvas(1, 1).getContext("2d");
  canvas.drawImage(image, image.naturalWidth / 2, image.naturalHeight / 2, 1, 1, 0, 0, 1, 1);
  const [red] = canvas.getImageData(0, 0, 1, 1).data;
  const text = (id) => document.getElementById(id).textContent;
  return [figure.dataset.shrink, image.naturalWidth, red, text("status"), text("text"), text("message")].join("|");
})()"""


def wait(tab, wanted, seconds=60):
    end = time.monotonic() + seconds
    while True:
        shown = tab.evaluate(SHOWN)
        if wanted(shown.split("|")):
            return shown.split("|")
        assert time.monotonic() < end, shown
        time.sleep(0.02)


def is_done(text):
    return lambda s: len(s) > 5 and s[0] == "1" and s[1] == "320" and "done" in s[3] and text in s[4]


def check(tab, script):
    def edit(old, new):
        with open(script, "w") as file:
            file.write(SCRIPT.replace(old, new))

    bright = wait(tab, is_done("reflectance is 0.5"))
    edit("reflectance = 0.5", "reflectance = 0.05")
    dark = wait(tab, is_done("reflectance is 0.05"))
    assert int(dark[2]) < int(bright[2]), (bright, dark)
    edit("reflectance = 0.5", "reflectance = 50")
    failed = wait(tab, lambda s: len(s) > 5 and "failed" in s[3])
    assert re.search(r"script.lua:\d+: material: .*50", failed[5]), failed
    edit("reflectance = 0.5", "reflectance = 0.25")
    wait(tab, is_done("reflectance is 0.25"))


def main(browser, profile, program):
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, "script.lua")
        with open(script, "w") as file:
            file.write(SCRIPT)
        command = [program, "watch", "script.lua", "--quiet"]
        watched = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
        try:
            address = re.search(r"http://\S+", watched.stdout.readline())[0]
            with opened(browser, profile, address) as tab:
                check(tab, script)
        finally:
            watched.kill()
            watched.wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
