-- A red lamp at dusk, seen from 0° to 30°: a bulb, a reflector with pillows, a lens.
--
--   lampyris run THIS_FILE.lua [-- WIDTH]
--
-- Lengths are in mm, angles in degrees, wavelengths in nm, flux in lm.
-- The lamp looks along +Z; +X is to the right and +Y up, as the viewer sees it.

local lampyris = require "lampyris"

-- The script's own argument, after "--".
local width = tonumber(arg[1]) or 320

-- A mesh: load one with lampyris.mesh.load("reflector.obj"), or make a surface.
-- This one is z = r² / 4f with pillows that spread the light, kept where r is below 50 mm.
local focal_length = 20
local function pillows(x, y) return 0.5 * (math.cos(x / 3.5) + math.cos(y / 3.5)) end
local reflector = lampyris.mesh.surface {
  nu = 120,
  nv = 120,
  point = function(u, v)
    local x, y = 100 * u - 50, 100 * v - 50
    return x, y, (x * x + y * y) / (4 * focal_length) + pillows(x, y)
  end,
  keep = function(x, y, z) return x * x + y * y < 50 * 50 end,
}

-- A flat lens before it.
local lens = lampyris.mesh.surface {
  nu = 120,
  nv = 120,
  point = function(u, v) return 104 * u - 52, 104 * v - 52, 35 end,
  keep = function(x, y) return x * x + y * y < 52 * 52 end,
}

-- The paper's reflector and lens (Table 4). A spectrum can be a number, or come from
-- lampyris.spectrum.load("reflectance.csv").
local aluminium = lampyris.material {
  reflectance = 0.9,
  k_rg = 0.95, k_tg = 0.05,
  k_d = 0.08, k_s = 0.92,
  n_d = 10, n_s = 1500,
}
local red = lampyris.material {
  reflectance = 0.05,
  transmittance = lampyris.spectrum.new { { 580, 0 }, { 620, 0.85 }, { 780, 0.9 } },
  k_rg = 0.05, k_tg = 0.95,
  k_d = 0.08, k_s = 0.92,
  n_d = 50, n_s = 1500,
}

-- A light: a ready bulb, or a ray file with lampyris.rayset.load("bulb.tm25ray").
local bulb = lampyris.bulb("P21/5W", {
  filament = "minor", center = { 0, 0, focal_length }, samples = 3000,
})

-- In absolute photometry pictures are in cd/m², and walls cast shadows. The sky at dusk: 10 cd/m².
local daylight = lampyris.spectrum.illuminant "D65"
local _, unit = daylight:xyz()
local scene = lampyris.scene {
  photometry = "absolute",
  background = daylight * (10 / unit),
  objects = { { mesh = reflector, material = aluminium }, { mesh = lens, material = red } },
  lights = { bulb },
}

local views = {}
for azimuth = 0, 30, 10 do
  views[#views + 1] = lampyris.view {
    azimuth = azimuth,
    distance = 3000,
    fov = 2.6,
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
