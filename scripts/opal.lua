-- A position lamp: a white box of LEDs under an opal sheet, from the front and 15° outward. What the
-- viewer sees is light that bounced in the box; how even it is, is what such a lamp is judged by.
--
--   lampyris run scripts/opal.lua [-- WIDTH [SAMPLES [BOUNCED]]]

local lampyris = require "lampyris"
local revolve = require "revolve"
local panel = require("sheet").panel

local width = tonumber(arg[1]) or 320
local samples = tonumber(arg[2]) or 1
local bounced = tonumber(arg[3]) or 8000

local W, H, DEPTH = 120, 40, 25 -- mm

local white = lampyris.material { name = "box", reflectance = 0.92, k_d = 1 }
local opal = lampyris.material {
  name = "opal", reflectance = 0.5, transmittance = 0.42, k_d = 1, k_tg = 1e-9,
}
local frame = lampyris.material { name = "frame", reflectance = 0.04, k_d = 1 }
local x0, y0 = -W / 2, -H / 2

local objects = {
  { mesh = panel({ x0, y0, 0 }, { W, 0, 0 }, { 0, H, 0 }), material = white },
  { mesh = panel({ x0, y0, 0 }, { 0, H, 0 }, { 0, 0, DEPTH }), material = white },
  { mesh = panel({ -x0, y0, 0 }, { 0, 0, DEPTH }, { 0, H, 0 }), material = white },
  { mesh = panel({ x0, y0, 0 }, { 0, 0, DEPTH }, { W, 0, 0 }), material = white },
  { mesh = panel({ x0, -y0, 0 }, { W, 0, 0 }, { 0, 0, DEPTH }), material = white },
  { mesh = panel({ x0, y0, DEPTH }, { W, 0, 0 }, { 0, H, 0 }), material = opal },
}
-- A dark frame around the sheet.
local B = 6
for _, f in ipairs {
  { x0 - B, y0 - B, W + 2 * B, B }, { x0 - B, -y0, W + 2 * B, B },
  { x0 - B, y0, B, H }, { -x0, y0, B, H },
} do
  local mesh = panel({ f[1], f[2], DEPTH + 1 }, { f[3], 0, 0 }, { 0, f[4], 0 })
  objects[#objects + 1] = { mesh = mesh, material = frame }
end

local lights = {}
local led = revolve.led_spectrum(625, 18)
for i = 0, 5 do
  for j = 0, 1 do
    local x, y = x0 + (i + 0.5) * W / 6, y0 + (j + 0.5) * H / 2
    lights[#lights + 1] = lampyris.emitter {
      mesh = revolve.plate(x, y, 0.6, 2, 2), flux = 5, spectrum = led, samples = 16,
      visible = false,
    }
  end
end

local scene = lampyris.scene {
  objects = objects, lights = lights, photometry = "absolute", shadows = true,
  background = revolve.sky(20),
  interreflection = { bounces = 20, samples = bounced },
}

local quality = { samples = samples, wavelength_step = 20, light_error = 0.05 }
local function view(azimuth)
  return {
    azimuth = azimuth, distance = 3000, target = { 0, 0, DEPTH }, fov = 1.9,
    width = width, height = width // 2,
  }
end

revolve.render("opal", scene, {
  { name = "00", view = view(0), quality = quality },
  { name = "15", view = view(15), quality = quality },
})

-- Homogeneity over the sheet: darkest over brightest of 12 × 4 cells.
local image = scene:render(lampyris.view {
  distance = 3000, target = { 0, 0, DEPTH }, fov = 2 * math.deg(math.atan(H / 2 / 3000)),
  width = 12 * 4, height = 4 * 4,
}, quality)
local darkest, brightest = math.huge, 0
for i = 0, 11 do
  for j = 0, 3 do
    local luminance = image:luminance { x = 4 * i, y = 4 * j, width = 4, height = 4 }
    darkest, brightest = math.min(darkest, luminance), math.max(brightest, luminance)
  end
end
print(("homogeneity %.3f, brightest cell %.4g cd/m²"):format(darkest / brightest, brightest))
