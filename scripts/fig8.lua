-- Fig. 8: the same reflector lit by a RAYSET and by a cylinder of the filament's size, and how much
-- of the filament's luminance pattern each keeps, against a RAYSET of a million rays.
--
--   lampyris run scripts/fig8.lua [-- tiny]

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = paper.size(160, 24)
local samples = paper.size(100000, 300)
local reference_samples = paper.size(1000000, 3000)

local built = model.build(require "model1", paper.size(1, 5))
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

local exponents = { 1500, 1000000 } -- Table 4's, and nearly a mirror's: it shows the coil's turns

local function render(light, exponent, view)
  local scene = lampyris.scene {
    objects = { { mesh = chamber.reflector, material = aluminium(exponent) } },
    lights = { light },
  }
  return scene:render(view, { samples = 1, light_error = 0.01 })
end

local function view_of(x, y, fov)
  return lampyris.view {
    distance = 3000, target = { x, y, 20 }, fov = fov, width = width, height = width,
  }
end

local whole = view_of(0, 0, 2.4)

--- A view of the brightest highlight to the right of the bulb, one pillow wide.
local function closeup_of(image)
  local luminance, best, column, row = image:luminances(), -1, 0, 0
  for y = width * 2 // 5, width * 3 // 5 do
    for x = width * 7 // 10, width * 9 // 10 do
      local value = luminance[y * width + x + 1]
      if value > best then best, column, row = value, x, y end
    end
  end
  local mm_a_pixel = 2 * 3000 * math.tan(math.rad(1.2)) / width
  return view_of((column - width / 2) * mm_a_pixel, (width / 2 - row) * mm_a_pixel, 0.22)
end

local report = paper.report("fig8", "Fig. 8: RAYSET and cylinder")
local rows, panels = {}, {}
local closeup = closeup_of(render(bulb(samples, 1), exponents[1], whole))
for _, exponent in ipairs(exponents) do
  local expected = render(reference, exponent, closeup):luminances()
  local exposure = paper.exposure(1.1 * math.max(table.unpack(expected)))
  local function add(name, light)
    local pattern
    for _, shot in ipairs { { "reflector", whole }, { "highlight", closeup } } do
      local part, view = shot[1], shot[2]
      local image = render(light, exponent, view)
      local title = ("%s, n_s = %d, %s"):format(name, exponent, part)
      table.insert(panels, { title = title, image = image, exposure = exposure })
      if part == "highlight" then pattern = image:luminances() end
    end
    table.insert(rows, {
      name, exponent, paper.correlation(pattern, expected),
      paper.contrast(pattern), paper.contrast(expected), paper.relative_rms(pattern, expected),
    })
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
for k, verdict in ipairs { "keeps the pattern", "loses it" } do
  report:compare(("correlation with %d rays, %s"):format(reference_samples, rows[k][1]),
    rows[k][3], verdict)
end
report:note(("In the highlight, against a RAYSET of %d rays with another seed. The paper shows that"
  .. " the RAYSET keeps the filament's pattern and a cylinder does not, without numbers."
):format(reference_samples))
