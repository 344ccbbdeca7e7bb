-- What accuracy costs: one knob at a time, and in combination, against the exact reference.
--
--   lampyris run scripts/tradeoff.lua [-- tiny]
--
-- Writes tradeoff.csv, two figures, and tradeoff.md with the tables for README and docs.
-- Seconds depend on what else the machine does; light evaluations (nodes and samples of the light
-- tree looked at) do not.

local lampyris = require "lampyris"
local model = require "model"
local options = require "model1"
local paper = require "paper"

local width = paper.size(72, 12)
local many = paper.size(50000, 400)

local exact = {
  coarseness = paper.size(1, 6), flat = false, lights = many,
  samples = 4, light_error = 0, max_depth = 12, min_throughput = 1e-5, wavelength_step = 5,
}
local default = { samples = 4, light_error = 0.01, max_depth = 8, min_throughput = 1e-3 }
-- For what moves the places of samples or highlights: as many samples as settle. Its light error
-- is in the table, far below what is compared with it.
local settled = { samples = paper.size(128, 8), light_error = 0.01 }

-- Scenes are built once for each mesh and RAYSET.
local builds, scenes = {}, {}
local function scene_of(setting)
  local key = ("%g %s %d"):format(setting.coarseness, setting.flat, setting.lights)
  if not scenes[key] then
    local built = builds[setting.coarseness] or model.build(options, setting.coarseness)
    builds[setting.coarseness] = built
    local objects = paper.map(built.objects, function(object)
      return { mesh = setting.flat and object.mesh:flat() or object.mesh, material = object.material }
    end)
    local lights = model.lights(built, built.shots[1], setting.lights)
    scenes[key] = lampyris.scene { objects = objects, lights = lights }
  end
  return scenes[key]
end

local view = model.view(options.shots[1], width)

--- The picture with these changes of the exact setting.
local function render(changes)
  local setting = setmetatable(changes, { __index = exact })
  return scene_of(setting):render(view, {
    samples = setting.samples, light_error = setting.light_error, max_depth = setting.max_depth,
    min_throughput = setting.min_throughput, wavelength_step = setting.wavelength_step,
  })
end

--- What a picture cost, and how far it is from the reference.
local function measure(knob, setting, changes, reference)
  local image = render(changes)
  local difference, stats = image:compare(reference), image.stats
  return {
    knob = knob, setting = setting, changes = changes, seconds = stats.seconds,
    evaluations = stats.light_sums * (stats.nodes_per_sum + stats.samples_per_sum),
    rms = difference.relative_rms, worst = difference.worst,
    delta_e = difference.mean_delta_e_2000, delta_e_95 = difference.percentile_95_delta_e_2000,
    spectral = difference.spectral_rms,
  }
end

-- One knob at a time. ----------------------------------------------------------------------------

local exact_image, settled_image = render {}, render(settled)
local singles = {}
local function try(knob, setting, changes, reference)
  table.insert(singles, measure(knob, setting, changes, reference or exact_image))
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
for _, value in ipairs { 1, 4, 16, 64 } do
  try("samples", value, { samples = value, light_error = 0.01 }, settled_image)
end
local function like_settled(changes)
  for key, value in pairs(settled) do changes[key] = value end
  return changes
end
for _, value in ipairs { 1.5, 2, 4 } do
  local changes = like_settled { coarseness = exact.coarseness * value }
  try("mesh", ("edges × %g"):format(value), changes, settled_image)
end
try("smooth", "false", like_settled { flat = true }, settled_image)

-- In combination. ----------------------------------------------------------------------------------

local limits = { { 4, 1e-2 }, { 8, 1e-3 }, { 12, 1e-4 } }
local combined = {}
for _, samples in ipairs { 1, 4, 16 } do
  for _, light_error in ipairs { 0.1, 0.01, 0.003 } do
    for _, limit in ipairs(limits) do
      local changes = {
        samples = samples, light_error = light_error,
        max_depth = limit[1], min_throughput = limit[2],
      }
      local setting = ("light_error %g, max_depth %d, min_throughput %g"):format(
        light_error, limit[1], limit[2])
      table.insert(combined, measure(samples, setting, changes, settled_image))
    end
  end
end

--- Whether no other is at least as cheap and as close, and better in one of the two.
local function is_best(result)
  for _, other in ipairs(combined) do
    local cheaper, closer = result.evaluations - other.evaluations, result.rms - other.rms
    if cheaper >= 0 and closer >= 0 and cheaper + closer > 0 then return false end
  end
  return true
end

--- The cheapest of these samples a pixel whose error is that of the closest, but for a hundredth.
local function knee(samples)
  local of_samples, least = {}, math.huge
  for _, result in ipairs(combined) do
    if result.knob == samples then
      table.insert(of_samples, result)
      least = math.min(least, result.rms)
    end
  end
  local cheapest
  for _, result in ipairs(of_samples) do
    local is_close = result.rms <= 1.01 * least
    if is_close and not (cheapest and cheapest.evaluations <= result.evaluations) then
      cheapest = result
    end
  end
  return cheapest
end

-- Only what a scene requires. ----------------------------------------------------------------------

--- The fastest of some renders of two scenes in turn.
local function compare_seconds(a, b)
  local best = { math.huge, math.huge }
  for _ = 1, paper.size(5, 1) do
    for k, scene in ipairs { a, b } do
      best[k] = math.min(best[k], scene:render(view, default).stats.seconds)
    end
  end
  return best[2] / best[1]
end

--- The lamp, and beside the picture a body of glass with two lobes that ambient light would reach;
-- backgrounds that are black, and shadows that are off.
local function laden_scene()
  local built = builds[exact.coarseness]
  local objects = table.move(built.objects, 1, #built.objects, 1, {})
  table.insert(objects, {
    mesh = built.lens:transform { translate = { 0, 2000, 0 } },
    material = lampyris.material {
      reflectance = 0.5, transmittance = 0.5, thickness = 3, ior = 1.5, k_a = 0.5,
      k_d = 0.1, k_s = 0.5, n_d = 2, n_s = 100, k_rg = 0.1, k_tg = 0.9,
    },
  })
  return lampyris.scene {
    objects = objects, lights = model.lights(built, built.shots[1], many),
    background = 0, ambient = 0, shadows = false,
  }
end

-- CSV, figures, tables. ----------------------------------------------------------------------------

local columns = {
  "knob", "setting", "seconds", "evaluations", "rms", "worst", "delta_e", "delta_e_95", "spectral",
}
local lines = { table.concat(columns, ",") }
for _, results in ipairs { singles, combined } do
  for _, result in ipairs(results) do
    table.insert(lines, table.concat(paper.map(columns, function(column)
      local text = tostring(result[column])
      return text:find(",", 1, true) and ('"%s"'):format(text) or text
    end), ","))
  end
end
lampyris.write("tradeoff.csv", table.concat(lines, "\n") .. "\n")

--- Points of the results that are not exact (a log axis has no place for those), by knob.
local function series_of(results, name_of)
  local series, by_knob = {}, {}
  for _, result in ipairs(results) do
    if result.rms > 0 then
      local line = by_knob[result.knob]
      if not line then
        line = { name = name_of(result.knob), points = {}, style = "both" }
        by_knob[result.knob] = line
        table.insert(series, line)
      end
      table.insert(line.points, { result.evaluations, result.rms })
    end
  end
  return series
end

local report = paper.report("tradeoff", "What accuracy costs")
local function figure(name, series, caption)
  report:figure(name, lampyris.figure {
    width = 1100, height = 760,
    x = { label = "light evaluations", log = true },
    y = { label = "relative rms error of luminance", log = true },
    series = series,
  }, caption)
end

local singles_series = series_of(singles, function(knob) return knob end)
-- The figure's own colors are seven.
singles_series[#singles_series].color = { 130, 130, 130 }
local size = ("%d × %d pixels, %d light samples"):format(width, width * 3 // 4, many)
figure("tradeoff_knobs", singles_series, "model 1, " .. size .. "; every other knob exact")

local front = {}
for _, result in ipairs(combined) do
  if is_best(result) then table.insert(front, { result.evaluations, result.rms }) end
end
table.sort(front, function(a, b) return a[1] < b[1] end)
local series = series_of(combined, function(samples) return "samples = " .. samples end)
for _, line in ipairs(series) do line.style = "points" end
table.insert(series, {
  name = "Pareto front", points = front, style = "dashes", color = { 0, 0, 0 },
})
figure("tradeoff", series, "light_error, max_depth and min_throughput in combination; " .. size)

local markdown = {}
local function add_table(headings, rows)
  report:table(headings, rows)
  table.insert(markdown, "| " .. table.concat(headings, " | ") .. " |")
  table.insert(markdown, "|" .. ("---|"):rep(#headings))
  for _, row in ipairs(rows) do
    table.insert(markdown, "| " .. table.concat(paper.map(row, paper.text), " | ") .. " |")
  end
  table.insert(markdown, "")
end

local function cells(result, first, ...)
  local row = { first, ... }
  for _, key in ipairs { "seconds", "rms", "worst", "delta_e", "delta_e_95", "spectral" } do
    table.insert(row, ("%.2g"):format(result[key]))
  end
  table.insert(row, ("%.3g"):format(result.evaluations / 1e6))
  return row
end
local measured = {
  "seconds", "rms", "worst", "ΔE00 mean", "95 %", "spectral rms", "10⁶ light evaluations",
}
local function headings(...) return table.move(measured, 1, #measured, select("#", ...) + 1, { ... }) end

add_table(headings("knob", "setting"), paper.map(singles, function(result)
  return cells(result, result.knob, result.setting)
end))
add_table(headings("samples", "in combination", "on the front"), paper.map(combined, function(result)
  return cells(result, result.knob, result.setting, is_best(result) and "yes" or "")
end))

report:note("rms and worst: relative luminance error over pixels with at least a hundredth of white.")
report:note(("“samples” and combinations are compared with %d samples a pixel, “mesh” and “smooth” at"
  .. " as many; all others with the exact picture at the same 4."):format(settled.samples))
for _, samples in ipairs { 1, 4, 16 } do
  local found = knee(samples)
  report:note(("knee at %d samples: %s (%.3g s, rms %.2g)"):format(
    samples, found.setting, found.seconds, found.rms))
end
report:note(("features that the picture does not use, present against absent: ×%.3f"):format(
  compare_seconds(scene_of(exact), laden_scene())))
lampyris.write("tradeoff.md", table.concat(markdown, "\n"))
