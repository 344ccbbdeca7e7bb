--- Scenes of a few parts, and eq. 9 over their samples in Lua's doubles: what a renderer in f32 is
-- compared with.

local lampyris = require "lampyris"

local closed_form = {}

local white = lampyris.spectrum.constant(1)

-- Scenes. ----------------------------------------------------------------------------------------

--- A square of this half width at height z, facing +z.
function closed_form.square(half, z)
  return lampyris.mesh.new {
    positions = { { -half, -half, z }, { half, -half, z }, { half, half, z }, { -half, half, z } },
    triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
  }
end

--- The same square, facing -z.
function closed_form.turned_square(half, z)
  return closed_form.square(half, -z):transform { rotate = { axis = { 1, 0, 0 }, angle = 180 } }
end

--- One sample of this flux, in lm.
function closed_form.lamp_at(position, direction, flux)
  return lampyris.rayset.new {
    positions = { position }, directions = { direction }, flux = flux, spectrum = white,
  }
end

local function over(defaults, changes)
  local result = {}
  for key, value in pairs(defaults) do result[key] = value end
  for key, value in pairs(changes or {}) do result[key] = value end
  return result
end

--- Luminance of the middle of a scene's picture.
function closed_form.look_into(scene, view, quality)
  local eye = { distance = 1000, fov = 0.01, width = 1, height = 1, target = { 0, 0, 0 } }
  local exact = { samples = 1, light_error = 0, min_throughput = 0 }
  return scene:render(lampyris.view(over(eye, view)), over(exact, quality)):luminance()
end

function closed_form.look(objects, lights, view, quality)
  return closed_form.look_into(lampyris.scene { objects = objects, lights = lights }, view, quality)
end

-- Eq. 9 in doubles, at the origin of a plane that faces +z, seen from (vx, 0, vz). ----------------

--- x = 1 − cos of the angle between unit vectors, without the loss of forming it.
local function versine(ax, ay, az, bx, by, bz)
  return ((ax - bx) ^ 2 + (ay - by) ^ 2 + (az - bz) ^ 2) / 2
end

--- ln(1 − x), to the last digits for small x.
local function log_of_one_minus(x)
  if x > 1e-4 then return math.log(1 - x) end
  return -x * (1 + x * (1 / 2 + x * (1 / 3 + x / 4)))
end

--- Σ Φ c g over rays, with g = cos of the light's angle (no exponent) or the mirror lobe.
function closed_form.sum_over(rays, exponent, vx, vz)
  local sum, lost = 0, 0 -- Kahan's
  for _, ray in ipairs(rays) do
    local p, q = ray.position, ray.direction
    local r = math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2)
    local lx, ly, lz = p[1] / r, p[2] / r, p[3] / r
    local emitted = -(lx * q[1] + ly * q[2] + lz * q[3])
    if emitted > 0 and lz > 0 then
      local g = lz
      if exponent then
        local x = versine(-lx, -ly, lz, vx or 0, 0, vz or 1)
        g = x < 1 and math.exp(exponent * log_of_one_minus(x)) or 0
      end
      local term = ray.flux * emitted * g - lost
      local next_sum = sum + term
      sum, lost = next_sum, (next_sum - sum) - term
    end
  end
  return sum
end

return closed_form
