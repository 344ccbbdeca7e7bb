-- The extremes: worst relative errors of luminance where the answer is known in closed form, and
-- what is refused.
--
--   lampyris run scripts/stability.lua [-- tiny]
--
-- The f64 reference is this script itself: eq. 9 for one or a few samples, written out in Lua.

local lampyris = require "lampyris"
local paper = require "paper"

local white = lampyris.spectrum.constant(1)

--- A square of this half width at height z, facing +z.
local function square(half, z)
  return lampyris.mesh.new {
    positions = { { -half, -half, z }, { half, -half, z }, { half, half, z }, { -half, half, z } },
    triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
  }
end

local function lamp_at(position, direction, flux)
  return lampyris.rayset.new {
    positions = { position }, directions = { direction }, flux = flux, spectrum = white,
  }
end

--- Luminance of the middle of a picture.
local function look(objects, lights, view, quality)
  local settings = {
    distance = 1000, fov = 0.01, width = 1, height = 1, target = { 0, 0, 0 },
  }
  for key, value in pairs(view or {}) do settings[key] = value end
  local asked = { samples = 1, light_error = 0, min_throughput = 0 }
  for key, value in pairs(quality or {}) do asked[key] = value end
  local scene = lampyris.scene { objects = objects, lights = lights }
  return scene:render(lampyris.view(settings), asked):luminance()
end

local function lobe(exponent)
  return lampyris.material { reflectance = 1, k_s = 1, n_s = exponent }
end
local diffuse = lampyris.material { reflectance = 1, k_d = 1, n_d = 1 }
local plate = { mesh = square(10, 0), material = diffuse }

local rows = {}
--- The worst of the pairs (found, expected) that `f` yields.
local function check(what, f)
  local worst, count = 0, 0
  f(function(found, expected)
    count = count + 1
    local scale = expected == 0 and 1 or math.abs(expected)
    worst = math.max(worst, math.abs(found - expected) / scale)
  end)
  table.insert(rows, { what, count, worst })
end

--- A lamp over the square's middle, seen from above, `angle` degrees off the mirror direction.
local function tilted(angle, distance)
  local a = math.rad(angle)
  local l = { math.sin(a), 0, math.cos(a) }
  return { distance * l[1], 0, distance * l[3] }, { -l[1], 0, -l[3] }, math.cos(a)
end

check("exponent 1 to 10⁶", function(pair)
  for power = 0, 6 do
    local n = 10 ^ power
    for _, share in ipairs { 0, 0.5, 1, 2 } do
      -- at `share` of the lobe's width, f32 positions as the ray set stores them
      local angle = math.deg(share / math.sqrt(n)) / 2
      local position, direction = tilted(angle, 100)
      local ray = lamp_at(position, direction, 1):rays()[1]
      local p, q = ray.position, ray.direction
      local r = math.sqrt(p[1] ^ 2 + p[3] ^ 2)
      local emitted = -(p[1] * q[1] + p[3] * q[3]) / r
      local x = (p[1] / r) ^ 2 / (1 + p[3] / r) -- 1 − cos, without the loss
      local expected = emitted * math.exp(n * (math.log(1 - x)))
      if x < 1e-8 then expected = emitted * math.exp(-n * (x + x * x / 2)) end
      if p[3] > 0 then
        local surface = { mesh = square(10, 0), material = lobe(n) }
        pair(look({ surface }, { lamp_at(position, direction, 1) }), expected)
      end
    end
  end
end)

check("flux 10⁻¹² to 10¹² lm", function(pair)
  for power = -12, 12, 3 do
    local light = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 10.0 ^ power)
    pair(look({ plate }, { light }), 10.0 ^ power)
  end
end)

check("scene of 1 µm to 1 km", function(pair)
  for power = -3, 6 do
    local s = 10.0 ^ power
    local light = lamp_at({ 0, 0, s }, { 0, 0, -1 }, 1)
    pair(look({ { mesh = square(s, 0), material = diffuse } }, { light }, { distance = 3 * s }), 1)
  end
end)

check("eye at 1 mm to 10 km", function(pair)
  for power = 0, 7 do
    local light = lamp_at({ 0, 0, 0.5 }, { 0, 0, -1 }, 1)
    pair(look({ plate }, { light }, {
      distance = 10.0 ^ power, fov = 1e-6,
    }), 1)
  end
end)

check("view grazing to 89.999°", function(pair)
  for _, angle in ipairs { 60, 85, 89, 89.9, 89.99, 89.999 } do
    local light = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 1)
    pair(look({ plate }, { light }, {
      azimuth = angle, fov = 1e-7,
    }), 1)
  end
end)

check("light grazing to 89.999°", function(pair)
  for _, angle in ipairs { 60, 85, 89, 89.9, 89.99, 89.999 } do
    local position, direction = tilted(angle, 100)
    local ray = lamp_at(position, direction, 1):rays()[1]
    local p, q = ray.position, ray.direction
    local r = math.sqrt(p[1] ^ 2 + p[3] ^ 2)
    local expected = -(p[1] * q[1] + p[3] * q[3]) / r * p[3] / r
    pair(look({ plate }, { lamp_at(position, direction, 1) }), expected)
  end
end)

check("slivers to an aspect of 10⁶", function(pair)
  for power = 0, 6 do
    local long = 10.0 ^ power
    local mesh = lampyris.mesh.new {
      positions = { { -long, -1, 0 }, { long, -1, 0 }, { 0, 1, 0 } }, triangles = { { 1, 2, 3 } },
    }
    local light = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 1)
    pair(look({ { mesh = mesh, material = diffuse } }, { light }, { fov = 1e-6 }), 1)
  end
end)

check("coincident faces", function(pair)
  local light = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 1)
  local object = { mesh = square(10, 0), material = diffuse }
  pair(look({ object, object }, { light }), 1)
end)

check("1 to 10⁷ samples", function(pair)
  for power = 0, paper.size(7, 4) do
    local light = lampyris.cylinder {
      center = { 0, 0, 50 }, axis = { 1, 0, 0 }, radius = 1e-4, length = 1e-4, flux = 1,
      spectrum = white, samples = 10 ^ power // 1, seed = 3,
    }
    -- A speck: what arrives is the mean of its samples' cosines, summed here one after the other.
    local sum = 0
    if power <= 5 then
      for _, ray in ipairs(light:rays()) do
        local p, q = ray.position, ray.direction
        local r = math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2)
        local emitted = -(p[1] * q[1] + p[2] * q[2] + p[3] * q[3]) / r
        if emitted > 0 then sum = sum + ray.flux * emitted * p[3] / r end
      end
    else
      sum = look({ plate }, { light }, nil, { light_error = 1e-4 })
    end
    pair(look({ plate }, { light }), sum)
  end
end)

check("depth 64 between mirrors, R 0 to 1", function(pair)
  for _, r in ipairs { 0, 0.5, 0.9, 0.999, 1 } do
    -- The eye between two facing mirrors, each adding its ambient light: 1 + R + … + R⁶⁴.
    local mirror = lampyris.material { reflectance = r, k_rg = 1, k_a = 1 }
    local down = square(10, 10):transform { rotate = { axis = { 1, 0, 0 }, angle = 180 } }
      :transform { translate = { 0, 0, 20 } }
    local scene = lampyris.scene {
      objects = { { mesh = square(10, 0), material = mirror }, { mesh = down, material = mirror } },
      ambient = 1,
    }
    local view = lampyris.view { distance = 5, fov = 1e-6, width = 1, height = 1 }
    local image = scene:render(view, { samples = 1, max_depth = 64, min_throughput = 0 })
    local _, unit = white:xyz()
    local sum = 0
    for depth = 0, 64 do sum = sum + r ^ depth end
    pair(image:luminance(), r * sum * unit)
  end
end)

check("a sample on the surface", function(pair)
  pair(look({ plate }, { lamp_at({ 0, 0, 0 }, { 0, 0, -1 }, 1) }), 0)
end)

-- What is refused, and with which words. -----------------------------------------------------------

local refusals = {}
local function refuse(what, f)
  local ok, message = pcall(f)
  table.insert(refusals, { what, ok and "accepted" or tostring(message):gsub("^.-:%d+: ", "") })
end
refuse("exponent 0.5", function() lobe(0.5) end)
refuse("exponent 2·10⁶", function() lobe(2e6) end)
refuse("reflectance 1.1", function()
  look({ { mesh = square(1, 0), material = lampyris.material { reflectance = 1.1 } } }, {})
end)
refuse("empty spectrum", function() lampyris.spectrum.new {} end)
refuse("NaN flux", function() lamp_at({ 0, 0, 1 }, { 0, 0, -1 }, 0 / 0) end)
refuse("direction 0", function() lamp_at({ 0, 0, 1 }, { 0, 0, 0 }, 1) end)
refuse("light without luminous flux", function()
  local dark = lampyris.rayset.new {
    positions = { { 0, 0, 1 } }, directions = { { 0, 0, -1 } }, flux = 1, spectrum = 0,
  }
  look({ { mesh = square(1, 0), material = diffuse } }, { dark })
end)

-- RGB far outside the gamut: digits stay within the display's.
local digits = { lampyris.display.srgb:digital(1000, 1, 1) }
table.insert(refusals, { "XYZ (1000, 1, 1) on sRGB", "clipped to " .. table.concat(digits, ", ") })

local report = paper.report("stability", "The extremes")
report:table({ "extreme", "cases", "worst relative error" }, rows)
report:table({ "input", "answer" }, refusals)
