-- How well `target_error` is kept: the true error of luminance against the exact reference, and
-- what it cost, for the lamps of Table 5 and two scenes that had no part in its making.
--
--   lampyris run scripts/target_error.lua [-- tiny]
--
-- Writes target_error.csv, a figure, and target_error.md with the table for the docs.

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = paper.size(12, 6)
local targets = paper.size({ 0.1, 0.03, 0.01 }, { 0.3, 0.1 })
local reference_samples = paper.size(16384, 1024)
local light_samples = paper.size(100, 50)

local function lamp(name)
  local built = model.build(require(name), paper.size(1, 6))
  local shot = built.shots[1]
  return { name = name, scene = model.scene(built, shot, light_samples), view = model.view(shot, width) }
end

--- A grid over x and y within `half`, of `cells` cells a side.
local function sheet(half, cells, height)
  return lampyris.mesh.surface {
    nu = cells, nv = cells,
    point = function(u, v)
      local x, y = (2 * u - 1) * half, (2 * v - 1) * half
      return x, y, height(x, y)
    end,
  }
end

--- A round headlamp: a bare paraboloid with a cylinder of light in its focus, in cd/m², that
-- throws shadows on its rim and stands before a gray sky.
local function paraboloid()
  local focal = 25
  local bowl = sheet(70, 160, function(x, y)
    return math.min((x * x + y * y) / (4 * focal), 45)
  end)
  local metal = lampyris.material {
    reflectance = 0.9, k_d = 0.1, n_d = 1, k_s = 0.7, n_s = 200, k_rg = 0.8,
  }
  local shade = sheet(6, 1, function() return 40 end)
  local black = lampyris.material { reflectance = 0.05, k_d = 1, n_d = 1 }
  local filament = lampyris.cylinder {
    center = { 0, 0, focal }, axis = { 1, 0, 0 }, radius = 0.6, length = 5,
    samples = light_samples, seed = 7, flux = 1000, spectrum = lampyris.spectrum.blackbody(3200),
  }
  return {
    name = "paraboloid",
    scene = lampyris.scene {
      objects = { { mesh = bowl, material = metal }, { mesh = shade, material = black } },
      lights = { filament }, photometry = "absolute", shadows = true,
      background = lampyris.spectrum.illuminant "D65" * 1e-3,
    },
    view = lampyris.view {
      azimuth = 20, elevation = 10, distance = 1000, fov = 9, width = width, height = width * 3 // 4,
    },
  }
end

--- A wavy slab of amber glass before a matt wall, lit from the side.
local function glass()
  local function wave(x, y) return 2 * math.sin(x / 4) * math.cos(y / 5) end
  local front = sheet(30, 120, function(x, y) return 30 + wave(x, y) end)
  local back = sheet(30, 1, function() return 20 end)
    :transform { rotate = { axis = { 1, 0, 0 }, angle = 180 } }
    :transform { translate = { 0, 0, 40 } }
  local amber = lampyris.material {
    reflectance = 0.04, transmittance = lampyris.spectrum.new { { 480, 0.05 }, { 620, 0.95 } },
    ior = 1.5, k_rg = 1, k_tg = 0.96, k_d = 0.02, n_d = 1, k_s = 0.9, n_s = 300,
  }
  local matt = lampyris.material { reflectance = 0.7, k_d = 1, n_d = 1, k_a = 1 }
  local lamp_beside = lampyris.cylinder {
    center = { 40, 30, 60 }, axis = { 0, 1, 0 }, radius = 5, length = 20,
    samples = light_samples, seed = 5, flux = 500, spectrum = lampyris.spectrum.illuminant "A",
  }
  return {
    name = "glass",
    scene = lampyris.scene {
      objects = {
        { mesh = front, material = amber }, { mesh = back, material = amber },
        { mesh = sheet(60, 2, function() return 0 end), material = matt },
      },
      lights = { lamp_beside }, ambient = 0.01,
    },
    view = lampyris.view {
      azimuth = -25, elevation = 15, distance = 400, fov = 11, width = width, height = width * 3 // 4,
    },
  }
end

local cases = {
  lamp "model1", lamp "model2", lamp "model3", lamp "model4", paraboloid(), glass(),
}

local exact = {
  samples = reference_samples, light_error = 0, max_depth = 32, min_throughput = 1e-6,
}
local rows, series = {}, {}
local lines = { "scene,target,true,estimated,worst,samples,seconds,exact_seconds" }
local kept = true
for k, case in ipairs(cases) do
  local reference = case.scene:render(case.view, exact)
  local points = {}
  for _, target in ipairs(targets) do
    local image = case.scene:render(case.view, { target_error = target })
    local difference, chosen = image:compare(reference), image.stats.target
    local found = difference.relative_rms
    kept = kept and found <= target
    table.insert(points, { target, found })
    table.insert(rows, {
      case.name, target, ("%.2g"):format(found), ("%.2g"):format(found / target),
      ("%.2g"):format(chosen.error), ("%.0f"):format(chosen.samples), chosen.light_error,
      chosen.max_depth, ("%g"):format(chosen.min_throughput),
      ("1/%.3g"):format(reference.stats.seconds / image.stats.seconds),
    })
    table.insert(lines, ("%s,%g,%.4g,%.4g,%.4g,%.1f,%.3f,%.3f"):format(
      case.name, target, found, chosen.error, difference.worst, chosen.samples,
      image.stats.seconds, reference.stats.seconds))
  end
  series[k] = { name = case.name, points = points, style = "both" }
end
table.insert(series, {
  name = "target", points = paper.map(targets, function(t) return { t, t } end), style = "dashes",
  color = { 0, 0, 0 },
})
lampyris.write("target_error.csv", table.concat(lines, "\n") .. "\n")

local report = paper.report("target_error", "Is target_error kept?")
report:figure("target_error", lampyris.figure {
  width = 900, height = 640, series = series,
  x = { label = "target_error", log = true },
  y = { label = "true relative rms error of luminance over lit pixels", log = true },
}, ("%d × %d pixels; reference: %d samples a pixel, every knob exact"):format(
  width, width * 3 // 4, reference_samples))
local headings = {
  "scene", "target", "true", "true / target", "estimated", "samples", "light_error", "max_depth",
  "min_throughput", "of the reference's time",
}
report:table(headings, rows)
report:note(kept and "every target is kept" or "a target is missed")
local markdown = {
  "| " .. table.concat(headings, " | ") .. " |", "|" .. ("---|"):rep(#headings),
}
for _, row in ipairs(rows) do
  table.insert(markdown, "| " .. table.concat(paper.map(row, paper.text), " | ") .. " |")
end
lampyris.write("target_error.md", table.concat(markdown, "\n") .. "\n")
