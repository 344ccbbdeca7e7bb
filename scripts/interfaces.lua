-- Where materials meet: slab, prism, two-shot lens, nested bodies, painted face and rough mirror,
-- each beside its closed form.
--
--   lampyris run scripts/interfaces.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"

local report = paper.report("interfaces", "Where materials meet")
local white = lampyris.spectrum.constant(1)
local pmma, aluminium = lampyris.optical.pmma, lampyris.optical.aluminium

-- Scenes. ----------------------------------------------------------------------------------------

--- A closed body over a polygon of {x, z}, counter-clockwise as seen from −y, 2000 mm long.
local function body(corners)
  local count, positions, triangles = #corners, {}, {}
  for _, y in ipairs { -1000, 1000 } do
    for _, corner in ipairs(corners) do
      table.insert(positions, { corner[1], y, corner[2] })
    end
  end
  for k = 1, count do
    local after = k % count + 1
    table.insert(triangles, { after, k, k + count })
    table.insert(triangles, { after, k + count, after + count })
  end
  for k = 2, count - 1 do
    table.insert(triangles, { 1, k, k + 1 })
    table.insert(triangles, { count + 1, count + k + 1, count + k })
  end
  return lampyris.mesh.new { positions = positions, triangles = triangles, smooth = false }
end

local function slab(low, high)
  return body { { -1000, low }, { 1000, low }, { 1000, high }, { -1000, high } }
end

local function glass(options)
  local given = { transmittance = 1, ior = 1.49, k_tg = 1 }
  for key, value in pairs(options or {}) do given[key] = value end
  return lampyris.material(given)
end

local black = lampyris.material {}

--- Meshes and materials by turns, in a surround of 1.
local function surrounded(parts)
  local objects = {}
  for k = 1, #parts, 2 do table.insert(objects, { mesh = parts[k], material = parts[k + 1] }) end
  return lampyris.scene { objects = objects, background = white }
end

--- At the origin, from this angle to the side.
local function eye(angle)
  return lampyris.view {
    azimuth = angle, distance = 100, target = { 0, 0, 0 }, fov = 0.01, width = 1, height = 1,
  }
end

local exact = { samples = 1, max_depth = "auto", min_throughput = 1e-7 }
local everything = white:luminous_flux()

--- What a ray brings back, of a surround of 1.
local function seen(parts, angle)
  return surrounded(parts):render(eye(angle), exact):luminance() / everything
end

local function degrees_from_axis(direction)
  return math.deg(math.acos(math.min(math.abs(direction[3]), 1)))
end

-- Closed forms. ----------------------------------------------------------------------------------

local function dielectric(angle, n)
  local cos = math.cos(math.rad(angle))
  local inside = math.sqrt(1 - (math.sin(math.rad(angle)) / n) ^ 2)
  local s, p = (cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)
  return (s * s + p * p) / 2
end

local function metal(angle, n, k)
  local sin, cos = math.sin(math.rad(angle)), math.cos(math.rad(angle))
  local real = n * n - k * k - sin * sin
  local modulus = math.sqrt(real * real + 4 * n * n * k * k)
  local a = math.sqrt((modulus + real) / 2)
  local s = (modulus + cos * cos - 2 * a * cos) / (modulus + cos * cos + 2 * a * cos)
  local t = sin * sin / cos
  return s / 2 * (1 + (modulus + t * t - 2 * a * t) / (modulus + t * t + 2 * a * t))
end

-- By the angle. ----------------------------------------------------------------------------------

local clear = glass { fresnel = true }
local step = paper.size(2.5, 20)
local forms, ours, largest = { {}, {} }, { {}, {} }, { 0, 0 }
local green = 550
local mirror = lampyris.material { fresnel = true, n = aluminium.n:at(green), k = aluminium.k:at(green) }
for angle = 0, 87.5, step do
  local r = dielectric(angle, 1.49)
  local both = {
    -- Black behind: what comes back is R + (1 − R)² R + …, and all the rest passes.
    { 1 - seen({ slab(-10, 0), clear, slab(-12, -11), black }, angle), 1 - 2 * r / (1 + r) },
    { seen({ slab(-10, 0), mirror }, angle), metal(angle, aluminium.n:at(green), aluminium.k:at(green)) },
  }
  for k, pair in ipairs(both) do
    table.insert(ours[k], { angle, pair[1] })
    table.insert(forms[k], { angle, pair[2] })
    largest[k] = math.max(largest[k], math.abs(pair[1] - pair[2]))
  end
end
local by_angle = {
  title = "a slab of 1.49 passes, aluminium mirrors",
  x = { label = "angle (°)" }, y = { label = "share of the light", range = { 0, 1.02 } },
  series = {
    { name = "Fresnel's law", points = forms[1] },
    { name = "slab", points = ours[1], style = "points" },
    { name = "Fresnel's law for n + ik", points = forms[2] },
    { name = "aluminium, 550 nm", points = ours[2], style = "points" },
  },
}

-- Bodies. ----------------------------------------------------------------------------------------

--- Angles inside, angle behind, and what is left.
local function followed(parts, angle)
  local segments = surrounded(parts):paths(eye(angle), { max_depth = 20, min_throughput = 0 })
  local last = segments[#segments]
  return segments, degrees_from_axis(last.direction), last.throughput
end

local function tinted(ior, transmittance)
  return glass { ior = ior, transmittance = transmittance, thickness = 10 }
end
local first_shot, second_shot = tinted(1.49, 0.5), tinted(1.49, 1)
local orders = {
  { slab(-10, 0), first_shot, slab(-20, -10), second_shot },
  { slab(-20, -10), second_shot, slab(-10, 0), first_shot },
}
local rows = {
  { "slab of 1.49, 0 to 87.5°, what passes", "", "", largest[1] },
  { "aluminium, 0 to 87.5°, what is mirrored", "", "", largest[2] },
}
local function row(what, value, expected)
  table.insert(rows, { what, value, expected, math.abs(value - expected) })
end

local right_angle = body { { -10, -19 }, { 10, 1 }, { -10, 1 } }
row("right-angle prism, through its total reflection", seen({ right_angle, clear }, 0), 1)
local inside = math.asin(math.sin(math.rad(40)) / 1.49)
for k, parts in ipairs(orders) do
  local _, angle, left = followed(parts, 40)
  local order = k == 1 and "first shot first" or "second shot first"
  row("two-shot lens, " .. order .. ": leaves at (°)", angle, 40)
  row("two-shot lens, " .. order .. ": what is left", left, 0.5 ^ (1 / math.cos(inside)))
end
local nested = { slab(-30, 0), tinted(1.33, 0.9), slab(-20, -10), tinted(1.6, 1) }
local segments, angle, left = followed(nested, 40)
local function refracted(n) return math.deg(math.asin(math.sin(math.rad(40)) / n)) end
row("body of 1.6 in one of 1.33: outer (°)", degrees_from_axis(segments[2].direction), refracted(1.33))
row("body of 1.6 in one of 1.33: inner (°)", degrees_from_axis(segments[3].direction), refracted(1.6))
row("body of 1.6 in one of 1.33: leaves at (°)", angle, 40)
row("body of 1.6 in one of 1.33: what is left", left, 0.9 ^ (2 / math.cos(math.rad(refracted(1.33)))))
local paint = lampyris.material { reflectance = 0.3, k_rg = 1 }
row("glass with a back that mirrors 0.3", seen({ slab(-10, 0), glass(), slab(-11, -10), paint }, 40), 0.3)
row("the same, the back first", seen({ slab(-11, -10), paint, slab(-10, 0), glass() }, 40), 0.3)

--- Where rays run, in x and z; what leaves is drawn as far as `reach`.
local function run_of(list, reach)
  local points = {}
  for _, segment in ipairs(list) do
    local from, way = segment.start, segment.direction
    local to = segment.finish or { from[1] + reach * way[1], 0, from[3] + reach * way[3] }
    if segment.kind == "camera" then
      from = { to[1] - reach * way[1], 0, to[3] - reach * way[3] }
    end
    table.insert(points, { from[1], from[3] })
    table.insert(points, { to[1], to[3] })
    table.insert(points, {})
  end
  return points
end

local through_both = followed(orders[1], 40)
local edges = {}
for _, z in ipairs { 0, -10, -20 } do
  table.insert(edges, { -25, z })
  table.insert(edges, { 15, z })
  table.insert(edges, {})
end
local gray = { 120, 120, 120 }
local two_shot = {
  title = "two-shot lens at 40°: one glass",
  x = { label = "x (mm)", range = { -25, 15 } }, y = { label = "z (mm)", range = { -30, 10 } },
  series = {
    { name = "faces", points = edges, color = gray },
    { name = "ray", points = run_of(through_both, 15) },
  },
}

-- Dispersion. ------------------------------------------------------------------------------------

-- At the least deviation of the d line.
local incidence = math.deg(math.asin(pmma.n:at(587.56) / 2))
local tip = { 40 * math.cos(math.rad(60)) - 10, -40 * math.sin(math.rad(60)) }
local prism = body { { 30, 0 }, { -10, 0 }, tip }
local in_prism = surrounded { prism, glass { ior = pmma.n } }
local split = in_prism:paths(eye(-incidence), { dispersion = 81, min_throughput = 0 })
local came, leaving = split[1].direction, {}
for k = #split, 1, -1 do -- the last band is followed first
  if split[k].kind == "transmitted" and not split[k].finish then table.insert(leaving, split[k]) end
end
local deviations = {}
for k, segment in ipairs(leaving) do
  local d = segment.direction
  local cos = d[1] * came[1] + d[2] * came[2] + d[3] * came[3]
  deviations[k] = { 375 + 5 * k, math.deg(math.acos(cos)) }
end
local deviation = lampyris.spectrum.new(deviations)
local function by_snell(n)
  local sin = math.sin(math.rad(incidence))
  local second = math.rad(60) - math.asin(sin / n)
  return incidence + math.deg(math.asin(n * math.sin(second))) - 60
end
local lines = { { "C", 656.27 }, { "d", 587.56 }, { "F", 486.13 } }
for _, line in ipairs(lines) do
  local what = ("60° prism of PMMA, %s line (%.2f nm): deviation (°)"):format(line[1], line[2])
  row(what, deviation:at(line[2]), by_snell(pmma.n:at(line[2])))
end

local curve = {}
for lambda = 380, 780, 5 do table.insert(curve, { lambda, by_snell(pmma.n:at(lambda)) }) end
local dispersion = {
  title = "a 60° prism of PMMA",
  x = { label = "wavelength (nm)" }, y = { label = "deviation (°)" },
  series = {
    { name = "Snell's law twice", points = curve },
    { name = "each of 81 bands", points = deviations, style = "points" },
  },
}

-- A rough mirror in an even light: nothing may come back that did not arrive. ----------------------

local around = lampyris.environment.room { rows = 0, ceiling = 1, walls = 1, floor = 1 }
local function returned(lobe, n, at)
  local material = lampyris.material { reflectance = 1, k_s = 1, n_s = n, lobe = lobe }
  local scene = lampyris.scene {
    objects = { { mesh = slab(-1, 0), material = material } },
    background = around, photometry = "absolute", shadows = false,
  }
  return scene:render(eye(at), { samples = 1, light_error = 0.001 }):luminance()
end
local furnace, most = {}, 0
for _, n in ipairs { 20, 1500 } do
  for _, lobe in ipairs { "mirror", "half" } do
    local points = {}
    for at = 0, 85, step do
      local share = returned(lobe, n, at)
      table.insert(points, { at, share })
      if lobe == "half" then most = math.max(most, share) end
    end
    local name = ("%s, n_s = %d"):format(lobe == "half" and "half vector" or "R·V", n)
    table.insert(furnace, { name = name, points = points, style = lobe == "half" and "both" or "line" })
  end
end
table.insert(rows, { "half-vector lobes in an even light, 0 to 85°: at most", most, 1, math.max(most - 1, 0) })

report:figure("interfaces", lampyris.figure {
  width = 1150, height = 900, columns = 2,
  panels = {
    by_angle, two_shot, dispersion,
    {
      title = "a rough mirror in an even light",
      x = { label = "angle of view (°)" }, y = { label = "returned share" }, series = furnace,
    },
  },
}, "closed forms as lines, the renderer as points")
report:table({ "case", "Lampyris", "closed form", "difference" }, rows)
