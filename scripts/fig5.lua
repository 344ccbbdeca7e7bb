-- Fig. 5: highlights with the normals of the triangles and with interpolated ones (eq. 3), both
-- against a mesh so fine that it makes no difference.
--
--   lampyris run scripts/fig5.lua [-- tiny]

local lampyris = require "lampyris"
local lamp = require "lamp"
local paper = require "paper"

local width = paper.size(360, 48)
local samples = paper.size(20000, 200)
local coarse, fine = 3, paper.size(0.5, 2) -- times Table 5's edges of 1.2 mm

local function chamber(coarseness)
  return lamp.build({ coarseness = coarseness, optics = { kind = "plain" } }).chambers[2]
end
local coarse_chamber = chamber(coarse)

local bulb = lampyris.bulb("P21W", { center = coarse_chamber.focus, samples = samples })
local aluminium = lamp.materials().aluminium
local view = lampyris.view {
  azimuth = 3, distance = 3000, target = { 0, 0, 30 }, fov = 3, width = width, height = width,
}

local function render(mesh)
  local objects = { { mesh = mesh, material = aluminium } }
  local scene = lampyris.scene { objects = objects, lights = { bulb } }
  return scene:render(view, { samples = 4 })
end

local reference = render(chamber(fine).reflector)
local interpolated = render(coarse_chamber.reflector)
local flat = render(coarse_chamber.reflector:flat())

local side = width // 4
local crop = { x = width // 2, y = width * 3 // 5, width = side, height = side }
local brightest = math.max(table.unpack(reference:luminances(crop)))
local function panel(title, image, region)
  return { title = title, image = image, crop = region, exposure = paper.exposure(1.1 * brightest) }
end

local report = paper.report("fig5", "Fig. 5: flat and interpolated normals")
report:figure("fig5", lampyris.figure {
  width = 1200, height = 840, columns = 3,
  panels = {
    panel("flat", flat), panel("interpolated", interpolated), panel("fine mesh", reference),
    panel("flat, crop", flat, crop), panel("interpolated, crop", interpolated, crop),
    panel("fine mesh, crop", reference, crop),
  },
}, ("paraboloid of %d triangles with edges of 3.6 mm, P21W with %d samples"):format(
  #coarse_chamber.reflector, samples))

local function row(name, image)
  local difference = image:compare(reference)
  return {
    name, difference.relative_rms, difference.worst,
    difference.mean_delta_e_2000, difference.percentile_95_delta_e_2000,
  }
end
local rows = { row("flat", flat), row("interpolated", interpolated) }
report:table({ "against the fine mesh", "rms", "worst", "ΔE00 mean", "95 %" }, rows)
report:compare("relative rms with flat normals", rows[1][2], "shown")
report:compare("relative rms with interpolated normals", rows[2][2], "shown")
report:note("Luminance errors are relative, over lit pixels; the worst are at the mesh's edge. The paper"
  .. " shows both without numbers.")
