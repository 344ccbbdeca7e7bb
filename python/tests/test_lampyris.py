"""What the program writes is what the package reads. LAMPYRIS names the built program."""

import os

import numpy as np
import pytest

import lampyris

SCRIPT = """
local lampyris = require "lampyris"
local mirror = lampyris.mesh.surface { nu = 12, nv = 12, point = function(u, v)
  local x, y = 80 * u - 40, 80 * v - 40
  return x, y, (x * x + y * y) / 80
end }
local scene = lampyris.scene {
  objects = { { mesh = mirror, material = lampyris.material { reflectance = 0.8, k_d = 0.9, k_s = 0.1, n_s = 20 } } },
  lights = { lampyris.cylinder { center = { 0, 0, 20 }, radius = 0.5, length = 5, flux = 100,
    samples = 200, spectrum = lampyris.spectrum.illuminant "E" } },
  photometry = "absolute", shadows = false,
}
local view = lampyris.view { distance = 800, fov = 7, width = 12, height = 8 }
local image = scene:render(view, { samples = 1 })
image:save "one.exr"
print(("%.9g"):format(image:luminance { x = 5, y = 3 }))
print(("%.9g"):format(image:spectrum { x = 5, y = 3 }:at(600)))
lampyris.sweep { scene = scene, views = { view }, output = "sweep", quality = { samples = 1 } }
lampyris.study { parameters = { a = { uniform = { 0, 1 } } }, samples = 4, output = "study",
  run = function(p) return { twice = 2 * p.a } end }
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    if "LAMPYRIS" not in os.environ:
        pytest.skip("LAMPYRIS does not name the program")
    folder = tmp_path_factory.mktemp("made")
    (folder / "script.lua").write_text(SCRIPT)
    printed = lampyris.run(folder / "script.lua", out=folder)
    return folder, [float(line) for line in printed.split()[:2]]


def test_image(made):
    folder, (luminance, at_600) = made
    image = lampyris.read_image(folder / "one.exr")
    assert image.bands.shape == (8, 12, 81) and image.bands.dtype == np.float32
    assert image.wavelengths_nm[0] == 380 and image.step_nm == 5
    assert image.unit == "W m^-2 sr^-1 nm^-1"
    # f32 in the file.
    assert image.luminance[3, 5] == pytest.approx(luminance, rel=1e-6)
    assert image.spectrum(5, 3)[44] == pytest.approx(at_600, rel=1e-6)
    assert "quality" in image.metadata
    with pytest.raises(ValueError, match="leaves the image of 12 x 8 pixels"):
        image.spectrum(10, 0, width=3)


def test_sweep(made):
    sweep = lampyris.read_sweep(made[0] / "sweep")
    assert len(sweep) == 1 and sweep.views[0].details["photometry"] == "absolute"
    one = lampyris.read_image(made[0] / "one.exr")
    assert np.array_equal(next(iter(sweep)).image.bands, one.bands)


def test_study(made):
    study = lampyris.read_study(made[0] / "study")
    assert study.parameters == ["a"] and study.results == ["twice"]
    assert np.array_equal(study.columns["twice"], 2 * study.columns["a"])
    pandas = pytest.importorskip("pandas")
    assert isinstance(study.to_pandas(), pandas.DataFrame)


def test_messages_are_the_programs(made):
    (made[0] / "wrong.lua").write_text('require "lampyris".view { azimut = 3 }\n')
    with pytest.raises(lampyris.LampyrisError, match=r'wrong.lua:1: .*did you mean "azimuth"'):
        lampyris.run(made[0] / "wrong.lua", out=made[0])
