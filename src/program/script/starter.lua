-- A parabolic reflector with a bulb in its focus, seen from 0° to 30°.
--
--   lampyris run THIS_FILE.lua [-- WIDTH]
--
-- Lengths are in mm, angles in degrees, wavelengths in nm, flux in lm.
-- The lamp looks along +Z; +X is to the right and +Y up, as the viewer sees it.

local lampyris = require "lampyris"

-- The script's own argument, after "--".
local width = tonumber(arg[1]) or 320

-- A mesh: load one with lampyris.mesh.load("reflector.obj"), or make a surface.
-- This one is z = r² / 4f, kept where r is below 50 mm.
local focal_length = 20
local reflector = lampyris.mesh.surface {
  nu = 120,
  nv = 120,
  point = function(u, v)
    local x, y = 100 * u - 50, 100 * v - 50
    return x, y, (x * x + y * y) / (4 * focal_length)
  end,
  keep = function(x, y, z) return x * x + y * y < 50 * 50 end,
}

-- The paper's reflector (Table 4). A spectrum can be a number, or come from
-- lampyris.spectrum.load("reflectance.csv").
local aluminium = lampyris.material {
  reflectance = 0.9,
  k_rg = 0.95, k_tg = 0.05,
  k_d = 0.08, k_s = 0.92,
  n_d = 10, n_s = 1500,
}

-- A light: a ready bulb, or a ray file with lampyris.rayset.load("bulb.tm25ray").
local bulb = lampyris.bulb("P21W", { center = { 0, 0, focal_length }, samples = 10000 })

local scene = lampyris.scene {
  objects = { { mesh = reflector, material = aluminium } },
  lights = { bulb },
}

local views = {}
for azimuth = 0, 30, 10 do
  views[#views + 1] = lampyris.view {
    azimuth = azimuth,
    distance = 3000,
    fov = 3,
    width = width,
    height = width * 3 // 4,
  }
end

-- Writes an EXR and a PNG a view, a manifest and a page: open out/first/index.html.
-- Stop it whenever you like: started again, it goes on where it was.
local done = lampyris.sweep {
  scene = scene,
  views = views,
  quality = { samples = 4 },
  png = { look = "seen" }, -- or "paper", "camera"; changed later, nothing is rendered again
  output = "first",
  regions = { center = { x = width // 2 - 4, y = width * 3 // 8 - 4, width = 8, height = 8 } },
}
print(("%d views rendered, %d kept, in %s"):format(done.rendered, done.kept, done.folder))
