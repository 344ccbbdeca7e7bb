-- Start points of a ray file as makers ship them, on a sphere around the bulb, and moved back to
-- the filament.
--
--   lampyris run scripts/start_points.lua [-- tiny] [-- FILE]
--
-- FILE is a ray file of a filament of 0.65 mm radius along the z axis. Without one the script puts
-- the rays of such a filament, 4.1 mm long, on a sphere of 10 mm itself.

local lampyris = require "lampyris"
local paper = require "paper"

local file = not paper.is_tiny and arg[1] or nil
local filament_radius = 0.65
local samples = paper.size(2000, 200)
local sphere_radius = 10

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- Where a ray leaves the sphere around the origin.
local function on_sphere(ray)
  local p, d = ray.position, ray.direction
  local along = -dot(p, d) + math.sqrt(dot(p, d) ^ 2 - dot(p, p) + sphere_radius ^ 2)
  return { p[1] + along * d[1], p[2] + along * d[2], p[3] + along * d[3] }
end

local state = 4
local function uniform() -- Park and Miller's generator: the same rays everywhere
  state = state * 48271 % 2147483647
  return state / 2147483647
end

--- A ray from the cylinder's side, by Lambert's law about the normal.
local function emitted()
  local angle, z = 2 * math.pi * uniform(), 4.1 * (uniform() - 0.5)
  local normal = { math.cos(angle), math.sin(angle), 0 }
  local sine, turn = math.sqrt(uniform()), 2 * math.pi * uniform()
  local cosine = math.sqrt(1 - sine * sine)
  local across, along = sine * math.cos(turn), sine * math.sin(turn)
  return {
    position = { filament_radius * normal[1], filament_radius * normal[2], z },
    direction = {
      cosine * normal[1] - across * normal[2], cosine * normal[2] + across * normal[1], along,
    },
  }
end

local function made()
  local positions, directions = {}, {}
  for k = 1, samples do
    local ray = emitted()
    positions[k], directions[k] = on_sphere(ray), ray.direction
  end
  return lampyris.rayset.new {
    positions = positions, directions = directions, flux = 460,
    spectrum = lampyris.spectrum.blackbody(2750),
  }
end

local white = lampyris.spectrum.blackbody(2750)
local before = file and lampyris.rayset.load(file, { samples = samples, spectrum = white }) or made()
local after = before:starting_at { axis = { 0, 0, 1 }, radius = filament_radius }

--- Start points across (x) and along (z), and how far they lie from the axis and along it.
local function places(set)
  local points, radius, low, high = {}, 0, math.huge, -math.huge
  for _, ray in ipairs(set:rays()) do
    local p = ray.position
    table.insert(points, { p[1], p[3] })
    radius = math.max(radius, math.sqrt(p[1] ^ 2 + p[2] ^ 2))
    low, high = math.min(low, p[3]), math.max(high, p[3])
  end
  return points, { radius, low, high }
end

local function panel(title, points, reach)
  return {
    title = title,
    x = { label = "x (mm)", range = { -reach, reach } }, y = { label = "z (mm)" },
    series = { { points = points, style = "points" } },
  }
end

local points_before, extent_before = places(before)
local points_after, extent_after = places(after)
local report = paper.report("start_points", "Start points moved back to the filament")
report:figure("start_points", lampyris.figure {
  width = 1200, height = 600, columns = 2,
  panels = { panel("as shipped", points_before, 10.5), panel("moved back", points_after, 2.5) },
}, file or "a cylinder of 0.65 mm by 4.1 mm, its rays starting on a sphere of 10 mm")
report:table({ "start points", "largest distance from the axis (mm)", "lowest z", "highest z" }, {
  { "as shipped", table.unpack(extent_before) },
  { "moved back", table.unpack(extent_after) },
})
