-- Models 1 and 3 by day: unlit, lit, and lit against a low sun, on a shelf at a wall outdoors.
--
--   lampyris run scripts/daylight.lua [-- WIDTH [COARSENESS [SAMPLES]]]
--
-- The lamps' light and the day's are rendered apart and weighed afterwards: the lit picture is
-- their sum. Prints the luminance contrast of lit to unlit by region, and the phantom light: what
-- the lamp sends toward the viewer while it is off, and how sure that is. The argument "tiny" is
-- for tests.

local lampyris = require "lampyris"
local model = require "model"
local lamp = require "lamp"

local is_tiny = arg[1] == "tiny"
local width = is_tiny and 12 or tonumber(arg[1]) or 280
local coarseness = is_tiny and 16 or tonumber(arg[2]) or 2
local samples = is_tiny and 200 or tonumber(arg[3]) or 100000
local quality = {
  samples = is_tiny and 1 or 2, light_error = 0.1, max_depth = 6, wavelength_step = 20,
}

-- The days, both from CIE daylight. A low sun stands behind the viewer, a little to the right.
local days = {
  {
    name = "overcast",
    background = lampyris.environment.sky {
      kind = "overcast", illuminance = 10000, ground = 0.2,
    },
  },
  {
    name = "low_sun",
    background = lampyris.environment.sky {
      kind = "clear", sun = { azimuth = 20, elevation = 10 }, turbidity = 3, ground = 0.2,
    },
  },
}

local view_options = {
  azimuth = 12, elevation = 8, distance = 3000, target = { 0, 0, 60 }, fov = 7.4,
}

--- The camera's picture of a point: pixels from the top left.
local function project(x, y, z)
  local a, e = math.rad(view_options.azimuth), math.rad(view_options.elevation)
  local forward = { -math.sin(a) * math.cos(e), -math.sin(e), -math.cos(a) * math.cos(e) }
  local right = { math.cos(a), 0, -math.sin(a) }
  local up = {
    right[2] * forward[3] - right[3] * forward[2],
    right[3] * forward[1] - right[1] * forward[3],
    right[1] * forward[2] - right[2] * forward[1],
  }
  local target, height = view_options.target, width * 3 // 4
  local offset = { x - target[1], y - target[2], z - target[3] }
  local function dot(p, q) return p[1] * q[1] + p[2] * q[2] + p[3] * q[3] end
  local depth = view_options.distance + dot(offset, forward)
  local scale = 0.5 * height / math.tan(math.rad(0.5 * view_options.fov)) / depth
  return 0.5 * width + scale * dot(offset, right), 0.5 * height - scale * dot(offset, up), scale
end

--- The rectangle of pixels within a chamber's rim, and its mm² as the viewer sees them.
local function chamber_region(chamber)
  local x0, y0, z0 = table.unpack(chamber.focus)
  local left, _, scale = project(x0 - 45, y0, z0 + 30)
  local right = project(x0 + 45, y0, z0 + 30)
  local _, top = project(x0, y0 + 40, z0 + 30)
  local _, bottom = project(x0, y0 - 40, z0 + 30)
  local x, y = math.floor(left), math.floor(top)
  local region = {
    x = x, y = y,
    width = math.max(1, math.floor(right) - x), height = math.max(1, math.floor(bottom) - y),
  }
  return region, region.width * region.height / scale ^ 2
end

--- A part of the wall that the sun reaches: above the lamp, to the right.
local function wall_region()
  local height = width * 3 // 4
  return {
    x = width * 3 // 4, y = height // 40,
    width = math.max(1, width // 5), height = math.max(1, height // 20),
  }
end

local function scene(objects, lights, background)
  return lampyris.scene {
    objects = objects, lights = lights, background = background,
    photometry = "absolute", shadows = true,
  }
end

--- The front, top, bottom and sides of a box, or of one that is a single face.
local function box(low, high)
  local function corner(x, y, z)
    return { (x == 0 and low or high)[1], (y == 0 and low or high)[2], (z == 0 and low or high)[3] }
  end
  local positions, triangles = {}, {}
  local function face(a, b, c, d)
    local first = #positions
    for _, place in ipairs { a, b, c, d } do
      positions[#positions + 1] = corner(table.unpack(place))
    end
    triangles[#triangles + 1] = { first + 1, first + 2, first + 3 }
    triangles[#triangles + 1] = { first + 1, first + 3, first + 4 }
  end
  face({ 0, 0, 1 }, { 1, 0, 1 }, { 1, 1, 1 }, { 0, 1, 1 })
  face({ 0, 1, 1 }, { 1, 1, 1 }, { 1, 1, 0 }, { 0, 1, 0 })
  face({ 0, 0, 0 }, { 1, 0, 0 }, { 1, 0, 1 }, { 0, 0, 1 })
  face({ 1, 0, 1 }, { 1, 0, 0 }, { 1, 1, 0 }, { 1, 1, 1 })
  face({ 0, 0, 0 }, { 0, 0, 1 }, { 0, 1, 1 }, { 0, 1, 0 })
  return lampyris.mesh.new { positions = positions, triangles = triangles, smooth = false }
end

local wall_reflectance = 0.5

--- The lamp with its shell and bezel, on a foot on a shelf before a wall.
local function stage(options)
  local built = model.build(options, coarseness, { bezel = 6, shell = 16 })
  local lowest = built.shell.bounds[1][2]
  local function matt(reflectance)
    return lampyris.material { reflectance = reflectance, k_d = 1, n_d = 1 }
  end
  local wood = matt(lampyris.spectrum.new {
    { 380, 0.08 }, { 480, 0.15 }, { 580, 0.3 }, { 780, 0.45 },
  })
  local objects = lamp.objects(built, options.lens, lamp.daylight_materials())
  -- Without a wall all that is seen behind the lamp is the even ground, far below: the view looks down.
  table.move({
    { mesh = box({ -450, lowest - 24, -200 }, { 450, lowest, 270 }), material = wood },
    { mesh = box({ -900, -700, -210 }, { 900, 700, -200 }), material = matt(wall_reflectance) },
    -- The shell's lower side rises to the right; the foot ends within it.
    { mesh = box({ -110, lowest, -20 }, { 120, lowest + 18, 60 }), material = matt(0.04) },
  }, 1, 3, #objects + 1, objects)
  return built, objects
end

--- The picture as an eye sees it that is adapted to this luminance. One curve for all pictures, so
-- that what is unlit is as bright in each; "photographic" would bend by the brightest pixel.
local function save(image, name, adaptation)
  image:save(name .. ".exr")
  image:save(name .. ".png", {
    look = "seen", exposure = { adaptation = adaptation },
    tone = function(luminance) return 1 - math.exp(-luminance) end,
  })
end

--- How sure the mean luminance of a region is: its pixels' standard error. Each facet mirrors the sun
-- into a spot smaller than a pixel, which the rays of a pixel meet or miss, so that a few bright
-- pixels make much of the mean.
local function uncertainty(image, region)
  local sum, squares, count = 0, 0, region.width * region.height
  for y = region.y, region.y + region.height - 1 do
    for x = region.x, region.x + region.width - 1 do
      local seen = image:luminance { x = x, y = y, width = 1, height = 1 }
      sum, squares = sum + seen, squares + seen * seen
    end
  end
  return math.sqrt(math.max(0, squares - sum * sum / count)) / count
end

for _, gamut in ipairs { "srgb", "p3" } do
  local mean, largest = lampyris.environment.round_trip(gamut)
  print(("colors of pictures become spectra and come back within ΔE00 %.4f (mean), %.4f "
    .. "(largest) over %s"):format(mean, largest, gamut))
end

for _, options in ipairs { require "model1", require "model3" } do
  local built, objects = stage(options)
  local shot = built.shots[1]
  local view = {}
  for key, value in pairs(view_options) do view[key] = value end
  view.width, view.height = width, width * 3 // 4
  view = lampyris.view(view)
  local lit_lamp = scene(objects, model.lights(built, shot, samples), 0):render(view, quality)
  print(("%s: %d triangles"):format(built.name, built.triangle_count))
  for _, day in ipairs(days) do
    local unlit = scene(objects, {}, day.background):render(view, quality)
    local lit = unlit + lit_lamp
    local name = ("%s_%s"):format(built.name, day.name)
    -- A gray card's luminance where the wall is; the sun's glints in a lamp would dazzle a mean.
    local adaptation = unlit:luminance(wall_region()) * 0.18 / wall_reflectance
    save(unlit, name .. "_unlit", adaptation)
    save(lit, name .. "_lit", adaptation)
    print(("  %s: %s"):format(day.name, day.background))
    for k, chamber in ipairs(built.chambers) do
      local region, area_mm2 = chamber_region(chamber)
      local off, on = unlit:luminance(region), lit:luminance(region)
      local m2 = area_mm2 * 1e-6
      print(("    chamber %d: unlit %.0f, lit %.0f cd/m², contrast lit : unlit %.2f, "
        .. "phantom light %.2f ± %.2f cd"):format(
        k, off, on, on / off, off * m2, uncertainty(unlit, region) * m2))
    end
  end
end
