-- The benchmark scenes: the views of models 1 to 4 at the default quality.
--
--   lampyris run --cache off scripts/bench.lua [-- SAMPLES [WIDTH]]      a million light samples a bulb, or as many
--
-- Prints four tables in Markdown. The first: what is rendered, seconds by stage, and how many rays
-- and light sums a second that took; rays are those of the camera, of mirrors, of lenses and to
-- lights. The second: how far light sums at hits of the views are from exact ones, and how much
-- less they cost. The third: how long pictures take whose luminance is within 10, 3 and 1 % over lit
-- pixels, how long that was thought to take after the first samples, and the samples a pixel. The
-- fourth: what shadows cost, in a close view of model 1 with 2 rays a pixel.

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = tonumber(arg[2]) or paper.size(640, 16)
local samples = 4
local light_samples = tonumber(arg[1]) or paper.size(1000000, 400)
local hits = paper.size(3000, 20)

--- Such as 1.2 million.
local function count(number)
  for _, unit in ipairs { { 1e6, "million" }, { 1e3, "thousand" } } do
    if number >= unit[1] then return ("%.1f %s"):format(number / unit[1], unit[2]) end
  end
  return ("%.0f"):format(number)
end

local function picture_row(name, built, stats)
  local rays = stats.camera_rays + stats.mirror_rays + stats.transmitted_rays + stats.shadow_rays
  return {
    name,
    count(built.triangle_count),
    ("%.2f s"):format(stats.bvh_seconds),
    ("%.2f s"):format(stats.light_tree_seconds),
    ("%.1f s"):format(stats.seconds),
    count(rays / stats.seconds),
    count(stats.light_sums / stats.seconds),
  }
end

local function light_row(name, check)
  local function percent(error) return ("%.3f %%"):format(100 * error) end
  return {
    name, percent(check.median), percent(check.percentile_95), percent(check.largest),
    ("%.2f"):format(check.largest_of_estimate), ("1/%.0f"):format(check.speedup),
  }
end

--- Seconds, what was expected, and samples of a picture within each of the errors.
local function target_row(name, scene, view, errors)
  local row = { name }
  for _, target_error in ipairs(errors) do
    local stats = scene:render(view, { target_error = target_error }).stats
    local cell = "%.1f s (%.1f expected), %.1f samples, error %.3f"
    table.insert(row, cell:format(
      stats.seconds, stats.expected_seconds, stats.target.samples, stats.target.error))
  end
  return row
end

--- Seconds with shadows and without, for each photometry.
local function shadow_rows(built, shot)
  local rows = {}
  for _, photometry in ipairs { "relative", "absolute" } do
    local function seconds(shadows)
      local scene = lampyris.scene {
        objects = built.objects, lights = model.lights(built, shot, light_samples),
        photometry = photometry, shadows = shadows,
      }
      return scene:render(model.close_view(shot, width), { samples = 2 }).stats.seconds
    end
    local without, with = seconds(false), seconds(true)
    table.insert(rows, {
      photometry, ("%.1f s"):format(without), ("%.1f s"):format(with), ("×%.1f"):format(with / without),
    })
  end
  return rows
end

local function print_table(headings, rows)
  local function line(cells) print("| " .. table.concat(cells, " | ") .. " |") end
  line(headings)
  print(("|---"):rep(#headings) .. "|")
  for _, row in ipairs(rows) do line(row) end
end

local target_errors = paper.is_tiny and { 0.5, 0.3, 0.1 } or { 0.1, 0.03, 0.01 }
local pictures, light_sums, targets, shadows, peak_memory_mb = {}, {}, {}, nil, nil
for number = 1, 4 do
  local built = model.build(require("model" .. number), paper.size(1, 6))
  shadows = shadows or shadow_rows(built, built.shots[1])
  for _, shot in ipairs(built.shots) do
    local name = ("model %d, %s"):format(number, shot.name:gsub("^0*(%d+)$", "%1°"))
    local scene, view = model.scene(built, shot, light_samples), model.view(shot, width)
    local image = scene:render(view, { samples = samples })
    peak_memory_mb = peak_memory_mb or image.stats.peak_memory_mb
    table.insert(pictures, picture_row(name, built, image.stats))
    table.insert(light_sums, light_row(name, scene:check_light_error(view, { hits = hits })))
    table.insert(targets, target_row(name, scene, view, target_errors))
  end
end

print(("%d × %d pixels, %d rays a pixel, %s light samples a bulb:\n"):format(
  width, width * 3 // 4, samples, count(light_samples)))
print_table({ "view", "triangles", "BVH", "light tree", "rendering", "rays a second",
  "light sums a second" }, pictures)
print(("\nPeak memory of the first: %.0f MB."):format(peak_memory_mb))
print(("\nLight sums at %d hits of each view, against exact ones:\n"):format(hits))
print_table({ "view", "median error", "95 %", "largest", "largest error over its estimate",
  "time of the exact sum" }, light_sums)
print("\nTime to an error of luminance over lit pixels (rms):\n")
local headings = { "view" }
for _, target_error in ipairs(target_errors) do
  table.insert(headings, ("%g %%"):format(100 * target_error))
end
print_table(headings, targets)
print("\nShadows, model 1, 0°:\n")
print_table({ "photometry", "without", "with", "ratio" }, shadows)
