--- A rear combination lamp of three chambers, built from a table of sizes.
--
--   local lamp = require "lamp"
--   local rear = lamp.build { coarseness = 2 }
--   lamp.objects(rear, "red") -- for lampyris.scene
--   rear.chambers[2].focus    -- where the middle chamber's bulb belongs
--
-- Lengths in mm. The optical axis is +Z, out of the lamp; +X is to the right of who looks at it.
-- A place on the lamp's face is (s, t): s from 0 (left) to 1 (right), t from 0 (bottom) to 1 (top).

local lampyris = require "lampyris"
local sheet = require "sheet"

local lamp = {}

lamp.defaults = {
  coarseness = 1, -- multiplies the length of every mesh edge
  reflector_edge = 1.2,
  lens_edge = 2.0,

  -- the face
  width = 420,
  height = 150,
  taper = 0.15, -- the right end is lower by this share
  lift = 0.7, -- share of the taper that is taken from the bottom
  slant = 0.10, -- the ends lean: mm to the right for each mm up

  -- the lens: a closed body of this thickness where it is thinnest
  lens = {
    front = 118, -- z of the outer face in the middle
    radius_x = 1500, -- how the outer face is bent from left to right
    radius_y = 900,
    thickness = 3,
    optics = { kind = "pillows", width = 9, height = 9, depth = 0.25 },
  },

  -- what is outside of the lens, for a lamp by day: mm, 0 for none
  bezel = 0, -- width of a chrome frame around the lens
  shell = 0, -- how far a body-colored housing stands out around the lens and its bezel

  -- the chambers, from left to right
  margin = 4, -- from the lens's rim to the reflectors
  rib = 4, -- between two chambers
  hole = 12, -- radius, for the bulb
  chambers = {
    { from = 0, to = 1 / 3, focal = 25, back = -14 },
    { from = 1 / 3, to = 2 / 3, focal = 25, back = 0 },
    { from = 2 / 3, to = 1, focal = 25, back = -14 },
  },
  -- of chambers without optics of their own
  optics = { kind = "pillows", width = 14, height = 14, depth = 0.7, depth_up = 0.4 },
}

--- `options` over `defaults`, table in table; lists are taken whole.
local function merged(defaults, options)
  local result = {}
  for key, value in pairs(defaults) do
    result[key] = value
  end
  for key, value in pairs(options or {}) do
    if defaults[key] == nil and key ~= 1 then
      error(("lamp: unknown key \"%s\""):format(key), 0)
    end
    local is_record = type(value) == "table" and #value == 0 and value.kind == nil
    result[key] = is_record and merged(defaults[key], value) or value
  end
  return result
end

local function lerp(a, b, t)
  return a + (b - a) * t
end

-- Optics: how far a surface stands out toward the viewer, over a grid of cells. ------------------

--- A cell's own coordinates: -1 to 1 over each of `count` cells.
local function within_cell(place, count)
  local cell = place * count
  return 2 * (cell - math.min(math.floor(cell), count - 1)) - 1
end

--- Height over the base surface at (a, b) in a cell, for depths across and up, by kind.
local relief = {
  pillows = function(a, b, across, up) return across * (1 - a * a) + up * (1 - b * b) end,
  flutes = function(a, _, across) return across * (1 - a * a) end, -- upright ridges
  bars = function(_, b, _, up) return up * (1 - b * b) end, -- level ridges
  plain = function() return 0 end,
}

--- Columns and rows of the optics' cells over a patch of this size: at least one each way.
local function cells_of(optics, width, height)
  local function count(length, cell)
    return cell and math.max(1, math.floor(length / cell + 0.5)) or 1
  end
  return { columns = count(width, optics.width), rows = count(height, optics.height) }
end

--- z over the base surface as a function of (u, v) in a patch of this size.
local function relief_function(optics, cells)
  local shape = relief[optics.kind] or error(("lamp: unknown optics \"%s\""):format(optics.kind), 0)
  local across = optics.depth or 0
  local up = optics.depth_up or across
  return function(u, v)
    return shape(within_cell(u, cells.columns), within_cell(v, cells.rows), across, up)
  end
end

-- The parts: each is one or more sheets. ----------------------------------------------------------

--- A body between two sheets of as many steps, closed along the rim, where all have the same
-- positions but normals of their own. The outside is the front of each.
local function closed_body(front, back)
  local function along_u(point)
    return { point = point, nu = front.nu, nv = 1, columns = 1, rows = 1 }
  end
  local function along_v(point)
    return { point = point, nu = front.nv, nv = 1, columns = 1, rows = 1 }
  end
  --- The rim along an edge, from the back (0) to the front (1).
  local function rim(edge_of)
    return function(along, side)
      local x, y, z = back.point(edge_of(along))
      if side == 0 then return x, y, z end -- to the last bit, as at the front
      local fx, fy, fz = front.point(edge_of(along))
      return lerp(fx, x, 1 - side), lerp(fy, y, 1 - side), lerp(fz, z, 1 - side)
    end
  end
  return {
    front,
    sheet.turned(back),
    along_u(rim(function(u) return u, 0 end)),
    along_v(rim(function(v) return 1, v end)),
    sheet.turned(along_u(rim(function(u) return u, 1 end))),
    sheet.turned(along_v(rim(function(v) return 0, v end))),
  }
end

--- x, y of a place on the face.
local function face_function(o)
  return function(s, t)
    local lost = o.taper * o.height * s * s
    local y = lerp(-0.5 * o.height + o.lift * lost, 0.5 * o.height - (1 - o.lift) * lost, t)
    return (s - 0.5) * o.width + o.slant * y, y
  end
end

--- z of the lens's outer face.
local function outer_face_function(lens)
  return function(x, y)
    return lens.front - x * x / (2 * lens.radius_x) - y * y / (2 * lens.radius_y)
  end
end

local function build_lens(o, face)
  local lens = o.lens
  local cells = cells_of(lens.optics, o.width, o.height)
  local bump = relief_function(lens.optics, cells)
  local outer = outer_face_function(lens)
  local function front(u, v)
    local x, y = face(u, v)
    return x, y, outer(x, y)
  end
  local function back(u, v)
    local x, y = face(u, v)
    return x, y, outer(x, y) - lens.thickness - bump(u, v)
  end
  local inside = sheet.new(back, o.lens_edge * o.coarseness, cells)
  local outside = { point = front, nu = inside.nu, nv = inside.nv, columns = 1, rows = 1 }
  return closed_body(outside, inside)
end

--- The part of the face that a chamber has, as a function of its own (u, v).
local function chamber_face(o, face, chamber)
  local function inset(end_of_lamp)
    return (end_of_lamp and o.margin or 0.5 * o.rib) / o.width
  end
  local a = chamber.from + inset(chamber.from == 0)
  local b = chamber.to - inset(chamber.to == 1)
  local c = o.margin / o.height
  return function(u, v)
    return face(lerp(a, b, u), lerp(c, 1 - c, v))
  end
end

local function paraboloid(focal, x, y)
  return (x * x + y * y) / (4 * focal)
end

--- z of the reflector over the chamber's middle (x0, y0), without optics.
local base_shapes = {
  paraboloid = function(chamber, dx, dy)
    return paraboloid(chamber.focal, dx, dy)
  end,
  -- Focal lengths that differ across and up, and grow outward: wider light, no facets.
  free = function(chamber, dx, dy)
    local spread = chamber.spread or { 0.04, 0.02 }
    local r2 = (dx * dx + dy * dy) / 3600
    return paraboloid(chamber.focal, dx * (1 - spread[1] * r2), dy * (1 - spread[2] * r2))
  end,
}

--- Flat facets: the base surface at the corners of each cell, bilinear between them.
local function faceted(base, columns, rows)
  return function(u, v)
    local i = math.min(math.floor(u * columns), columns - 1)
    local j = math.min(math.floor(v * rows), rows - 1)
    local p, q = u * columns - i, v * rows - j
    local function corner(di, dj)
      return base((i + di) / columns, (j + dj) / rows)
    end
    return lerp(lerp(corner(0, 0), corner(1, 0), p), lerp(corner(0, 1), corner(1, 1), p), q)
  end
end

local function build_chamber(o, face, chamber)
  local optics = chamber.optics or o.optics
  local place = chamber_face(o, face, chamber)
  local x0, y0 = place(0.5, 0.5)
  local x1, y1 = place(1, 1)
  local cells = cells_of(optics, 2 * (x1 - x0), 2 * (y1 - y0))
  local shape = base_shapes[chamber.shape or "paraboloid"]
  local function base(u, v)
    local x, y = place(u, v)
    return chamber.back + shape(chamber, x - x0, y - y0)
  end
  if optics.facets then
    base = faceted(base, cells.columns, cells.rows)
  end
  local bump = relief_function(optics, cells)
  local function reflector(u, v)
    local x, y = place(u, v)
    return x, y, base(u, v) + bump(u, v)
  end
  local outer = outer_face_function(o.lens)
  for corner = 0, 3 do
    local x, y, z = reflector(corner % 2, corner // 2)
    if z > outer(x, y) - o.lens.thickness - 2 then
      error("lamp: a reflector's corner reaches the lens: lower \"back\" or raise \"lens.front\"", 0)
    end
  end
  local edge = o.reflector_edge * o.coarseness
  local function around_hole(x, y)
    return (x - x0) ^ 2 + (y - y0) ^ 2 > o.hole ^ 2
  end
  return {
    reflector = sheet.new(reflector, edge, cells, around_hole),
    focus = { x0, y0, chamber.back + chamber.focal },
    place = place,
    rim = reflector,
    middle = { x0, y0, chamber.back },
  }
end

--- Walls from a chamber's rim to the lens, facing inward, and the bulb's socket behind the hole.
local function chamber_housing(o, chamber)
  local inner = o.lens.thickness + 1 -- clear of the pillows
  local outer = outer_face_function(o.lens)
  local edge = o.lens_edge * o.coarseness
  local function wall(edge_of)
    return sheet.new(function(u, v)
      local x, y, z = chamber.rim(edge_of(u))
      return x, y, lerp(z, outer(x, y) - inner, v)
    end, edge)
  end
  local x0, y0, z0 = table.unpack(chamber.middle)
  local radius, depth = o.hole + 2.5 * o.coarseness, 7
  local socket = {
    nu = 48, nv = 24, columns = 1, rows = 1, -- the collar bends over a twentieth
    point = function(u, v)
      -- a disc that rises to a collar around the hole
      local angle = 2 * math.pi * u
      local r = lerp(0.005, 1, v) * radius
      return x0 + r * math.cos(angle), y0 + r * math.sin(angle), z0 - depth * (1 - v ^ 8)
    end,
  }
  return {
    wall(function(u) return 1 - u, 0 end),
    wall(function(u) return u, 1 end),
    wall(function(u) return 0, u end),
    wall(function(u) return 1, 1 - u end),
    socket,
  }
end

--- What faces the viewer between and around the chambers, and the skirt around all.
local function frame(o, face)
  local outer = outer_face_function(o.lens)
  local edge = o.lens_edge * o.coarseness
  local behind = o.lens.thickness + 1
  local function strip(s0, s1, t0, t1)
    return sheet.new(function(u, v)
      local x, y = face(lerp(s0, s1, u), lerp(t0, t1, v))
      return x, y, outer(x, y) - behind
    end, edge)
  end
  local function skirt(at)
    return sheet.new(function(u, v)
      local x, y = face(at(u))
      return x, y, lerp(-12, outer(x, y) - behind, v)
    end, 2 * edge)
  end
  local side, level, half_rib = o.margin / o.width, o.margin / o.height, 0.5 * o.rib / o.width
  local parts = {
    strip(0, side, 0, 1),
    strip(1 - side, 1, 0, 1),
    strip(side, 1 - side, 0, level),
    strip(side, 1 - side, 1 - level, 1),
    skirt(function(u) return u, 0 end),
    skirt(function(u) return 1 - u, 1 end),
    skirt(function(u) return 0, 1 - u end),
    skirt(function(u) return 1, u end),
  }
  for k = 2, #o.chambers do
    local middle = o.chambers[k].from
    parts[#parts + 1] = strip(middle - half_rib, middle + half_rib, level, 1 - level)
  end
  return parts
end

--- A band around the face: four sheets, from `at(v)` = offset in mm outward and z over the lens's
-- outer face.
local function around_face(o, face, at)
  local outer = outer_face_function(o.lens)
  local edge = o.lens_edge * o.coarseness
  local function side(place)
    return sheet.turned(sheet.new(function(u, v)
      local offset, height, depth = at(v)
      local ds, dt = offset / o.width, offset / o.height
      local x, y = face(place(u, ds, dt))
      return x, y, depth and lerp(outer(x, y) + height, depth[1], depth[2]) or outer(x, y) + height
    end, edge))
  end
  return {
    side(function(u, ds, dt) return lerp(-ds, 1 + ds, u), -dt end),
    side(function(u, ds, dt) return lerp(1 + ds, -ds, u), 1 + dt end),
    side(function(u, ds, dt) return -ds, lerp(1 + dt, -dt, u) end),
    side(function(u, ds, dt) return 1 + ds, lerp(-dt, 1 + dt, u) end),
  }
end

--- A rounded frame on the lens's rim.
local function build_bezel(o, face)
  return around_face(o, face, function(v)
    return o.bezel * v, 0.5 * o.bezel * math.sin(math.pi * v) - 0.5
  end)
end

--- From the bezel outward in a quarter of an ellipse, and then back.
local function build_shell(o, face)
  local back, bend = -30, 0.5
  return around_face(o, face, function(v)
    local angle = 0.5 * math.pi * math.min(1, v / bend)
    local offset = o.bezel + o.shell * math.sin(angle)
    local height = -0.5 - 1.2 * o.shell * (1 - math.cos(angle))
    return offset, height, { back, math.max(0, (v - bend) / (1 - bend)) }
  end)
end

--- Builds the lamp: { lens, housing, chambers = { { reflector, focus }, … }, triangle_count }, a
-- mesh for each part, and `sheets`, the surfaces that were meshed:
-- { lens = { … }, housing = { … }, reflectors = { … } }. With `bezel` and `shell` it has those meshes, too.
function lamp.build(options)
  local o = merged(lamp.defaults, options)
  local face = face_function(o)
  local sheets = { lens = build_lens(o, face), housing = frame(o, face), reflectors = {} }
  local result = { sheets = sheets, chambers = {} }
  for k, chamber in ipairs(o.chambers) do
    local built = build_chamber(o, face, chamber)
    table.move(chamber_housing(o, built), 1, 5, #sheets.housing + 1, sheets.housing)
    sheets.reflectors[k] = built.reflector
    result.chambers[k] = { reflector = sheet.mesh(built.reflector), focus = built.focus }
  end
  result.lens = sheet.merged_mesh(sheets.lens)
  result.housing = sheet.merged_mesh(sheets.housing)
  result.triangle_count = #result.lens + #result.housing
  if o.bezel > 0 then result.bezel = sheet.merged_mesh(build_bezel(o, face)) end
  if o.shell > 0 then result.shell = sheet.merged_mesh(build_shell(o, face)) end
  for _, chamber in ipairs(result.chambers) do
    result.triangle_count = result.triangle_count + #chamber.reflector
  end
  return result
end

-- Materials (Table 4) and the scene's objects. ---------------------------------------------------

--- Options for lampyris.material: aluminium, red, amber, light amber PMMA, and the housing's dark
-- plastic.
function lamp.material_options()
  local function load(name)
    return lampyris.spectrum.load(("../data/materials/%s.csv"):format(name))
  end
  local function lens(name)
    return {
      reflectance = ((1.49 - 1) / (1.49 + 1)) ^ 2, -- Fresnel's, at normal incidence
      transmittance = load(name),
      thickness = 3,
      ior = 1.49,
      k_tg = 0.95, k_rg = 0.05,
      k_d = 0.08, k_s = 0.92, n_d = 50, n_s = 1500,
    }
  end
  return {
    aluminium = {
      reflectance = load "aluminium_mcpeak2015",
      k_tg = 0.05, k_rg = 0.95,
      k_d = 0.08, k_s = 0.92, n_d = 10, n_s = 1500,
    },
    red = lens "pmma_red_3mm",
    amber = lens "pmma_amber_3mm",
    light_amber = lens "pmma_light_amber_3mm",
    -- glossy black: what is not mirrored is swallowed but for a tenth
    housing = { reflectance = 0.04, k_d = 0.1, k_s = 0.9, n_d = 1, n_s = 100 },
  }
end

--- The materials themselves, by the same names.
function lamp.materials()
  local materials = {}
  for name, options in pairs(lamp.material_options()) do
    materials[name] = lampyris.material(options)
  end
  return materials
end

--- The materials for a lamp by day, in absolute photometry: the lens mirrors as much as it does, and
-- bezel and shell have theirs.
function lamp.daylight_materials()
  local options = lamp.material_options()
  for _, name in ipairs { "red", "amber", "light_amber" } do
    options[name].k_rg, options[name].k_tg, options[name].k_d = 1, 0.95, 0
  end
  options.aluminium.k_d = 0 -- mirrored rays show the surroundings, the rest of the lobe is the bulb's
  options.housing.k_rg, options.housing.k_s, options.housing.k_d = 0.9, 0.05, 0.05
  options.chrome = {
    reflectance = lampyris.spectrum.new { { 380, 0.6 }, { 500, 0.66 }, { 780, 0.64 } },
    k_rg = 0.93, k_s = 0.05, n_s = 2000, k_d = 0.02, n_d = 1,
  }
  -- silver paint under a clear coat: its gloss is a small part of what it returns
  options.body = { reflectance = 0.5, k_rg = 0.08, k_s = 0.02, n_s = 500, k_d = 0.9, n_d = 1 }
  local materials = {}
  for name, given in pairs(options) do materials[name] = lampyris.material(given) end
  return materials
end

--- The list of objects that lampyris.scene takes; `lens` names a material of lamp.materials, or of
-- the `materials` given.
function lamp.objects(built, lens, materials)
  materials = materials or lamp.materials()
  local objects = {
    { mesh = built.lens, material = materials[lens or "red"] },
    { mesh = built.housing, material = materials.housing },
  }
  for _, chamber in ipairs(built.chambers) do
    objects[#objects + 1] = { mesh = chamber.reflector, material = materials.aluminium }
  end
  if built.bezel then objects[#objects + 1] = { mesh = built.bezel, material = materials.chrome } end
  if built.shell then objects[#objects + 1] = { mesh = built.shell, material = materials.body } end
  return objects
end

return lamp
