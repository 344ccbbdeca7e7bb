--- The test lamp of docs/truth.md: a paraboloid, a cylinder in its focus, and a lens of pillows.

local lampyris = require "lampyris"
local revolve = require "revolve"
local sheet = require "sheet"

local test_lamp = {}

--- The mesh of z = r²/(4 · 25), r from 12 to 60 mm, of `around` steps about z.
function test_lamp.bowl(around)
  local function paraboloid(t)
    local r = 60 - t * 48
    return r, r * r / 100
  end
  return revolve.sheet(paraboloid, around, around // 4)
end

--- The cylinder of 440 lm along x in the focus, with what `options` says otherwise.
function test_lamp.filament(options)
  local given = {
    center = { 0, 0, 25 }, axis = { 1, 0, 0 }, radius = 0.5, length = 5.5, flux = 440,
    spectrum = lampyris.spectrum.blackbody(2856), visible = true,
  }
  for key, value in pairs(options or {}) do given[key] = value end
  return lampyris.cylinder(given)
end

--- The mesh of the lens, a closed body of 126 × 126 mm: flat in front at z = 75, 14 × 14 pillows of
-- 9 mm behind, each of `per_cell` × `per_cell` steps with its own normals.
function test_lamp.lens(per_cell)
  local function bump(t)
    local cell = t * 14
    local a = 2 * (cell - math.min(math.floor(cell), 13)) - 1
    return 0.5 * (1 - a * a)
  end
  local n = 14 * per_cell
  local function front(u, v) return 126 * u - 63, 126 * v - 63, 75 end
  local function back(u, v) return 126 * u - 63, 126 * v - 63, 72 - bump(u) - bump(v) end
  local inside = { point = back, nu = n, nv = n, columns = 14, rows = 14 }
  local function rim(at)
    return {
      nu = n, nv = 1, columns = 1, rows = 1,
      point = function(s, t)
        local u, v = at(s)
        local x, y, z = back(u, v)
        return x, y, z + t * (75 - z)
      end,
    }
  end
  return sheet.merged_mesh {
    { point = front, nu = n, nv = n, columns = 1, rows = 1 },
    sheet.turned(inside),
    rim(function(s) return s, 0 end), rim(function(s) return 1, s end),
    rim(function(s) return 1 - s, 1 end), rim(function(s) return 0, 1 - s end),
  }
end

return test_lamp
