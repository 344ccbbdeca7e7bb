-- Fig. 7: a RAYSET of 100 rays of a P21W's filament in space.
--
--   lampyris run scripts/fig7.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"

local ray_length = 1.5 -- mm, as drawn

local bulb = lampyris.bulb("P21W", {
  samples = 100, axis = { 0, 0, 1 }, filament_axis = { 1, 0, 0 },
})
local rays = bulb:rays()

local segments, low, high, flux = {}, math.huge, -math.huge, 0
for _, ray in ipairs(rays) do
  local tip = {}
  for k = 1, 3 do tip[k] = ray.position[k] + ray_length * ray.direction[k] end
  table.insert(segments, { ray.position, tip })
  low, high = math.min(low, ray.position[1]), math.max(high, ray.position[1])
  flux = flux + ray.flux
end

local report = paper.report("fig7", "Fig. 7: RAYSET of a P21W, 100 rays")
report:figure("fig7", lampyris.figure {
  width = 1100, height = 560, columns = 2,
  panels = {
    { title = "P21W, 100 rays", segments = segments, dots = true, azimuth = 25, elevation = 25 },
    { title = "from the bulb's tip", segments = segments, dots = true, azimuth = 0, elevation = 0 },
  },
}, ("start points (green) and directions (white); each ray is drawn %g mm long"):format(ray_length))
report:compare("rays", #rays, 100)
report:compare("flux (lm; the paper's column: UN R37)", flux, 460)
report:compare("extent along the filament (mm; UN R37)", high - low, "at most 7")
