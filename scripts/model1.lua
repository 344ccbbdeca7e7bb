-- Model 1 (Table 5): the tail and stop chamber, lit by a P21/5W, from the front and 15° outward.
--
--   lampyris run scripts/model1.lua [-- WIDTH]

local lampyris = require "lampyris"
local lamp = require "lamp"

local width = tonumber(arg[1]) or 640

local rear = lamp.build()
print(("model 1: %d triangles"):format(rear.triangle_count))

local scene = lampyris.scene {
  objects = lamp.objects(rear, "red"),
  lights = { lampyris.bulb("P21/5W", { center = rear.chambers[2].focus }) },
}

for _, azimuth in ipairs { 0, 15 } do
  local view = lampyris.view {
    azimuth = azimuth,
    distance = 3000,
    target = { 0, 0, 60 },
    fov = 6,
    width = width,
    height = width * 3 // 4,
  }
  local image = scene:render(view, { samples = 4 })
  local name = ("model1_%02d"):format(azimuth)
  image:save(name .. ".exr")
  image:save(name .. "_t766.png", { display = lampyris.display.eizo_t766 })
  image:save(name .. "_srgb.png", { display = lampyris.display.srgb })
  print(name, image.stats)
end
