-- The benchmark scene: model 1 from the front, a million light samples, at the default light error.
--
--   lampyris run scripts/bench.lua [-- tiny]
--
-- Prints one row in Markdown: what is rendered, seconds by stage, and how many rays and light sums
-- a second the picture took. Rays are those of the camera, of mirrors, of lenses and to lights.

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = paper.size(640, 16)
local samples = 4

local built = model.build(require "model1", paper.size(1, 6))
local shot = built.shots[1]
local lights = model.lights(built, shot, paper.size(1000000, 400))
local scene = lampyris.scene { objects = built.objects, lights = lights }
local stats = scene:render(model.view(shot, width), { samples = samples }).stats

--- Such as 1.2 million.
local function count(number)
  for _, unit in ipairs { { 1e6, "million" }, { 1e3, "thousand" } } do
    if number >= unit[1] then return ("%.1f %s"):format(number / unit[1], unit[2]) end
  end
  return ("%.0f"):format(number)
end

local light_samples = 0
for _, light in ipairs(lights) do light_samples = light_samples + light.count end

local rays = stats.camera_rays + stats.mirror_rays + stats.transmitted_rays + stats.shadow_rays
local columns = {
  { "triangles", count(built.triangle_count) },
  { "light samples", count(light_samples) },
  { "picture", ("%d × %d, %d rays a pixel"):format(width, width * 3 // 4, samples) },
  { "BVH", ("%.2f s"):format(stats.bvh_seconds) },
  { "light tree", ("%.2f s"):format(stats.light_tree_seconds) },
  { "rendering", ("%.1f s"):format(stats.seconds) },
  { "rays a second", count(rays / stats.seconds) },
  { "light sums a second", count(stats.light_sums / stats.seconds) },
  { "memory", ("%.0f MB"):format(stats.peak_memory_mb) },
}

local function row(place)
  local cells = paper.map(columns, function(column) return column[place] end)
  print("| " .. table.concat(cells, " | ") .. " |")
end

row(1)
print(("|---"):rep(#columns) .. "|")
row(2)
