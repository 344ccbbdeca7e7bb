-- Fig. 1: the rays that are followed for pixels of model 1, over the lamp's section.
--
--   lampyris run scripts/fig1.lua [-- tiny]

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local built = model.build(require "model1", paper.size(2, 6))
local focus = built.chambers[2].focus
local scene = model.scene(built, built.shots[1], 100)
-- A narrow view of the middle chamber: three hundredths of a degree a pixel.
local view = lampyris.view {
  distance = 3000, target = { focus[1], 0, 60 }, fov = 3, width = 100, height = 100,
}

local outline = {}
for _, object in ipairs(built.objects) do
  for _, ends in ipairs(object.mesh:section { normal = { 1, 0, 0 }, through = focus }) do
    for _, p in ipairs(ends) do table.insert(outline, { p[3], p[2] }) end
    table.insert(outline, {})
  end
end

local colors = { camera = "from the eye", transmitted = "transmitted", mirrored = "mirrored" }
local lines, counts = { camera = {}, transmitted = {}, mirrored = {} }, {}
for _, row in ipairs { 22, 36, 68 } do
  for _, segment in ipairs(scene:paths(view, { x = 50.5, y = row, min_throughput = 0.02 })) do
    local finish = segment.finish
    if not finish then -- leaves the lamp
      finish = {}
      for k = 1, 3 do finish[k] = segment.start[k] + 60 * segment.direction[k] end
    end
    local start = segment.start
    if segment.kind == "camera" then -- its last 60 mm
      for k = 1, 3 do start[k] = finish[k] - 60 * segment.direction[k] end
    end
    local line = lines[segment.kind]
    table.insert(line, { start[3], start[2] })
    table.insert(line, { finish[3], finish[2] })
    table.insert(line, {})
    counts[segment.depth] = (counts[segment.depth] or 0) + 1
  end
end

local series = { { name = "section", points = outline, color = { 120, 120, 120 } } }
for _, kind in ipairs { "camera", "transmitted", "mirrored" } do
  table.insert(series, { name = colors[kind], points = lines[kind] })
end

local report = paper.report("fig1", "Fig. 1: ray paths through the lamp")
report:figure("fig1", lampyris.figure {
  width = 1150, height = 820,
  x = { label = "z (mm), optical axis", range = { -30, 190 } },
  y = { label = "y (mm)", range = { -80, 80 } },
  series = series,
}, "model 1 cut at the middle of the bulb; three pixels, rays that keep 2 % or more")
local rows = {}
for depth = 0, 8 do
  if counts[depth] then table.insert(rows, { depth, counts[depth] }) end
end
report:table({ "depth", "rays" }, rows)
