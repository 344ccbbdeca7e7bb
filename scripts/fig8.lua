-- Fig. 8: the same reflector lit by a RAYSET and by a cylinder of the filament's size, and how much
-- of the filament's luminance pattern each keeps, against a RAYSET of a million rays.
--
--   lampyris run scripts/fig8.lua [-- tiny]

local lampyris = require "lampyris"
local lamp = require "lamp"
local paper = require "paper"

local width = paper.size(240, 32)
local samples = paper.size(100000, 300)
local reference_samples = paper.size(1000000, 3000)

local built = paper.build(paper.lamp("model1"), paper.size(1, 5))
local chamber = built.chambers[2]
local place = { center = chamber.focus, samples = samples }

local function bulb(count, seed)
  return lampyris.bulb("P21W", { center = chamber.focus, samples = count, seed = seed })
end

-- The coil of a P21W: 34 turns 0.1765 mm apart, 0.5635 mm in outer radius.
local reference = bulb(reference_samples, 2)
local cylinder = lampyris.cylinder {
  center = place.center, axis = { 1, 0, 0 }, radius = 0.5635, length = 6.0,
  samples = samples, seed = 1, flux = reference.flux, spectrum = reference.spectrum,
}

local function aluminium(exponent)
  return lampyris.material {
    reflectance = lampyris.spectrum.load("../data/materials/aluminium_mcpeak2015.csv"),
    k_rg = 0.95, k_d = 0.08, n_d = 10, k_s = 0.92, n_s = exponent,
  }
end

-- A few pillows of the chamber, from 3 m.
local view = lampyris.view {
  distance = 3000, target = { 0, 0, 20 }, fov = 2.4, width = width, height = width,
}

local function render(light, exponent)
  local scene = lampyris.scene {
    objects = { { mesh = chamber.reflector, material = aluminium(exponent) } },
    lights = { light },
  }
  return scene:render(view, { samples = 1, light_error = 0.01 })
end

local side = width // 5
local crop = { x = width * 13 // 20, y = width * 2 // 5, width = side, height = side }

local report = paper.report("fig8", "Fig. 8: RAYSET and cylinder")
local rows, panels = {}, {}
local _, display_white = lampyris.display.srgb:xyz(255, 255, 255)
for _, exponent in ipairs { 1500, 30000 } do
  local truth = render(reference, exponent)
  local expected = truth:luminances(crop)
  local exposure = 0.9 * display_white / math.max(table.unpack(expected))
  local function add(name, light)
    local image = render(light, exponent)
    local pattern = image:luminances(crop)
    table.insert(rows, {
      name, exponent, paper.correlation(pattern, expected),
      paper.contrast(pattern), paper.contrast(expected), paper.relative_rms(pattern, expected),
    })
    for _, region in ipairs { false, crop } do
      table.insert(panels, {
        title = ("%s, n_s = %d%s"):format(name, exponent, region and ", crop" or ""),
        image = image, exposure = exposure, crop = region or nil,
      })
    end
  end
  add("RAYSET", bulb(samples, 1))
  add("cylinder", cylinder)
end

report:figure("fig8", lampyris.figure {
  width = 1400, height = 760, columns = 4, panels = panels,
}, ("pillow reflector lit by a P21W of %d rays and by a cylinder of as many"):format(samples))
report:table({
  "light", "n_s", "correlation", "contrast", "of the reference", "relative rms",
}, rows)
report:note(("In the crop, against a RAYSET of %d rays with another seed; the paper shows, without"
  .. " numbers, that the RAYSET keeps the pattern and the cylinder blurs it."):format(reference_samples))
