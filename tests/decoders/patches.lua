-- Patches of even light in cd/m², in every kind of file; prints a table of their tristimulus values
-- and of a band.

local lampyris = require "lampyris"

--- Light of one band between two wavelengths.
local function band(from, to)
  return lampyris.spectrum.new { { from - 1, 0 }, { from, 1 }, { to, 1 }, { to + 1, 0 } }
end

local lights = {
  white = lampyris.spectrum.illuminant "D65",
  incandescent = lampyris.spectrum.blackbody(2856),
  red = band(600, 660) + 0.02 * lampyris.spectrum.illuminant "D65",
  amber = band(560, 640) + 0.02 * lampyris.spectrum.illuminant "D65",
  green = band(500, 570) + 0.3 * lampyris.spectrum.illuminant "D65",
}
local view = lampyris.view { width = 16, height = 9 }
print "name,X,Y,Z,600nm"
for name, light in pairs(lights) do
  for _, luminance in ipairs { 0.5, 5, 50, 500 } do
    local _, unit = light:xyz()
    local scene = lampyris.scene {
      objects = {}, background = (luminance / unit) * light, photometry = "absolute",
    }
    local image = scene:render(view, { samples = 1 })
    local file = ("%s_%g"):format(name, luminance)
    image:save(file .. "_rec2020_pq.png", { display = lampyris.display.rec2020_pq {} })
    image:save(file .. "_p3_pq.png", { display = lampyris.display.p3_pq {} })
    image:save(file .. "_p3.png", { display = lampyris.display.p3, bits = 16, exposure = 0.1 })
    image:save(file .. ".exr")
    image:save(file .. "_half.exr", { bands = "half" })
    image:save(file .. "_pxr24.exr", { bands = "pxr24" })
    image:save(file .. "_none.exr", { bands = "none" })
    image:save(file .. ".hdr")
    image:save(file .. ".tif", { samples = "float" })
    local x, y, z = image:xyz()
    print(("%s,%.9g,%.9g,%.9g,%.9g"):format(file, x, y, z, image:spectrum():at(600)))
  end
end
