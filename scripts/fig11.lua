-- Fig. 11: all views of the four lamps in one sheet, as the paper has them, and at dusk as an eye and as a
-- camera see them: the paper blames the colors of its photographs on the camera.
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
    local dusk = model.dusk(built, shot, samples)
    return {
      dusk = dusk:render(model.close_view(shot, width), { samples = 4 }),
      image = image, seconds = image.stats.seconds, x = x, y = y, white = shot.white,
      title = ("%s, %s, %s"):format(name:gsub("model", "model "), shot.lit[1].bulb,
        shot.azimuth and shot.azimuth .. "°" or shot.name),
    }
  end)
end

local panels, seen, photographs, rows = {}, {}, {}, {}
for k = 1, 4 do
  for _, shot in ipairs(panels_of("model" .. k)) do
    table.insert(panels, {
      title = shot.title, image = shot.image, exposure = paper.exposure(shot.white),
    })
    table.insert(seen, { title = shot.title, image = shot.dusk, look = "seen" })
    table.insert(photographs, { title = shot.title, image = shot.dusk, look = "camera" })
    table.insert(rows, { shot.title, shot.x, shot.y, shot.seconds })
  end
end

local report = paper.report("fig11", "Fig. 11: the lamps, lit")
report:figure("fig11", lampyris.figure {
  width = 1350, height = 740, columns = 3, panels = panels,
}, ("%d × %d pixels, %d light samples a bulb, sRGB"):format(width, width * 3 // 4, samples))
local dusk = { width = 1350, height = 560, columns = 3 }
report:figure("fig11_seen", lampyris.figure {
  width = dusk.width, height = dusk.height, columns = dusk.columns, panels = seen,
}, "at dusk, as an eye sees them: glare, highlights that lose saturation and keep their hue")
report:figure("fig11_camera", lampyris.figure {
  width = dusk.width, height = dusk.height, columns = dusk.columns, panels = photographs,
}, "the same light, as a Nikon D5100 records it: bright red turns to orange where its channels fill up")
report:table({ "view", "x of all light", "y", "seconds" }, rows)
