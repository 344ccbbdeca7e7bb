-- Start points of a ray file as makers ship them, on a sphere around the bulb, and moved back to
-- the filament.
--
--   lampyris run scripts/start_points.lua [-- tiny] [-- FILE [X Y Z]]
--
-- FILE is any ray file; X Y Z is a point of the filament's axis, which runs along z. Without one the
-- script puts the rays of a cylinder (0.65 mm by 4.1 mm) on a sphere of 10 mm itself.

local lampyris = require "lampyris"
local paper = require "paper"

local file = not paper.is_tiny and arg[1] or nil
local axis_point = { tonumber(arg[2]) or 0, tonumber(arg[3]) or 0, tonumber(arg[4]) or 0 }
local samples = paper.size(2000, 200)
local sphere_radius = 10

local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end

--- Where a ray leaves the sphere around the origin.
local function on_sphere(ray)
  local p, d = ray.position, ray.direction
  local along = -dot(p, d) + math.sqrt(dot(p, d) ^ 2 - dot(p, p) + sphere_radius ^ 2)
  return { p[1] + along * d[1], p[2] + along * d[2], p[3] + along * d[3] }
end

local function made()
  local rays = lampyris.cylinder {
    axis = { 0, 0, 1 }, radius = 0.65, length = 4.1, samples = samples, flux = 460,
    spectrum = lampyris.spectrum.blackbody(2750),
  }:rays()
  return lampyris.rayset.new {
    positions = paper.map(rays, on_sphere),
    directions = paper.map(rays, function(ray) return ray.direction end),
    flux = 460, spectrum = lampyris.spectrum.blackbody(2750),
  }
end

local before = file
    and lampyris.rayset.load(file, { samples = samples, spectrum = lampyris.spectrum.blackbody(2750) })
  or made()
local after = before:starting_at { axis = { 0, 0, 1 }, through = axis_point, radius = 0 }

--- Start points across (x) and along (z), and how far they lie from the axis and along it.
local function places(set)
  local points, radius, low, high = {}, 0, math.huge, -math.huge
  for _, ray in ipairs(set:rays()) do
    local p = ray.position
    table.insert(points, { p[1], p[3] })
    radius = math.max(radius, math.sqrt((p[1] - axis_point[1]) ^ 2 + (p[2] - axis_point[2]) ^ 2))
    low, high = math.min(low, p[3]), math.max(high, p[3])
  end
  return points, { radius, low, high }
end

local function panel(title, points)
  return {
    title = title,
    x = { label = "x (mm)" }, y = { label = "z (mm)" },
    series = { { points = points, style = "points" } },
  }
end

local points_before, extent_before = places(before)
local points_after, extent_after = places(after)
local report = paper.report("start_points", "Start points moved back to the filament")
report:figure("start_points", lampyris.figure {
  width = 1200, height = 600, columns = 2,
  panels = { panel("as shipped", points_before), panel("moved back", points_after) },
}, file or "a cylinder of 0.65 mm by 4.1 mm, its rays starting on a sphere of 10 mm")
report:table({ "start points", "largest distance from the axis (mm)", "lowest z", "highest z" }, {
  { "as shipped", table.unpack(extent_before) },
  { "moved back", table.unpack(extent_after) },
})
