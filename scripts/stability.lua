-- The extremes: worst relative errors of luminance where the answer is known in closed form, and
-- what is refused. It fails where an error exceeds its tolerance or an input is not refused.
--
--   lampyris run scripts/stability.lua [-- tiny]
--
-- The f64 reference is eq. 9 written out in Lua: see closed_form.lua.

local closed_form = require "closed_form"
local lampyris = require "lampyris"
local paper = require "paper"
local sheet = require "sheet"

local square, turned_square = closed_form.square, closed_form.turned_square
local lamp_at, look, look_into = closed_form.lamp_at, closed_form.look, closed_form.look_into
local sum_over = closed_form.sum_over
local white = lampyris.spectrum.constant(1)

local function lobe(exponent)
  return lampyris.material { reflectance = 1, k_s = 1, n_s = exponent }
end
local diffuse = lampyris.material { reflectance = 1, k_d = 1, n_d = 1 }
local plate = { mesh = square(10, 0), material = diffuse }
local above = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 1)
local _, unit = white:xyz() -- luminance of the spectrum 1

-- The checks. ------------------------------------------------------------------------------------

local rows, failures = {}, {}

--- The worst of the pairs (found, expected) that `f` yields must keep the tolerance.
local function check(what, tolerance, f)
  local worst, count = 0, 0
  f(function(found, expected)
    count = count + 1
    local error = math.abs(found - expected) / (expected == 0 and 1 or math.abs(expected))
    if error ~= error then error = math.huge end
    worst = math.max(worst, error)
  end)
  local row = { what, count, worst, tolerance }
  table.insert(rows, row)
  if count == 0 or worst > tolerance then
    table.insert(failures, ("%s: worst relative error %.3g, allowed: up to %g"):format(
      what, worst, tolerance))
  end
end

-- Samples and pictures are f32: half a last digit, 6e-8, for each of a position's and a direction's
-- coordinates, the flux and the pixel's bands. Positions and directions are read back as stored, so
-- that what is left is sums and pictures.
local SINGLE = 1e-6
-- (R·V)ⁿ to 10⁶ also multiplies what f64 loses of the directions. The model allows 1e-3.
local POWER = 1e-5

--- A lamp `angle` degrees off +z, shining at the origin.
local function tilted(angle, distance)
  local a = math.rad(angle)
  local l = { math.sin(a), 0, math.cos(a) }
  return lamp_at({ distance * l[1], 0, distance * l[3] }, { -l[1], 0, -l[3] }, 1)
end

check("exponent 1 to 10⁶", POWER, function(pair)
  for power = 0, 6 do
    local n = 10 ^ power
    for _, share in ipairs { 0, 0.5, 1, 2, 4 } do -- of the lobe's width
      local lamp = tilted(math.min(85, math.deg(share / math.sqrt(n))), 100)
      local surface = { mesh = square(10, 0), material = lobe(n) }
      pair(look({ surface }, { lamp }), sum_over(lamp:rays(), n))
    end
  end
end)

check("exponent 1 to 10⁶, seen at 89.9°", POWER, function(pair)
  for power = 0, 6 do
    local n = 10 ^ power
    local lamp = tilted(-89.9, 100)
    local surface = { mesh = square(10, 0), material = lobe(n) }
    local a = math.rad(89.9)
    pair(look({ surface }, { lamp }, { azimuth = 89.9, fov = 1e-7 }),
      sum_over(lamp:rays(), n, math.sin(a), math.cos(a)))
  end
end)

check("exponent 1 to 10⁶, light tree at 1 %", 0.01, function(pair)
  local coil = lampyris.cylinder {
    center = { 0, 0, 30 }, axis = { 1, 0, 0 }, radius = 0.5, length = 6, flux = 1,
    spectrum = white, samples = paper.size(20000, 2000), seed = 5,
  }
  local rays = coil:rays()
  for power = 0, 6 do
    local n = 10 ^ power
    local surface = { mesh = square(10, 0), material = lobe(n) }
    pair(look({ surface }, { coil }, nil, { light_error = 0.01 }), sum_over(rays, n))
  end
end)

check("flux 10⁻¹² to 10¹² lm", SINGLE, function(pair)
  for power = -12, 12, 3 do
    local light = lamp_at({ 0, 0, 50 }, { 0, 0, -1 }, 10.0 ^ power)
    pair(look({ plate }, { light }), 10.0 ^ power)
  end
end)

check("fluxes of 10⁻¹² and 10¹² lm in one set", SINGLE, function(pair)
  local positions, directions, flux, sum = {}, {}, {}, 0
  for k = 1, 1000 do
    positions[k], directions[k] = { 0, 0, 50 }, { 0, 0, -1 }
    flux[k] = 10.0 ^ (24 * (k % 2) - 12)
    sum = sum + flux[k]
  end
  pair(look({ plate }, { lampyris.rayset.new {
    positions = positions, directions = directions, flux = flux, spectrum = white,
  } }), sum)
end)

check("scene of 1 µm to 1 km", SINGLE, function(pair)
  for power = -3, 6 do
    local s = 10.0 ^ power
    local light = lamp_at({ 0, 0, s }, { 0, 0, -1 }, 1)
    pair(look({ { mesh = square(s, 0), material = diffuse } }, { light }, { distance = 3 * s }), 1)
  end
end)

check("scene of 1 µm to 1 km with 10⁻¹² to 10¹² lm, in cd/m²", SINGLE, function(pair)
  for power = -3, 6, 3 do
    for flux_power = -12, 12, 6 do
      local s, flux = 10.0 ^ power, 10.0 ^ flux_power
      local scene = lampyris.scene {
        objects = { { mesh = square(s, 0), material = diffuse } },
        lights = { lamp_at({ 0, 0, s }, { 0, 0, -1 }, flux) }, photometry = "absolute",
      }
      -- I = Φ/π, E = I/r² with r in m, L = E/π.
      pair(look_into(scene, { distance = 3 * s }), flux / (math.pi * s / 1000) ^ 2)
    end
  end
end)

check("scene of 2 mm, 1 km from the origin", SINGLE, function(pair)
  local far = 2 ^ 20 -- where f32 has sixteenths of a mm, and the lamp stands on one
  local mesh = square(1, 0):transform { translate = { far, far, far } }
  local light = lamp_at({ far, far, far + 64 }, { 0, 0, -1 }, 1)
  pair(look({ { mesh = mesh, material = diffuse } }, { light }, { target = { far, far, far } }), 1)
end)

check("eye at 1 mm to 10 km", SINGLE, function(pair)
  for power = 0, 7 do
    local light = lamp_at({ 0, 0, 0.5 }, { 0, 0, -1 }, 1)
    pair(look({ plate }, { light }, { distance = 10.0 ^ power, fov = 1e-6 }), 1)
  end
end)

local grazing = { 60, 85, 89, 89.9, 89.99, 89.999 }

check("view grazing to 89.999°", SINGLE, function(pair)
  for _, angle in ipairs(grazing) do
    pair(look({ plate }, { above }, { azimuth = angle, fov = 1e-7 }), 1)
  end
end)

check("light grazing to 89.999°", SINGLE, function(pair)
  for _, angle in ipairs(grazing) do
    local lamp = tilted(angle, 100)
    pair(look({ plate }, { lamp }), sum_over(lamp:rays()))
  end
end)

check("mirror lobe (n 1500) grazing to 89.999°", POWER, function(pair)
  for _, angle in ipairs(grazing) do
    local lamp = tilted(-angle, 100)
    local surface = { mesh = square(10, 0), material = lobe(1500) }
    local a = math.rad(angle)
    pair(look({ surface }, { lamp }, { azimuth = angle, fov = 1e-7 }),
      sum_over(lamp:rays(), 1500, math.sin(a), math.cos(a)))
  end
end)

check("slivers to an aspect of 10⁶", SINGLE, function(pair)
  for power = 0, 6 do
    for _, scale in ipairs { 1, 10.0 ^ -power } do -- long, and thin
      local long, high = scale * 10.0 ^ power, scale
      local mesh = lampyris.mesh.new {
        positions = { { -long, -high, 0 }, { long, -high, 0 }, { 0, high, 0 } },
        triangles = { { 1, 2, 3 } },
      }
      local object = { mesh = mesh, material = diffuse }
      pair(look({ object }, { above }, { fov = 1e-6 }), 1)
      local off = { 0.4 * long, -0.5 * high, 0 }
      local light = lamp_at({ off[1], off[2], 50 }, { 0, 0, -1 }, 1)
      local ray = light:rays()[1].position
      pair(look({ object }, { light }, { fov = 1e-6, target = { ray[1], ray[2], 0 } }), 1)
    end
  end
end)

check("a nanometre beside the crease of two pillows", POWER, function(pair)
  local function pillows(u, v) -- 8 mm wide and 0.3 mm high
    local a = 2 * (4 * u - math.min(math.floor(4 * u), 3)) - 1
    return 32 * u - 16, 20 * v - 10, 0.3 * (1 - a * a)
  end
  local mesh = sheet.mesh(sheet.new(pillows, 1.2, { columns = 4, rows = 1 }))
  local light = lamp_at({ 512, 0, 1024 }, { -0.5, 0, -1 }, 1)
  for _, crease in ipairs { -8, 0, 8 } do
    for _, side in ipairs { -1, 1 } do
      local x = crease + side * 1e-6
      local found = look({ { mesh = mesh, material = diffuse } }, { light }, {
        target = { x, 0, 0 }, fov = 1e-9,
      })
      local rise = side * 0.15 -- the pillow's slope where it ends
      local lx, lz = 512 - x, 1024
      local length = math.sqrt(lx ^ 2 + lz ^ 2)
      local emitted = (0.5 * lx + lz) / (length * math.sqrt(1.25))
      pair(found, emitted * (lz - rise * lx) / (length * math.sqrt(1 + rise ^ 2)))
    end
  end
end)

check("coincident faces", SINGLE, function(pair)
  local twin = { mesh = turned_square(10, 0), material = diffuse }
  for _, objects in ipairs { { plate, plate }, { plate, twin }, { twin, plate } } do
    pair(look(objects, { above }), 1)
  end
end)

--- Each hit adds 1 of ambient light, and hands on all that it mirrors.
local function mirror(reflectance)
  return lampyris.material { reflectance = reflectance, k_rg = 1, k_a = 1 }
end

check("a mirrored ray leaves coincident faces", SINGLE, function(pair)
  for power = -3, 6 do
    local s = 10.0 ^ power
    local face = { mesh = square(s, 0), material = mirror(1) }
    local twin = { mesh = turned_square(s, 0), material = mirror(1) }
    for _, objects in ipairs { { face, face }, { face, twin }, { twin, face } } do
      local scene = lampyris.scene { objects = objects, ambient = 1 }
      pair(look_into(scene, { distance = 3 * s }), unit) -- not 2, by hitting the other one
    end
  end
end)

check("depth 64 between mirrors, R 0 to 1", SINGLE, function(pair)
  for _, r in ipairs { 0, 0.5, 0.9, 0.999, 1 } do
    -- The eye between two facing mirrors, each adding its ambient light: R (1 + R + … + R⁶⁴).
    local scene = lampyris.scene {
      objects = {
        { mesh = square(10, 0), material = mirror(r) },
        { mesh = turned_square(10, 20), material = mirror(r) },
      },
      ambient = 1,
    }
    local sum = r == 1 and 65 or (1 - r ^ 65) / (1 - r)
    pair(look_into(scene, { distance = 5, fov = 1e-6 }, { max_depth = 64 }), r * sum * unit)
  end
end)

check("reflectance 0 and 1", SINGLE, function(pair)
  for _, r in ipairs { 0, 1 } do
    local material = lampyris.material { reflectance = r, k_d = 1, n_d = 1 }
    pair(look({ { mesh = square(10, 0), material = material } }, { above }), r)
  end
end)

check("a sample on the surface, at the hit and beside it", 0, function(pair)
  for _, x in ipairs { 0, 1e-6, 1 } do -- L·N = 0 contributes nothing, nor does r = 0
    pair(look({ plate }, { lamp_at({ x, 0, 0 }, { 0, 0, -1 }, 1) }), 0)
  end
end)

check("a sample 1 pm to 1 mm above the hit", SINGLE, function(pair)
  for power = -9, 0 do -- the eye is near, so that the hit itself is known to less than that
    pair(look({ plate }, { lamp_at({ 0, 0, 10.0 ^ power }, { 0, 0, -1 }, 1) }, { distance = 1 }), 1)
  end
end)

--- `count` samples at eight places, of 1 and 10⁻⁶ lm in turn: an f32 sum stops growing on the way.
local function many_samples(count)
  local places, downward = {}, { 0, 0, -1 }
  for k = 1, 8 do places[k] = { k, 0, 64 } end
  local positions, directions, flux = {}, {}, {}
  for k = 1, count do
    positions[k], directions[k] = places[k % 8 + 1], downward
    flux[k] = k % 2 == 0 and 1e-6 or 1
  end
  return lampyris.rayset.new {
    positions = positions, directions = directions, flux = flux, spectrum = white,
  }
end

--- The sum over them, by place: the samples of a place are alike.
local function sum_of_many(count)
  local sum = 0
  for place = 1, 8 do
    local turn = place - 1 -- k % 8
    local samples = count // 8 + ((turn >= 1 and turn <= count % 8) and 1 or 0)
    local flux = turn % 2 == 0 and 1e-6 or 1
    local cos2 = 64 ^ 2 / (place ^ 2 + 64 ^ 2) -- the sample's cosine and the plate's
    sum = sum + samples * flux * cos2
  end
  return sum
end

local with_tree = {} -- of the same scenes: what costs is to make the sets
check("1 to 10⁷ samples", SINGLE, function(pair)
  for power = 0, paper.size(7, 4) do
    local count = math.tointeger(10 ^ power)
    local scene = lampyris.scene { objects = { plate }, lights = { many_samples(count) } }
    pair(look_into(scene), sum_of_many(count))
    table.insert(with_tree, { look_into(scene, nil, { light_error = 0.01 }), sum_of_many(count) })
  end
end)
check("1 to 10⁷ samples, light tree at 1 %", 0.01, function(pair)
  for _, found in ipairs(with_tree) do pair(table.unpack(found)) end
end)

-- Eq. 7 and 8 with the T766's printed numbers, for colors far outside of what it shows.
local t766 = {
  gain = { 1.0204, 1.0220, 0.8997 }, offset = { -0.0204, -0.0220, 0.1003 },
  gamma = { 1.9095, 1.8642, 2.1514 }, black = { 0.41, 0.53, 0.37 },
  inverse = {
    { 0.0304, -0.0129, -0.0048 }, { -0.0097, 0.0178, 0.0004 }, { 0.0005, -0.0017, 0.0077 },
  },
}
local function digit(channel, xyz)
  local linear = 0
  for k = 1, 3 do linear = linear + t766.inverse[channel][k] * (xyz[k] - t766.black[k]) end
  linear = math.max(0, math.min(1, linear))
  if linear == 0 then return 0 end
  local d = 255 / t766.gain[channel] * (linear ^ (1 / t766.gamma[channel]) - t766.offset[channel])
  return math.floor(math.max(0, math.min(255, d)) + 0.5)
end

check("digits for XYZ to ±10¹², T766", 0, function(pair)
  local directions = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 }, { -1, 1, -1 } }
  for power = -12, 12, 4 do
    for _, direction in ipairs(directions) do
      local xyz = paper.map(direction, function(part) return part * 10.0 ^ power end)
      local found = { lampyris.display.eizo_t766:digital(table.unpack(xyz)) }
      for channel = 1, 3 do pair(found[channel], digit(channel, xyz)) end
    end
  end
end)

-- What is refused, and with which words. -----------------------------------------------------------

local refusals = {}
local function refuse(what, expected, f)
  local accepted, message = pcall(f)
  message = accepted and "accepted" or tostring(message):gsub("^.-:%d+: ", "")
  table.insert(refusals, { what, message })
  if accepted or not message:find(expected, 1, true) then
    table.insert(failures, ("%s: %s, expected: %s"):format(what, message, expected))
  end
end
refuse("exponent 0.5", "allowed: 1 to 1000000", function() lobe(0.5) end)
refuse("exponent 2·10⁶", "allowed: 1 to 1000000", function() lobe(2e6) end)
refuse("reflectance 1.1", "allowed: 0 to 1", function()
  look({ { mesh = square(1, 0), material = lampyris.material { reflectance = 1.1 } } }, {})
end)
refuse("empty spectrum", "no rows", function() lampyris.spectrum.new {} end)
refuse("no light samples", "rayset.new", function()
  lampyris.rayset.new { positions = {}, directions = {}, flux = 1, spectrum = white }
end)
refuse("mesh without triangles", "no triangles", function()
  lampyris.mesh.new { positions = { { 0, 0, 0 } }, triangles = {} }
end)
refuse("NaN position", "finite", function()
  lampyris.mesh.new { positions = { { 0 / 0, 0, 0 } }, triangles = { { 1, 1, 1 } } }
end)
refuse("NaN flux", "\"flux\"", function() lamp_at({ 0, 0, 1 }, { 0, 0, -1 }, 0 / 0) end)
refuse("flux 10¹⁰⁰ lm", "1e32", function() lamp_at({ 0, 0, 1 }, { 0, 0, -1 }, 1e100) end)
refuse("direction 0", "allowed: any direction", function() lamp_at({ 0, 0, 1 }, { 0, 0, 0 }, 1) end)
refuse("light without luminous flux", "no luminous flux", function()
  local dark = lampyris.rayset.new {
    positions = { { 0, 0, 1 } }, directions = { { 0, 0, -1 } }, flux = 1, spectrum = 0,
  }
  look({ plate }, { dark })
end)
refuse("XYZ of NaN on a display", "NaN", function() lampyris.display.srgb:digital(0 / 0, 1, 1) end)

local lines = { "extreme,cases,worst,allowed" }
for _, row in ipairs(rows) do
  table.insert(lines, ('"%s",%d,%g,%g'):format(table.unpack(row)))
end
lampyris.write("stability.csv", table.concat(lines, "\n") .. "\n")

local report = paper.report("stability", "The extremes")
report:table({ "extreme", "cases", "worst relative error", "allowed" }, rows)
report:table({ "input", "answer" }, refusals)
if #failures > 0 then error("stability: " .. table.concat(failures, "\nstability: "), 0) end
