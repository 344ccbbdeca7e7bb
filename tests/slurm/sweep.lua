-- Eighty views of a lit mirror, about a second for two of them on one core.

local lampyris = require "lampyris"

local mirror = lampyris.mesh.surface {
  nu = 40, nv = 40,
  point = function(u, v)
    local x, y = 80 * u - 40, 80 * v - 40
    return x, y, (x * x + y * y) / 80
  end,
}
local scene = lampyris.scene {
  objects = { { mesh = mirror, material = lampyris.material {
    reflectance = 0.9, k_rg = 0.9, k_s = 0.9, n_s = 40,
  } } },
  lights = { lampyris.bulb("P21W", { center = { 0, 0, 20 }, samples = 3000 }) },
}
local views = {}
for k = 1, 80 do
  views[k] = lampyris.view { azimuth = k / 2, distance = 800, fov = 7, width = 96, height = 72 }
end
lampyris.sweep {
  scene = scene, views = views, output = "s",
  quality = { samples = 4, light_error = 0, wavelength_step = 20 },
}
