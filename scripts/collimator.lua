-- A stop lamp of today: nine LEDs behind TIR collimators and a red outer lens, from the front and
-- 15° outward. No part has lobes of its own but the board: every ray is mirrored or refracted.
--
--   lampyris run scripts/collimator.lua [-- WIDTH [STEPS [SAMPLES]]]

local lampyris = require "lampyris"
local revolve = require "revolve"
local sheet = require "sheet"

local width = tonumber(arg[1]) or 640
local steps = tonumber(arg[2]) or 120
local samples = tonumber(arg[3]) or 64

local PITCH, LENS = 26, 40 -- mm between optics, and from the LEDs to the outer lens

--- The outer lens: a closed plate, flat in front, with pillows of 4 mm behind.
local function outer_lens(half)
  local cells = { columns = math.floor(2 * half / 4), rows = math.floor(2 * half / 4) }
  local function place(u, v) return (2 * u - 1) * half, (2 * v - 1) * half end
  local function bump(t, count)
    local cell = t * count
    local a = 2 * (cell - math.min(math.floor(cell), count - 1)) - 1
    return 0.4 * (1 - a * a)
  end
  local function front(u, v)
    local x, y = place(u, v)
    return x, y, LENS + 2.5
  end
  local function back(u, v)
    local x, y = place(u, v)
    return x, y, LENS - bump(u, cells.columns) - bump(v, cells.rows)
  end
  local inside = sheet.new(back, 0.8, cells)
  local function rim(at)
    return {
      nu = inside.nu, nv = 1, columns = 1, rows = 1,
      point = function(s, t)
        local u, v = at(s)
        local x, y, z = back(u, v)
        return x, y, z + t * (LENS + 2.5 - z)
      end,
    }
  end
  return sheet.merged_mesh {
    { point = front, nu = inside.nu, nv = inside.nv, columns = 1, rows = 1 },
    sheet.turned(inside),
    rim(function(s) return s, 0 end), rim(function(s) return 1, s end),
    rim(function(s) return 1 - s, 1 end), rim(function(s) return 0, 1 - s end),
  }
end

--- A collimator whose wall and well turn all light of its focus along z: the well's roof is the
-- hyperbola that does so by refraction, the wall the curve that does so by total reflection.
local function collimator()
  local n, well, rim = 1.49, 3, 3.2
  local function roof(angle)
    local way = 5 * (n - 1) / (n * math.cos(angle) - 1)
    return way * math.sin(angle), way * math.cos(angle)
  end
  local edge = 0 -- the angle at which the roof is as wide as the well
  while roof(edge) < well do edge = edge + 1e-4 end
  local well_top, top = roof(edge)
  --- dz/dr of the wall at (r, z), from the ray that leaves the focus and meets it there.
  local function slope(r, z)
    local low, high = 0, math.pi / 2 - 1e-6
    for _ = 1, 50 do
      local up = (low + high) / 2
      local inside = math.asin(math.sin(up) / n)
      if well * math.tan(up) + (r - well) * math.tan(inside) < z then low = up else high = up end
    end
    local inside = math.asin(math.sin(low) / n)
    return math.cos(inside) / (1 - math.sin(inside))
  end
  local wall, count, r, z = { { rim, 0 } }, 60, rim, 0
  local step = (12 - rim) / count
  for _ = 1, count do
    local middle = z + slope(r, z) * step / 2
    z = z + slope(r + step / 2, middle) * step
    r = r + step
    wall[#wall + 1] = { r, z }
  end
  local function along_wall(t)
    local k = math.min(math.floor(t * count), count - 1)
    local f = t * count - k
    local a, b = wall[k + 1], wall[k + 2]
    return a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])
  end
  return lampyris.mesh.merge {
    revolve.sheet(function(t) return roof(t * edge) end, steps, 16),
    revolve.sheet(revolve.line(well_top, top, well, 0), steps, 8),
    revolve.sheet(revolve.line(well, 0, rim, 0), steps, 1),
    revolve.sheet(along_wall, steps, count),
    revolve.sheet(revolve.line(12, z, 0, z), steps, 8),
  }, z
end

local optic, exit = collimator()
assert(exit < LENS - 2, "the optics reach the outer lens")
local clear = revolve.pmma { name = "collimator" }
local red = revolve.pmma {
  name = "outer lens", thickness = 3,
  transmittance = lampyris.spectrum.load "../data/materials/pmma_red_3mm.csv",
}
local board = lampyris.material { name = "board", reflectance = 0.05, k_d = 1 }
local half = 1.5 * PITCH + 2

local objects = {
  { mesh = outer_lens(half), material = red },
  { mesh = revolve.plate(0, 0, -1, 2 * half, 2 * half), material = board },
}
local lights = {}
local led = revolve.led_spectrum(630, 18)
for row = -1, 1 do
  for column = -1, 1 do
    local at = { column * PITCH, row * PITCH, 0 }
    objects[#objects + 1] = { mesh = optic:transform { translate = at }, material = clear }
    lights[#lights + 1] = lampyris.emitter {
      mesh = revolve.plate(at[1], at[2], 0, 1.6, 1.6), flux = 10, spectrum = led, samples = 200,
    }
  end
end

local scene = lampyris.scene {
  objects = objects, lights = lights, photometry = "absolute", shadows = true,
  background = revolve.sky(200),
}

local function shot(name, azimuth)
  return {
    name = name, exposure = { adaptation = 1000 },
    view = {
      azimuth = azimuth, distance = 3000, target = { 0, 0, 20 }, fov = 2.4,
      width = width, height = width * 3 // 4,
    },
    quality = { samples = samples, max_depth = "auto", wavelength_step = 20 },
  }
end

revolve.render("collimator", scene, { shot("00", 0), shot("15", 15) })
