-- Fig. 10: spectra at the center, the right and the bottom of model 2's lit chamber: rendered, and
-- predicted here from the lamp's sizes and the parts' spectra alone.
--
--   lampyris run scripts/fig10.lua [-- tiny]
--
-- The prediction follows one ray by the surfaces' formulas, without a mesh or the renderer: in
-- through the red lens (Snell, its path inside), to a reflector's facet, and sums eq. 9 over the
-- rays of a RAYSET there and where the ray met the lens.

local lampyris = require "lampyris"
local lamp = require "lamp"
local paper = require "paper"

local width = paper.size(320, 64)
local samples = paper.size(5000, 200)

local options = paper.lamp("model2")
local shot = options.shots[1]
local built = paper.build(options, paper.size(1, 2))
local lights = paper.lights(built, shot, samples)
local scene = lampyris.scene { objects = lamp.objects(built, options.lens), lights = lights }
local view = paper.view(shot, width)
local image = scene:render(view, { samples = 1, light_error = 0 })

-- What the renderer found: the brightest spot of three parts of the picture. A spot is as bright as
-- its darkest pixel, which keeps away from the creases between facets, where the mesh's normals are
-- means and the formulas' are not.
local spot = paper.size(1, 0)
local luminance = image:luminances()

local function darkest_around(x, y)
  local least = math.huge
  for dy = -spot, spot do
    for dx = -spot, spot do
      least = math.min(least, luminance[(y + dy) * width + x + dx + 1])
    end
  end
  return least
end

local function brightest(x0, x1, y0, y1)
  local best, place = -1, nil
  for y = math.floor(y0 * view.height), math.floor(y1 * view.height) do
    for x = math.floor(x0 * width), math.floor(x1 * width) do
      local found = darkest_around(x, y)
      if found > best then best, place = found, { x = x, y = y } end
    end
  end
  return place
end
local places = {
  { name = "center", pixel = brightest(0.46, 0.54, 0.45, 0.56) },
  { name = "right", pixel = brightest(0.55, 0.62, 0.35, 0.65) },
  { name = "bottom", pixel = brightest(0.40, 0.60, 0.58, 0.68) },
}

-- The prediction. --------------------------------------------------------------------------------

local function add(a, b, t) return { a[1] + t * b[1], a[2] + t * b[2], a[3] + t * b[3] } end
local function sub(a, b) return add(a, b, -1) end
local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
local function unit(a)
  local length = math.sqrt(dot(a, a))
  return { a[1] / length, a[2] / length, a[3] / length }, length
end

local function ray_of(pixel)
  local tan = math.tan(math.rad(view.fov / 2))
  local right = (2 * (pixel.x + 0.5) - width) / view.height * tan
  local up = (view.height - 2 * (pixel.y + 0.5)) / view.height * tan
  return { view.target[1], view.target[2], view.target[3] + view.distance }, unit { right, up, -1 }
end

-- Sizes as model2.lua and lamp.lua's defaults give them.
local size = {
  width = 400, height = 156, taper = 0.3, lift = 0.2, slant = -0.08,
  front = 124, radius_x = 1500, radius_y = 900, thickness = 3,
  flute = 8, flute_depth = 0.3,
  focal = 25, back = 0, facet_x = 18, facet_y = 15, rib = 4, margin = 4,
}

local function face(s, t)
  local lost = size.taper * size.height * s * s
  local low, high = -size.height / 2 + size.lift * lost, size.height / 2 - (1 - size.lift) * lost
  local y = low + (high - low) * t
  return (s - 0.5) * size.width + size.slant * y, y
end

--- (s, t) of a place on the face.
local function inverse(x, y)
  local s = (x - size.slant * y) / size.width + 0.5
  local _, low = face(s, 0)
  local _, high = face(s, 1)
  return s, (y - low) / (high - low)
end

local function outer(x, y)
  return size.front - x * x / (2 * size.radius_x) - y * y / (2 * size.radius_y)
end

local flutes = math.floor(size.width / size.flute + 0.5)
local function inner(x, y)
  local s = inverse(x, y)
  local a = 2 * (s * flutes - math.floor(s * flutes)) - 1
  return outer(x, y) - size.thickness - size.flute_depth * (1 - a * a)
end

-- The middle chamber: its corners on the face, its middle, and the facets' corners.
local first = 1 / 3 + 0.5 * size.rib / size.width
local last = 2 / 3 - 0.5 * size.rib / size.width
local level = size.margin / size.height
local function place(u, v) return face(first + (last - first) * u, level + (1 - 2 * level) * v) end
local x0, y0 = place(0.5, 0.5)
local x1, y1 = place(1, 1)
local columns = math.floor(2 * (x1 - x0) / size.facet_x + 0.5)
local rows_of_facets = math.floor(2 * (y1 - y0) / size.facet_y + 0.5)
local function paraboloid(u, v)
  local x, y = place(u, v)
  return size.back + ((x - x0) ^ 2 + (y - y0) ^ 2) / (4 * size.focal)
end
local function reflector(x, y)
  local s, t = inverse(x, y)
  local u = (s - first) / (last - first) * columns
  local v = (t - level) / (1 - 2 * level) * rows_of_facets
  local i, j = math.floor(u), math.floor(v)
  local p, q = u - i, v - j
  local function corner(di, dj) return paraboloid((i + di) / columns, (j + dj) / rows_of_facets) end
  return (1 - q) * ((1 - p) * corner(0, 0) + p * corner(1, 0))
    + q * ((1 - p) * corner(0, 1) + p * corner(1, 1))
end

--- Where a ray meets z = f(x, y), by Newton's method along z, and the normal toward +z there.
local function meet(f, origin, direction)
  local t = 0
  for _ = 1, 60 do
    local p = add(origin, direction, t)
    t = t + (f(p[1], p[2]) - p[3]) / direction[3]
  end
  local p, h = add(origin, direction, t), 1e-4
  local dx = (f(p[1] + h, p[2]) - f(p[1] - h, p[2])) / (2 * h)
  local dy = (f(p[1], p[2] + h) - f(p[1], p[2] - h)) / (2 * h)
  return p, (unit { -dx, -dy, 1 }), t
end

local function refract(direction, normal, eta)
  local cos = -dot(direction, normal)
  local along = add({ 0, 0, 0 }, add(direction, normal, cos), eta)
  return unit(add(along, normal, -math.sqrt(1 - dot(along, along))))
end

local rays = lights[1]:rays()

--- Σ c (k_d g_d + k_s g_s) of eq. 9 over the RAYSET, in lm: on the viewer's side, or through.
local function shading(p, normal, toward_viewer, n_d, through)
  local sum = 0
  for _, ray in ipairs(rays) do
    local to_light = unit(sub(ray.position, p))
    local emitted = -dot(to_light, ray.direction)
    local cos = dot(to_light, normal)
    if through then cos = -cos end
    if emitted > 0 and cos > 0 then
      local out = through and { -to_light[1], -to_light[2], -to_light[3] }
        or sub(add({ 0, 0, 0 }, normal, 2 * cos), to_light)
      local along = math.max(0, dot(out, toward_viewer))
      sum = sum + ray.flux * emitted * (0.08 * cos ^ n_d + 0.92 * along ^ 1500)
    end
  end
  return sum
end

local source = lights[1].spectrum
local aluminium = lampyris.spectrum.load("../data/materials/aluminium_mcpeak2015.csv")
local red = lampyris.spectrum.load("../data/materials/pmma_red_3mm.csv")

local function predicted(pixel)
  local eye, direction = ray_of(pixel)
  local p, normal = meet(outer, eye, direction)
  local at_lens = shading(p, normal, { -direction[1], -direction[2], -direction[3] }, 50, true)
  local inside = refract(direction, normal, 1 / 1.49)
  local q, back_normal, thickness = meet(inner, p, inside)
  local onward = refract(inside, back_normal, 1.49)
  local hit, facet = meet(reflector, q, onward)
  local at_reflector = shading(hit, facet, { -onward[1], -onward[2], -onward[3] }, 10, false)
  local watts = source * (1 / source:luminous_flux())
  local emitted, mirror, lens = watts:values(), aluminium:values(), red:values()
  local result = {}
  for band = 1, 81 do
    local body = lens[band] ^ (thickness / 3)
    result[band] = emitted[band]
      * (lens[band] * at_lens + 0.95 * 0.95 * body * mirror[band] * at_reflector)
  end
  return result, thickness
end

-- Both, side by side. ----------------------------------------------------------------------------

local panels, table_rows = {}, {}
for _, at in ipairs(places) do
  local rendered = image:spectrum(at.pixel):values()
  local expected, thickness = predicted(at.pixel)
  local function points(values)
    return paper.map(values, function(value, band) return { 375 + 5 * band, value } end)
  end
  table.insert(panels, {
    title = ("%s (pixel %d, %d)"):format(at.name, at.pixel.x, at.pixel.y),
    x = { label = "wavelength (nm)", range = { 560, 780 } },
    y = { label = "spectral radiance (relative)" },
    series = {
      { name = "rendered", points = points(rendered) },
      { name = "predicted", points = points(expected), style = "dashes" },
    },
  })
  local scale = paper.mean(rendered) / paper.mean(expected)
  local scaled = paper.map(expected, function(value) return value * scale end)
  table.insert(table_rows, {
    at.name, thickness, scale, paper.relative_rms(expected, rendered),
    paper.relative_rms(scaled, rendered), paper.correlation(expected, rendered),
  })
end

local report = paper.report("fig10", "Fig. 10: spectra at three places of model 2")
report:figure("fig10", lampyris.figure {
  width = 1350, height = 460, columns = 3, panels = panels,
}, ("rendered with %d light samples, and predicted without the renderer"):format(samples))
report:table({
  "place", "path in the lens (mm)", "rendered / predicted", "rms", "rms of the shape",
  "correlation",
}, table_rows)
report:note("Light that met two or more reflectors is rendered but not predicted.")
