-- A white picture of 50 cd/m², and where the light of two photometric files goes on the whole: the mean
-- direction of their rays.

local lampyris = require "lampyris"

local white = lampyris.spectrum.illuminant "D65"
local _, unit = white:xyz()
local scene = lampyris.scene { objects = {}, background = (50 / unit) * white, photometry = "absolute" }
scene:render(lampyris.view { width = 200, height = 200 }, { samples = 1 }):save "even.hdr"

for _, name in ipairs { "b.ies", "c.ies" } do
  local light = lampyris.rayset.load(name, { spectrum = white, samples = 100000 })
  local sum, flux = { 0, 0, 0 }, 0
  for _, ray in ipairs(light:rays()) do
    for axis = 1, 3 do sum[axis] = sum[axis] + ray.flux * ray.direction[axis] end
    flux = flux + ray.flux
  end
  print(("%s,%.6f,%.6f,%.6f"):format(name, sum[1] / flux, sum[2] / flux, sum[3] / flux))
end
