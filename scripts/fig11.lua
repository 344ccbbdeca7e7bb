-- Fig. 11: all views of the four lamps in one sheet.
--
--   lampyris run scripts/fig11.lua [-- tiny]

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = paper.size(400, 32)
local samples = paper.size(50000, 100)

local function panels_of(name)
  local built = model.build(require(name), paper.size(1, 6))
  return paper.map(built.shots, function(shot)
    local scene = model.scene(built, shot, samples)
    local image = scene:render(model.view(shot, width), { samples = 4 })
    local x, y = image:spectrum():xy()
    return {
      image = image, seconds = image.stats.seconds, x = x, y = y, white = shot.white,
      title = ("%s, %s, %s"):format(name:gsub("model", "model "), shot.lit[1].bulb,
        shot.azimuth and shot.azimuth .. "°" or shot.name),
    }
  end)
end

local panels, rows = {}, {}
for k = 1, 4 do
  for _, shot in ipairs(panels_of("model" .. k)) do
    table.insert(panels, {
      title = shot.title, image = shot.image, exposure = paper.exposure(shot.white),
    })
    table.insert(rows, { shot.title, shot.x, shot.y, shot.seconds })
  end
end

local report = paper.report("fig11", "Fig. 11: the lamps, lit")
report:figure("fig11", lampyris.figure {
  width = 1350, height = 740, columns = 3, panels = panels,
}, ("%d × %d pixels, %d light samples a bulb, sRGB"):format(width, width * 3 // 4, samples))
report:table({ "view", "x of all light", "y", "seconds" }, rows)
