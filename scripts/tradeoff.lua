-- What accuracy costs: one knob at a time, and in combination, against the exact reference.
--
--   lampyris run scripts/tradeoff.lua [-- tiny]
--
-- Seconds depend on what else the machine does; light evaluations (nodes and samples of the light
-- tree looked at) do not.

local lampyris = require "lampyris"
local lamp = require "lamp"
local paper = require "paper"

local width = paper.size(72, 16)
local many = paper.size(50000, 400)
local options = paper.lamp("model1")
local shot = options.shots[1]

local exact = {
  coarseness = paper.size(1, 6), flat = false, lights = many,
  samples = 4, light_error = 0, max_depth = 12, min_throughput = 1e-5, wavelength_step = 5,
}

local function with(changes)
  local setting = {}
  for key, value in pairs(exact) do setting[key] = value end
  for key, value in pairs(changes) do setting[key] = value end
  return setting
end

-- Scenes are built once for each mesh and RAYSET.
local scenes = {}
local function scene_of(setting)
  local key = ("%g %s %d"):format(setting.coarseness, setting.flat, setting.lights)
  if not scenes[key] then
    local built = paper.build(options, setting.coarseness)
    local objects = lamp.objects(built, options.lens)
    for _, object in ipairs(objects) do
      if setting.flat then object.mesh = object.mesh:flat() end
    end
    local lights = paper.lights(built, shot, setting.lights)
    scenes[key] = lampyris.scene { objects = objects, lights = lights }
  end
  return scenes[key]
end

local function render(setting)
  return scene_of(setting):render(paper.view(shot, width), {
    samples = setting.samples, light_error = setting.light_error, max_depth = setting.max_depth,
    min_throughput = setting.min_throughput, wavelength_step = setting.wavelength_step,
  })
end

local reference = render(exact)
-- For the number of samples a pixel, which moves them: as many as settle, and a light error that
-- is far below what is measured.
local settled = render(with { samples = paper.size(64, 8), light_error = 1e-3 })

local results = {}
local function try(knob, value, changes)
  local image = render(with(changes))
  local against = (knob == "samples" or knob == "default") and settled or reference
  local difference, stats = image:compare(against), image.stats
  table.insert(results, {
    knob = knob, setting = value, seconds = stats.seconds,
    evaluations = stats.light_sums * (stats.nodes_per_sum + stats.samples_per_sum),
    rms = difference.relative_rms, worst = difference.worst,
    delta_e = difference.mean_delta_e_2000, delta_e_95 = difference.percentile_95_delta_e_2000,
    spectral = difference.spectral_rms,
  })
end

try("exact", "", {})
for _, value in ipairs { 0.1, 0.03, 0.01, 0.003, 0.001 } do
  try("light_error", value, { light_error = value })
end
for _, value in ipairs { 100, 1000, 10000 } do
  local count = math.min(value, many // 4)
  try("RAYSET", count, { lights = count })
end
for _, value in ipairs { 20, 10 } do try("wavelength_step", value, { wavelength_step = value }) end
for _, value in ipairs { 2, 4, 8 } do try("max_depth", value, { max_depth = value }) end
for _, value in ipairs { 0.1, 0.01, 0.001 } do
  try("min_throughput", value, { min_throughput = value })
end
for _, value in ipairs { 1.5, 2, 4 } do
  try("mesh", ("edges × %g"):format(value), { coarseness = exact.coarseness * value })
end
try("smooth", "false", { flat = true })
for _, value in ipairs { 1, 4, 16 } do
  try("samples", value, { samples = value, light_error = 1e-3 })
end
local function combined(light_error, samples)
  return { light_error = light_error, samples = samples, max_depth = 8, min_throughput = 1e-3 }
end
try("default", "samples 1", combined(0.01, 1))
try("default", "as shipped: 4", combined(0.01, 4))
try("default", "samples 16", combined(0.01, 16))

-- CSV, table and plot. ---------------------------------------------------------------------------

local columns = {
  "knob", "setting", "seconds", "evaluations", "rms", "worst", "delta_e", "delta_e_95", "spectral",
}
local lines = { table.concat(columns, ",") }
for _, result in ipairs(results) do
  table.insert(lines, table.concat(paper.map(columns, function(column)
    return tostring(result[column])
  end), ","))
end
lampyris.write("tradeoff.csv", table.concat(lines, "\n") .. "\n")

--- A result is on the front if none is both cheaper and closer.
local function is_best(result)
  for _, other in ipairs(results) do
    if other.evaluations < result.evaluations and other.rms < result.rms then return false end
  end
  return true
end

-- The figure's own colors are seven.
local own_colors = { samples = { 130, 130, 130 }, default = { 120, 60, 0 } }

local series, by_knob = {}, {}
for _, result in ipairs(results) do
  if result.rms > 0 then -- a log axis has no place for the exact ones
    local line = by_knob[result.knob]
    if not line then
      line = { name = result.knob, points = {}, style = "both", color = own_colors[result.knob] }
      by_knob[result.knob] = line
      table.insert(series, line)
    end
    table.insert(line.points, { result.evaluations, result.rms })
  end
end
local front = {}
for _, result in ipairs(results) do
  if result.rms > 0 and is_best(result) then
    table.insert(front, { result.evaluations, result.rms })
  end
end
table.sort(front, function(a, b) return a[1] < b[1] end)
table.insert(series, {
  name = "Pareto front", points = front, style = "dashes", color = { 0, 0, 0 },
})

local report = paper.report("tradeoff", "What accuracy costs")
report:figure("tradeoff", lampyris.figure {
  width = 1100, height = 760,
  x = { label = "light evaluations", log = true },
  y = { label = "relative rms error of luminance", log = true },
  series = series,
}, ("model 1, %d × %d pixels, %d light samples; every other knob exact"):format(
  width, width * 3 // 4, many))
report:table({
  "knob", "setting", "seconds", "10⁶ light evaluations", "rms", "worst", "ΔE00 mean", "95 %",
  "spectral rms",
}, paper.map(results, function(r)
  return {
    r.knob, r.setting, r.seconds, r.evaluations / 1e6, r.rms, r.worst, r.delta_e, r.delta_e_95,
    r.spectral,
  }
end))
for _, result in ipairs(results) do
  if result.knob == "light_error" and result.setting == 0.01 then
    report:note(("The default light_error of 0.01 looks at 1/%.0f of what the exact sum does, for an"
      .. " rms error of %.1g."):format(results[1].evaluations / result.evaluations, result.rms))
  end
end
report:note("rms and worst: relative luminance error over pixels with at least a hundredth of white.")
report:note("“samples” and “default” are compared with 64 samples a pixel, all others with the exact"
  .. " picture at the same 4 samples.")
