-- Physics: a test lamp and closed cases, ours beside the reference (a path tracer, or paper).
-- docs/truth.md says where the references come from, and what follows.
--
--   lampyris run scripts/truth.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"
local revolve = require "revolve"

local white = lampyris.spectrum.blackbody(2856)
local report = paper.report("truth", "Against physics")

--- Intensity toward (h, v) degrees, from so far that all rays are parallel; `half` is half of the
-- square that is seen.
local function intensity(scene, h, v, half, quality)
  local side = paper.size(quality.side or 400, 40)
  local image = scene:render(lampyris.view {
    azimuth = h, elevation = v, distance = 1e6, target = { 0, 0, quality.z or 0 },
    fov = math.deg(2 * math.atan(half / 1e6)), width = side, height = side,
  }, {
    samples = quality.samples or 1, max_depth = "auto", wavelength_step = 20,
    min_throughput = 1e-4, light_error = 0.003,
  })
  return image:intensity()
end

local function compare(title, headings, rows)
  report:note(title)
  for _, row in ipairs(rows) do row[#row + 1] = row[#row - 1] / row[#row] end
  report:table(headings, rows)
end

-- The test lamp: a paraboloid of f = 25 mm, r from 12 to 60, reflectance 0.9, and a cylinder of
-- 440 lm along x in its focus. ---------------------------------------------------------------------

local around, along = paper.size(480, 60), paper.size(120, 15)
local function paraboloid(t)
  local r = 60 - t * 48
  return r, r * r / 100
end
local mirror = lampyris.material { name = "mirror", reflectance = 0.9, k_rg = 1 }
local function filament(options)
  local given = {
    center = { 0, 0, 25 }, axis = { 1, 0, 0 }, radius = 0.5, length = 5.5, flux = 440,
    spectrum = white, samples = paper.size(20000, 1000), visible = true,
  }
  for key, value in pairs(options or {}) do given[key] = value end
  return lampyris.cylinder(given)
end
local bowl = revolve.sheet(paraboloid, around, along)

local function lamp(objects, light)
  return lampyris.scene {
    objects = objects, lights = { light }, photometry = "absolute", shadows = false,
  }
end
local bare = lamp({ { mesh = bowl, material = mirror } }, filament())

local printed = {
  { 0, 0, 75460, 4031 }, { 2, 0, 34127, 3915 }, { 4, 0, 13999, 3246 }, { 6, 0, 137, 2146 },
  { 10, 0, 42, 211 }, { 0, 4, 41, 3908 }, { 6, 4, 41, 2213 }, { 15, 4, 46, 114 },
  { 20, 4, 39, 33 },
}
local directions = paper.is_tiny and { printed[1] } or printed
compare("Test lamp without lens, smooth mirror, cd:", { "H", "V", "ours", "reference", "ratio" },
  paper.map(directions, function(d)
    return { d[1], d[2], intensity(bare, d[1], d[2], 63, { z = 30, samples = 9 }), d[3] }
  end))

--- A clear plate with square pillows of 9 mm behind, and the normals of each.
local function pillow_lens()
  local sheet = require "sheet"
  local cells = { columns = 14, rows = 14 }
  local per_cell = paper.size(24, 4)
  local function bump(t)
    local cell = t * 14
    local a = 2 * (cell - math.min(math.floor(cell), 13)) - 1
    return 0.5 * (1 - a * a)
  end
  local n = 14 * per_cell
  local function front(u, v) return 126 * u - 63, 126 * v - 63, 75 end
  local function back(u, v) return 126 * u - 63, 126 * v - 63, 72 - bump(u) - bump(v) end
  local inside = { point = back, nu = n, nv = n, columns = 14, rows = 14 }
  local function rim(at)
    return {
      nu = n, nv = 1, columns = 1, rows = 1,
      point = function(s, t)
        local u, v = at(s)
        local x, y, z = back(u, v)
        return x, y, z + t * (75 - z)
      end,
    }
  end
  return sheet.merged_mesh {
    { point = front, nu = n, nv = n, columns = 1, rows = 1 },
    sheet.turned(inside),
    rim(function(s) return s, 0 end), rim(function(s) return 1, s end),
    rim(function(s) return 1 - s, 1 end), rim(function(s) return 0, 1 - s end),
  }
end
local lens = revolve.pmma { name = "lens" }
local with_lens = lamp({
  { mesh = bowl, material = mirror }, { mesh = pillow_lens(), material = lens },
}, filament())
compare("Test lamp with lens, smooth mirror, cd:", { "H", "V", "ours", "reference", "ratio" },
  paper.map(directions, function(d)
    return { d[1], d[2], intensity(with_lens, d[1], d[2], 63, { z = 30, side = 700 }), d[4] }
  end))

-- The TIR collimator over an LED of 1 × 1 mm and 100 lm. --------------------------------------------

local led = lampyris.emitter {
  mesh = revolve.plate(0, 0, 0, 1, 1), flux = 100, spectrum = white, samples = 100,
}
local collimator = lamp({
  { mesh = revolve.collimator(paper.size(720, 48)), material = revolve.pmma { name = "optic" } },
}, led)
local angles = { { 0, 30.6 }, { 2, 101.6 }, { 6, 280.5 }, { 10, 367.9 }, { 15, 204.5 }, { 30, 17.1 } }
if paper.is_tiny then angles = { angles[4] } end
compare("TIR collimator, cd:", { "angle", "ours", "reference", "ratio" },
  paper.map(angles, function(a)
    return { a[1], intensity(collimator, a[1], 0, 16, { z = 10, side = 500, samples = 4 }), a[2] }
  end))

-- A light guide of 50 total reflections. -------------------------------------------------------------

--- What comes through a square rod of 4 mm by total reflection alone: an emitter of radiance 1 fills
-- its far end, and the eye looks in at 45° in the rod.
local function guided()
  local reflections, half = 50, 2
  local length = reflections * 2 * half -- at 45° once each width
  local function wall(angle)
    return lampyris.mesh.new {
      positions = {
        { -half, half, -length }, { half, half, -length }, { half, half, 0 }, { -half, half, 0 },
      },
      triangles = { { 1, 3, 2 }, { 1, 4, 3 } }, smooth = false,
    }:transform { rotate = { axis = { 0, 0, 1 }, angle = angle } }
  end
  local glass = lampyris.material {
    name = "guide", reflectance = 1, transmittance = 1, ior = 1.49, k_tg = 1, k_rg = 0,
  }
  local walls = { wall(0), wall(90), wall(180), wall(270) }
  local source = lampyris.emitter {
    mesh = revolve.plate(0, 0, -length + 1e-3, 2 * half, 2 * half), radiance = 1, spectrum = white,
    samples = 4,
  }
  local scene = lamp({ { mesh = lampyris.mesh.merge(walls), material = glass } }, source)
  local image = scene:render(lampyris.view {
    azimuth = 0, elevation = 45, distance = 2, target = { 0, 0, -1 }, fov = 0.1, width = 1, height = 1,
  }, { samples = 1, max_depth = "auto", min_throughput = 0 })
  return image:luminance()
end
compare("Straight guide of 50 total reflections:", { "", "ours", "reference", "ratio" },
  { { "radiance at its end", guided(), 1 } })

-- Measured rays: true rays of the test lamp's cylinder, read back. ------------------------------------

--- Lambert rays of the cylinder that start on its surface.
local function true_rays(count)
  local positions, ways = {}, {}
  for i = 1, count do
    -- Powers of 1/g, g⁵ = g + 1: even in four dimensions.
    local function at(power) return (i / 1.1673039782614185 ^ power) % 1 end
    local phi, z = 2 * math.pi * at(1), 5.5 * (at(2) - 0.5)
    local n = { 0, math.cos(phi), math.sin(phi) }
    local u, psi = at(3), 2 * math.pi * at(4)
    local s, c = math.sqrt(u), math.sqrt(1 - u)
    local tangent = { 0, -n[3], n[2] }
    positions[i] = { z, 0.5 * n[2], 25 + 0.5 * n[3] }
    ways[i] = {
      s * math.sin(psi),
      c * n[2] + s * math.cos(psi) * tangent[2],
      c * n[3] + s * math.cos(psi) * tangent[3],
    }
  end
  return { positions = positions, directions = ways, flux = 440, spectrum = white }
end
local given = true_rays(paper.size(100000, 2000))
local rough = lampyris.material { name = "rough", reflectance = 0.9, k_s = 1, n_s = 1500 }
local function rough_lamp(light) return lamp({ { mesh = bowl, material = rough } }, light) end
local reference = rough_lamp(filament { visible = false, samples = paper.size(50000, 1000) })
local as_lambert = rough_lamp(lampyris.rayset.new(given))
given.exponent = 300
local as_measured = rough_lamp(lampyris.rayset.new(given))
local six = { { 0, 0 }, { 2, 0 }, { 4, 0 }, { 6, 0 }, { 0, 4 }, { 4, 4 } }
if paper.is_tiny then six = { six[1] } end
report:note("100,000 true rays of the cylinder, n_s = 1500: ratio to the cylinder itself")
report:table({ "H", "V", "eq. 9", "exponent 300" }, paper.map(six, function(d)
  local options = { z = 30, side = 100 }
  local right = intensity(reference, d[1], d[2], 63, options)
  return {
    d[1], d[2], intensity(as_lambert, d[1], d[2], 63, options) / right,
    intensity(as_measured, d[1], d[2], 63, options) / right,
  }
end))

-- Light that bounces: the opal box of 40 × 40 × 10 mm. -----------------------------------------------

local panel = require("sheet").panel
local wall = lampyris.material { name = "wall", reflectance = 0.9, k_d = 1 }
local opal = lampyris.material {
  name = "opal", reflectance = 0.5, transmittance = 0.4, k_d = 1, k_tg = 1e-9,
}
local box = lampyris.scene {
  objects = {
    { mesh = panel({ -20, -20, 0 }, { 40, 0, 0 }, { 0, 40, 0 }), material = wall },
    { mesh = panel({ -20, -20, 0 }, { 0, 40, 0 }, { 0, 0, 10 }), material = wall },
    { mesh = panel({ 20, -20, 0 }, { 0, 0, 10 }, { 0, 40, 0 }), material = wall },
    { mesh = panel({ -20, -20, 0 }, { 0, 0, 10 }, { 40, 0, 0 }), material = wall },
    { mesh = panel({ -20, 20, 0 }, { 40, 0, 0 }, { 0, 0, 10 }), material = wall },
    { mesh = panel({ -20, -20, 10 }, { 40, 0, 0 }, { 0, 40, 0 }), material = opal },
  },
  lights = {
    lampyris.rayset.new {
      positions = { { 0, 0, 1e-3 } }, directions = { { 0, 0, 1 } }, flux = 100, spectrum = white,
    },
  },
  photometry = "absolute", shadows = true,
  interreflection = { bounces = 60, samples = paper.size(100000, 2000) },
}
local cells = 8
local image = box:render(lampyris.view {
  distance = 1e6, target = { 0, 0, 10 }, fov = math.deg(2 * math.atan(20 / 1e6)),
  width = cells * paper.size(8, 1), height = cells * paper.size(8, 1),
}, { samples = 1, light_error = 0.01, wavelength_step = 20 })
local sum, darkest, brightest = 0, math.huge, 0
local side = image.width // cells
for i = 0, cells - 1 do
  for j = 0, cells - 1 do
    local luminance = image:luminance { x = i * side, y = j * side, width = side, height = side }
    sum = sum + luminance / (cells * cells)
    darkest, brightest = math.min(darkest, luminance), math.max(brightest, luminance)
  end
end
compare("Opal box:", { "", "ours", "reference", "ratio" }, {
  { "flux out", math.pi * sum * 0.04 * 0.04 / 100, 0.659 },
  { "darkest over brightest of 8 × 8 cells", darkest / brightest, 0.168 },
})

return report
