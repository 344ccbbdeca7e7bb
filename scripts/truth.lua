-- Physics: a test lamp and closed cases, ours beside the reference (a path tracer, or paper).
-- docs/truth.md says where the references come from, and what follows.
--
--   lampyris run scripts/truth.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"
local revolve = require "revolve"
local test_lamp = require "test_lamp"

local white = lampyris.spectrum.blackbody(2856)
local report = paper.report("truth", "Against physics")

--- Intensity toward (h, v) degrees, from so far that all rays are parallel; `half` is half of the
-- square that is seen, about (0, 0, z): all of the lamp has to be in it from every direction.
local function intensity(scene, h, v, half, quality)
  local side = paper.size(quality.side or 400, 40)
  local image = scene:render(lampyris.view {
    azimuth = h, elevation = v, distance = 1e6, target = { 0, 0, quality.z or 0 },
    fov = math.deg(2 * math.atan(half / 1e6)), width = side, height = side,
  }, {
    samples = paper.size(quality.samples or 1, 1), max_depth = "auto", wavelength_step = 20,
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

local bowl, filament = test_lamp.bowl(paper.size(480, 60)), test_lamp.filament
local mirror = lampyris.material { name = "mirror", reflectance = 0.9, k_rg = 1 }

local function lamp(objects, light)
  return lampyris.scene {
    objects = objects, lights = { light }, photometry = "absolute", shadows = false,
  }
end
local few = paper.size(20000, 1000) -- light samples, of which a scene of mirrors has no need
local bare = lamp({ { mesh = bowl, material = mirror } }, filament { samples = few })

-- Directions, and a path tracer's intensities: smooth and rough mirror, without and with lens; last
-- those of exact surfaces in place of meshes, smooth with lens, within 0.5 % (2 cd at least).
local printed = {
  { 0, 0, 75460, 25817, 4031, 3963, 4022 }, { 2, 0, 34127, 19385, 3915, 3791, 3910 },
  { 4, 0, 13999, 8124, 3246, 3156, 3288 }, { 6, 0, 137, 1771, 2146, 2121, 2143 },
  { 10, 0, 42, 44, 211, 323, 213.1 }, { 0, 4, 41, 964, 3908, 3537, 3891 },
  { 6, 4, 41, 109, 2213, 2011, 2213 }, { 15, 4, 46, 46, 114, 112, 107.0 },
  { 20, 4, 39, 39, 33, 33, 33.5 },
}
local directions = paper.is_tiny and { printed[1] } or printed
local headings = { "H", "V", "ours", "reference", "ratio" }
compare("Test lamp without lens, smooth mirror, cd:", headings, paper.map(directions, function(d)
  return { d[1], d[2], intensity(bare, d[1], d[2], 63, { z = 30, samples = 4 }), d[3] }
end))

-- What the rough mirror sends is a sum over light samples, without noise; the source itself is seen
-- by rays, of which more are needed.
local rough = lampyris.material {
  name = "rough", reflectance = 0.9, k_s = 1, n_s = 1500, lobe = "half",
}
local hidden = filament { visible = false, samples = paper.size(200000, 1000) }
local itself = lamp({}, filament { samples = few })
local bare_rough = lamp({ { mesh = bowl, material = rough } }, hidden)
compare("Test lamp without lens, rough mirror, cd:", headings, paper.map(directions, function(d)
  local direct = intensity(itself, d[1], d[2], 3, { z = 25, samples = 9 })
  return { d[1], d[2], direct + intensity(bare_rough, d[1], d[2], 63, { z = 30, side = 120 }), d[4] }
end))

local lens, pillows = revolve.pmma { name = "lens" }, test_lamp.lens(paper.size(24, 4))
local with_lens = lamp({
  { mesh = bowl, material = mirror }, { mesh = pillows, material = lens },
}, filament { samples = few })
--- Rays that meet the source are few where it is dim: of 4 million 4,000 at 210 cd, 1.5 % of noise.
local function with_all(reference)
  return { z = 55, side = 500, samples = reference > 1000 and 4 or 16 }
end
report:note("Test lamp with lens, smooth mirror, cd; last the ratio to exact surfaces:")
report:table({ "H", "V", "ours", "reference", "ratio", "exact", "ratio" },
  paper.map(directions, function(d)
    local ours = intensity(with_lens, d[1], d[2], 83, with_all(d[5]))
    return { d[1], d[2], ours, d[5], ours / d[5], d[7], ours / d[7] }
  end))

local through_lens = lamp({ { mesh = pillows, material = lens } }, filament { samples = few })
local lens_rough = lamp({
  { mesh = bowl, material = rough }, { mesh = pillows, material = lens },
}, hidden)
compare("Test lamp with lens, rough mirror, cd:", headings, paper.map(directions, function(d)
  local direct = intensity(through_lens, d[1], d[2], 83, with_all(d[6]))
  local ours = direct + intensity(lens_rough, d[1], d[2], 83, { z = 55, side = 250 })
  return { d[1], d[2], ours, d[6] }
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
    return { a[1], intensity(collimator, a[1], 0, 16, { z = 10, side = 300, samples = 4 }), a[2] }
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
local about_mirror = lampyris.material { name = "rough", reflectance = 0.9, k_s = 1, n_s = 1500 }
local function rough_lamp(light) return lamp({ { mesh = bowl, material = about_mirror } }, light) end
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
  interreflection = { bounces = 60, samples = paper.size(200000, 2000) },
}
local cells = 8
local image = box:render(lampyris.view {
  distance = 1e6, target = { 0, 0, 10 }, fov = math.deg(2 * math.atan(20 / 1e6)),
  width = cells * paper.size(4, 1), height = cells * paper.size(4, 1),
}, { samples = 1, light_error = 0.05, wavelength_step = 20 })
local sum, corners, middle = 0, 0, 0
local side = image.width // cells
for i = 0, cells - 1 do
  for j = 0, cells - 1 do
    local luminance = image:luminance { x = i * side, y = j * side, width = side, height = side }
    -- How far from the middle, in cells: 0 to 3 each way.
    local a, b = math.abs(i - 3.5) - 0.5, math.abs(j - 3.5) - 0.5
    sum = sum + luminance / (cells * cells)
    if a + b == 0 then middle = middle + luminance end
    if a + b == 6 then corners = corners + luminance end
  end
end
compare("Opal box:", { "", "ours", "reference", "ratio" }, {
  { "flux out", math.pi * sum * 0.04 * 0.04 / 100, 0.659 },
  { "the four darkest over the four brightest of 8 × 8 cells", corners / middle, 0.1697 },
})

return report
