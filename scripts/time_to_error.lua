-- CPU time for an error of luminance: the test lamp of docs/truth.md with its lens, rough mirror and
-- visible source.
--
--   lampyris run scripts/time_to_error.lua [-- WIDTH [REFERENCE_SAMPLES]]    or: [-- tiny]
--
-- Errors are relative rms of luminance over lit pixels, against a picture of many samples. The time to
-- 1 % follows from the power law between the two best pictures. CPU time is that of all threads.

local lampyris = require "lampyris"
local paper = require "paper"
local revolve = require "revolve"
local test_lamp = require "test_lamp"

local width = paper.is_tiny and 8 or tonumber(arg[1]) or 320
local reference_samples = paper.is_tiny and 32 or tonumber(arg[2]) or 400
local report = paper.report("time_to_error", "CPU time for an error of luminance")

local began = os.clock()
local mirror = lampyris.material {
  name = "mirror", reflectance = 0.9, k_s = 1, n_s = 1500, lobe = "half",
}
local scene = lampyris.scene {
  objects = {
    { mesh = test_lamp.bowl(paper.size(480, 60)), material = mirror },
    { mesh = test_lamp.lens(paper.size(24, 4)), material = revolve.pmma { name = "lens" } },
  },
  lights = { test_lamp.filament { samples = paper.size(100000, 1000) } }, photometry = "absolute", shadows = false,
}
local view = lampyris.view {
  distance = 3000, target = { 0, 0, 75 }, fov = 2.6, width = width, height = width * 3 // 4,
}

--- The picture of so many samples a pixel, and its CPU seconds.
local function shot(samples)
  local start = os.clock()
  local image = scene:render(view, { samples = samples, max_depth = "auto", wavelength_step = 20 })
  return image, os.clock() - start
end
shot(1) -- prepares the scene
local preparation = os.clock() - began

local rows = {}
local pictures = paper.map(paper.size({ 1, 4, 16, 64 }, { 1, 4 }), function(samples)
  local image, seconds = shot(samples)
  return { samples = samples, image = image, seconds = seconds }
end)
local reference, seconds = shot(reference_samples)
for k, picture in ipairs(pictures) do
  picture.error = picture.image:compare(reference).relative_rms
  rows[k] = { picture.samples, picture.seconds, picture.error }
end
report:note(("%d × %d pixels; %.3g s to prepare, reference of %d samples: %.4g s"):format(
  view.width, view.height, preparation, reference_samples, seconds))
report:table({ "samples", "CPU s", "error" }, rows)

local a, b = pictures[#pictures - 1], pictures[#pictures]
local power = math.log(b.error / a.error) / math.log(b.seconds / a.seconds)
report:note(("error falls as time to the power of %.2f: 1 %% after %.4g CPU s"):format(
  power, b.seconds * (0.01 / b.error) ^ (1 / power) + preparation))

return report
