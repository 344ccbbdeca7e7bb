-- The error that a RAYSET of N rays has of its own: how much a picture's luminance changes between
-- disjoint halves of the set, against N.
--
--   lampyris run scripts/fig8_samples.lua [-- tiny]

local lampyris = require "lampyris"
local lamp = require "lamp"
local model = require "model"
local paper = require "paper"

local width = paper.size(64, 12)
local decades = paper.size({ 2, 6 }, { 2, 3 })

local built = model.build(require "model1", paper.size(1.5, 6))
local chamber = built.chambers[2]
local aluminium = lamp.materials().aluminium
local view = lampyris.view {
  distance = 3000, target = { 0, 0, 20 }, fov = 2.4, width = width, height = width,
}

local function render(light)
  local scene = lampyris.scene {
    objects = { { mesh = chamber.reflector, material = aluminium } }, lights = { light },
  }
  -- The tree's own error must stay below the RAYSET's.
  return scene:render(view, {
    samples = 1, light_error = 0.002, max_depth = 0, wavelength_step = 20,
  })
end

local points, rows = {}, {}
for exponent = 2 * decades[1], 2 * decades[2] do
  local count = math.floor(10 ^ (exponent / 2) + 0.5)
  local bulb = lampyris.bulb("P21W", { center = chamber.focus, samples = count })
  local noise = bulb:noise { image = render, splits = 2 }
  table.insert(points, { count, noise })
  table.insert(rows, { count, noise, noise * math.sqrt(count) })
end

local law = {}
for _, point in ipairs(points) do
  table.insert(law, { point[1], points[1][2] * math.sqrt(points[1][1] / point[1]) })
end

local report = paper.report("fig8_samples", "How many rays a RAYSET needs")
report:figure("fig8_samples", lampyris.figure {
  x = { label = "rays in the set", log = true },
  y = { label = "relative error of luminance", log = true },
  series = {
    { name = "RAYSET of a P21W", points = points, style = "both" },
    { name = "1/√N", points = law, style = "dashes" },
  },
}, "from pictures of model 1's reflector with disjoint halves; bright pixels weigh most")
report:table({ "N", "relative error", "error · √N" }, rows)
report:compare("relative error of a picture, times √N",
  paper.mean(paper.map(rows, function(row) return row[3] end)))
