-- A light guide: a bent PMMA rod with prisms on its back and an LED at its end, from the front and
-- 15° outward. Light goes around the bend by total reflection, and leaves where a prism turns it.
--
--   lampyris run scripts/light_guide.lua [-- WIDTH [SAMPLES]]

local lampyris = require "lampyris"
local revolve = require "revolve"
local sheet = require "sheet"

local width = tonumber(arg[1]) or 640
local samples = tonumber(arg[2]) or 64

local RADIUS = 4 -- of the rod, mm
local DEEP, BEND, LONG = 30, 25, 150 -- straight from the LED, around, and along x
local PRISM = 2.5 -- mm from one to the next

local arc = BEND * math.pi / 2
local total = DEEP + arc + LONG

--- The rod's middle after a way s, and its direction, in the plane y = 0: from −z around to +x.
local function middle(s)
  if s < DEEP then return -LONG / 2 - BEND, -BEND - DEEP + s, 0, 1 end
  if s < DEEP + arc then
    local angle = (s - DEEP) / BEND
    return -LONG / 2 - BEND * math.cos(angle), -BEND + BEND * math.sin(angle),
      math.sin(angle), math.cos(angle)
  end
  return -LONG / 2 + s - DEEP - arc, 0, 1, 0
end

-- Rings of vertices: how far along the rod each is, and how deep its back is cut in there.
local rings = {}
local function add_ring(way, depth) rings[#rings + 1] = { way = way, depth = depth or 0 } end
for k = 0, 5 do add_ring(DEEP * k / 6) end
for k = 0, 59 do add_ring(DEEP + arc * k / 60) end
-- Prisms whose faces of 43° turn light along the rod to the viewer, and fall off steeply behind, so
-- that light which sinks a little still reaches the next; deeper toward the far end, where less light
-- is left.
local prisms = math.floor(LONG / PRISM)
for k = 0, prisms - 1 do
  local from = DEEP + arc + k * PRISM
  local depth = 0.25 + 0.65 * k / prisms
  local rise, fall = depth / math.tan(math.rad(43)), 0.2 * depth
  add_ring(from)
  add_ring(from + PRISM - rise - fall)
  add_ring(from + PRISM - fall, depth)
end
add_ring(total)

local STRIP = math.rad(40) -- half of the angle that the prisms take of the rod's back

--- A place on the rod: ring (0 to #rings − 1), angle from its back, and depth of its cut.
local function place(ring, angle, depth)
  local s = rings[ring + 1].way
  local x, z, tx, tz = middle(s)
  -- The back is to the left of the way; behind the bend that is −z.
  local bx, bz = tz, -tx
  local r = RADIUS - depth
  local c, y = r * math.cos(angle), r * math.sin(angle)
  return x + bx * c, y, z + bz * c
end

local count = #rings - 1
local function at_v(v) return math.min(math.floor(v * count + 0.5), count) end

--- The angles around the rod: 8 steps over the strip, 40 over the rest.
local function angle_of(k)
  k = k % 48
  if k <= 8 then return (k / 4 - 1) * STRIP end
  return STRIP + (k - 8) / 40 * (2 * math.pi - 2 * STRIP)
end

-- The smooth part of the rod, all but the strip of prisms.
local smooth = sheet.mesh {
  nu = 40, nv = count, columns = 1, rows = 1,
  point = function(u, v) return place(at_v(v), angle_of(8 + math.floor(40 * u + 0.5)), 0) end,
}
-- The prisms: every ring breaks, and each face is flat across.
local cuts = sheet.mesh {
  nu = 8, nv = count, columns = 1, rows = count,
  point = function(u, v)
    local ring = at_v(v)
    local angle = angle_of(math.floor(8 * u + 0.5) % 48)
    return place(ring, angle, rings[ring + 1].depth * math.min(1, 4 * (1 - math.abs(angle) / STRIP)))
  end,
}
local function cap(ring, sign)
  return sheet.mesh {
    nu = 48, nv = 2, columns = 1, rows = 1,
    point = function(u, v)
      local x, z = middle(rings[ring + 1].way)
      local px, py, pz = place(ring, angle_of(sign * math.floor(48 * u + 0.5)), 0)
      return x + (px - x) * (1 - v), py * (1 - v), z + (pz - z) * (1 - v)
    end,
  }
end

local rod = lampyris.mesh.merge { smooth, cuts, cap(0, -1), cap(count, 1) }
local clear = revolve.pmma { name = "rod" }
local dark = lampyris.material { name = "housing", reflectance = 0.03, k_d = 1 }
local x, z = middle(0)

local scene = lampyris.scene {
  objects = {
    { mesh = rod, material = clear },
    { mesh = revolve.plate(10, 0, -12, 190, 60), material = dark }, -- ends beside the bend
    { mesh = revolve.plate(-95, 0, 8, 36, 60), material = dark }, -- hides the LED and the bend
  },
  lights = {
    lampyris.emitter {
      mesh = revolve.plate(x, 0, z - 0.3, 8, 8), flux = 100, -- LEDs behind a diffuser, as wide as the rod
      spectrum = revolve.led_spectrum(625, 18), samples = 100,
    },
  },
  photometry = "absolute", shadows = true, background = revolve.sky(20),
}

local function shot(name, azimuth)
  return {
    name = name,
    view = {
      azimuth = azimuth, distance = 3000, target = { 0, 0, 0 }, fov = 2.2,
      width = width, height = width // 2,
    },
    quality = { samples = samples, max_depth = "auto", wavelength_step = 20 },
  }
end

revolve.render("light_guide", scene, { shot("00", 0), shot("15", 15) })
