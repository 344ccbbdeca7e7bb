-- A small sweep for `run`: every kind of file that a sweep writes.
local lampyris = require "lampyris"

local mirror = lampyris.mesh.surface {
  nu = 24, nv = 24,
  point = function(u, v)
    local x, y = (u - 0.5) * 100, (v - 0.5) * 100
    return x, y, (x * x + y * y) / 100
  end,
}
local aluminium = lampyris.material {
  reflectance = 0.8, k_d = 0.08, n_d = 10, k_s = 0.92, n_s = 1500, k_rg = 0.95,
}
local scene = lampyris.scene {
  objects = { { mesh = mirror, material = aluminium } },
  lights = { lampyris.cylinder {
    center = { 0, 0, 25 }, radius = 0.5, length = 5, samples = 2000, seed = 1, flux = 440,
    spectrum = lampyris.spectrum.blackbody(2856),
  } },
}
local views = {}
for k, azimuth in ipairs { 0, 15, 30 } do
  views[k] = lampyris.view { azimuth = azimuth, distance = 1000, width = 40, height = 30 }
end
lampyris.sweep {
  scene = scene, views = views, output = "s",
  regions = { mid = { x = 10, y = 10, width = 5, height = 5 } },
  png = { display = lampyris.display.eizo_t766, glare = true },
}
