-- Models 1 and 3 by day: unlit, lit, and lit against a low sun, on a shelf outdoors.
--
--   lampyris run scripts/daylight.lua [-- WIDTH [COARSENESS [SAMPLES]]]
--
-- The lamps' light and the day's are rendered apart and weighed afterwards: the lit picture is
-- their sum. Prints the luminance contrast of lit to unlit by region, and the phantom light: what
-- the lamp sends toward the viewer while it is off. The argument "tiny" is for tests.

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

local function scene(objects, lights, background)
  return lampyris.scene {
    objects = objects, lights = lights, background = background,
    photometry = "absolute", shadows = true,
  }
end

--- The lamp with its shell and bezel, and a shelf under it.
local function stage(options)
  local built = model.build(options, coarseness, { bezel = 6, shell = 16 })
  local lowest = built.shell.bounds[1][2]
  local shelf = lampyris.mesh.new {
    positions = {
      { -450, lowest, -250 }, { 450, lowest, -250 }, { 450, lowest, 330 }, { -450, lowest, 330 },
    },
    triangles = { { 1, 3, 2 }, { 1, 4, 3 } },
    smooth = false,
  }
  local wood = lampyris.material {
    reflectance = lampyris.spectrum.new { { 380, 0.12 }, { 480, 0.2 }, { 580, 0.36 }, { 780, 0.5 } },
    k_d = 1, n_d = 1,
  }
  local objects = lamp.objects(built, options.lens, lamp.daylight_materials())
  objects[#objects + 1] = { mesh = shelf, material = wood }
  return built, objects
end

--- The picture as an eye sees it that is adapted to this luminance.
local function save(image, name, adaptation)
  image:save(name .. ".exr")
  image:save(name .. ".png", { look = "seen", exposure = { adaptation = adaptation } })
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
    local adaptation = unlit:luminance()
    save(unlit, name .. "_unlit", adaptation)
    save(lit, name .. "_lit", adaptation)
    print(("  %s: %s"):format(day.name, day.background))
    for k, chamber in ipairs(built.chambers) do
      local region, area_mm2 = chamber_region(chamber)
      local off, on = unlit:luminance(region), lit:luminance(region)
      print(("    chamber %d: unlit %.0f, lit %.0f cd/m², contrast lit : unlit %.2f, "
        .. "phantom light %.3f cd"):format(k, off, on, on / off, off * area_mm2 * 1e-6))
    end
  end
end
