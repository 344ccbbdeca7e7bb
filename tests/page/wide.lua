-- One picture for a Display P3 monitor, red beyond sRGB.

local lampyris = require "lampyris"

local red = lampyris.spectrum.new { { 595, 0 }, { 600, 1 }, { 640, 1 }, { 645, 0 } }
local light = red + 0.01 * lampyris.spectrum.illuminant "D65"
local scene = lampyris.scene { objects = {}, background = light, photometry = "absolute" }
local image = scene:render(lampyris.view { width = 16, height = 9 }, { samples = 1 })
-- 12 of the 80 cd/m² of its white.
local _, luminance = light:xyz()
image:save("wide.png", { display = lampyris.display.p3, exposure = 12 / luminance })
