--- What eq. 1 and 9 give along a ray, worked out in Lua's doubles over surfaces given as functions:
-- no mesh, no interpolated normal, no BVH, no light tree. It shares nothing with the renderer but
-- the lamp's formulas, the spectra and the rays of the RAYSET, and is slow.
--
--   local scene = prediction.scene(surfaces, rayset)
--   local spectrum = prediction.trace(scene, origin, direction, { max_depth = 8, … })
--
-- A surface is { sheet = (see sheet.lua), material = (options of lampyris.material) }. Each is cut
-- into patches that are nearly flat; a ray meets a patch where Newton's method says.

local lampyris = require "lampyris"

local prediction = {}

local BANDS = 81 -- 380 to 780 nm

-- Vectors. ---------------------------------------------------------------------------------------

local function add(a, b, t) return { a[1] + t * b[1], a[2] + t * b[2], a[3] + t * b[3] } end
local function sub(a, b) return { a[1] - b[1], a[2] - b[2], a[3] - b[3] } end
local function scaled(a, t) return { a[1] * t, a[2] * t, a[3] * t } end
local function dot(a, b) return a[1] * b[1] + a[2] * b[2] + a[3] * b[3] end
local function cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end
local function unit(a) return scaled(a, 1 / math.sqrt(dot(a, a))) end

-- Surfaces as patches. ---------------------------------------------------------------------------

--- The box around patch u0 to u1, v0 to v1, and how far its middle lies from that of its corners.
local function measured(point, u0, u1, v0, v1)
  local low, high = { math.huge, math.huge, math.huge }, { -math.huge, -math.huge, -math.huge }
  local bend = 0
  for axis = 1, 3 do
    local function at(u, v) return (select(axis, point(u0 + u * (u1 - u0), v0 + v * (v1 - v0)))) end
    for j = 0, 4 do
      for i = 0, 4 do
        local here = at(i / 4, j / 4)
        low[axis], high[axis] = math.min(low[axis], here), math.max(high[axis], here)
      end
    end
    local middle = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4
    bend = math.max(bend, math.abs(at(0.5, 0.5) - middle))
  end
  local size = math.sqrt(dot(sub(high, low), sub(high, low)))
  for axis = 1, 3 do -- samples miss the bulge between them
    low[axis], high[axis] = low[axis] - 0.02 * size, high[axis] + 0.02 * size
  end
  return { u0 = u0, u1 = u1, v0 = v0, v1 = v1, low = low, high = high }, bend / size
end

--- Adds patches to `list`, halved until their bend is below a twentieth of their size.
local function add_patches(list, point, u0, u1, v0, v1)
  local patch, bend = measured(point, u0, u1, v0, v1)
  if bend < 0.05 then
    table.insert(list, patch)
    return
  end
  local u, v = (u0 + u1) / 2, (v0 + v1) / 2
  add_patches(list, point, u0, u, v0, v)
  add_patches(list, point, u, u1, v0, v)
  add_patches(list, point, u0, u, v, v1)
  add_patches(list, point, u, u1, v, v1)
end

local function patches_of(sheet)
  local list = {}
  for j = 0, sheet.rows - 1 do
    for i = 0, sheet.columns - 1 do
      add_patches(list, sheet.point, i / sheet.columns, (i + 1) / sheet.columns,
        j / sheet.rows, (j + 1) / sheet.rows)
    end
  end
  return list
end

--- The values of a number or a spectrum at all bands.
local function values_of(quantity)
  if type(quantity) == "number" then quantity = lampyris.spectrum.constant(quantity) end
  return quantity and quantity:values()
end

local function surface(of)
  local options = of.material
  return {
    sheet = of.sheet, patches = patches_of(of.sheet), material = options,
    F_r = values_of(options.reflectance or 0), F_t = values_of(options.transmittance),
  }
end

--- The surfaces, and the RAYSET's rays with its spectrum in W/nm for each lm.
function prediction.scene(surfaces, rayset)
  local list = {}
  for k, of in ipairs(surfaces) do list[k] = surface(of) end
  local spectrum = rayset.spectrum
  return {
    surfaces = list, rays = rayset:rays(),
    watts_per_lm = (spectrum * (1 / spectrum:luminous_flux())):values(),
  }
end

-- Where a ray meets them. ------------------------------------------------------------------------

local function meets_box(origin, direction, low, high, nearest)
  local enter, leave = 0, nearest
  for axis = 1, 3 do
    local o, d = origin[axis], direction[axis]
    if d == 0 then
      if o < low[axis] or o > high[axis] then return false end
    else
      local a, b = (low[axis] - o) / d, (high[axis] - o) / d
      if a > b then a, b = b, a end
      if a > enter then enter = a end
      if b < leave then leave = b end
    end
  end
  return enter <= leave
end

--- Position and both derivatives at (u, v); outside of the patch as its border's tangents go on.
local function frame_at(point, patch, u, v)
  local cu = math.max(patch.u0, math.min(patch.u1, u))
  local cv = math.max(patch.v0, math.min(patch.v1, v))
  local hu, hv = 1e-5 * (patch.u1 - patch.u0), 1e-5 * (patch.v1 - patch.v0)
  if cu + hu > patch.u1 then hu = -hu end -- never over a crease
  if cv + hv > patch.v1 then hv = -hv end
  local p = { point(cu, cv) }
  local along_u = scaled(sub({ point(cu + hu, cv) }, p), 1 / hu)
  local along_v = scaled(sub({ point(cu, cv + hv) }, p), 1 / hv)
  return add(add(p, along_u, u - cu), along_v, v - cv), along_u, along_v
end

--- Distance and normal where a ray meets a patch, by Newton's method for (u, v, distance).
local function meet_patch(sheet, patch, origin, direction)
  local u, v, distance = (patch.u0 + patch.u1) / 2, (patch.v0 + patch.v1) / 2, nil
  local normal
  for _ = 1, 12 do
    local p, along_u, along_v = frame_at(sheet.point, patch, u, v)
    normal = cross(along_u, along_v)
    local facing = dot(normal, direction)
    if facing == 0 then return nil end
    distance = dot(normal, sub(p, origin)) / facing
    local miss = sub(add(origin, direction, distance), p)
    local square = dot(normal, normal)
    local du = dot(cross(miss, along_v), normal) / square
    local dv = dot(cross(along_u, miss), normal) / square
    u, v = u + du, v + dv
    if math.abs(du) + math.abs(dv) < 1e-13 then break end
  end
  local slack = 1e-9 -- so that no ray slips between two patches
  local u_in = u >= patch.u0 - slack and u <= patch.u1 + slack
  local v_in = v >= patch.v0 - slack and v <= patch.v1 + slack
  if u_in and v_in then return distance, normal, u, v end
end

--- Whether the mesh's grid cell around (u, v) is there: it is left out if one corner is.
local function is_kept(sheet, u, v)
  if not sheet.keep then return true end
  local i = math.max(0, math.min(math.floor(u * sheet.nu), sheet.nu - 1))
  local j = math.max(0, math.min(math.floor(v * sheet.nv), sheet.nv - 1))
  for corner = 0, 3 do
    local x, y, z = sheet.point((i + corner % 2) / sheet.nu, (j + corner // 2) / sheet.nv)
    if not sheet.keep(x, y, z) then return false end
  end
  return true
end

--- The nearest hit: distance, normal N_g and surface.
local function nearest_hit(scene, origin, direction)
  local best = { distance = math.huge }
  for _, of in ipairs(scene.surfaces) do
    for _, patch in ipairs(of.patches) do
      if meets_box(origin, direction, patch.low, patch.high, best.distance) then
        local distance, normal, u, v = meet_patch(of.sheet, patch, origin, direction)
        -- Closer than a nanometre is the surface that the ray leaves.
        local is_nearer = distance and distance > 1e-6 and distance < best.distance
        if is_nearer and is_kept(of.sheet, u, v) then
          best = { distance = distance, normal = unit(normal), surface = of }
        end
      end
    end
  end
  return best.surface and best
end

-- Eq. 9 and eq. 1. -------------------------------------------------------------------------------

--- Σ Φ c (k_d g_d + k_s g_s) over the RAYSET, in lm: of the viewer's side, and of the far side.
local function light_sums(rays, p, normal, view, material)
  local reflected, transmitted = 0, 0
  local k_d, k_s, n_d, n_s = material.k_d, material.k_s, material.n_d, material.n_s
  for k = 1, #rays do
    local ray = rays[k]
    local to_light = unit(sub(ray.position, p))
    local c = -dot(to_light, ray.direction)
    if c > 0 then
      local cos = dot(to_light, normal)
      local lobe = -dot(to_light, view)
      if cos > 0 then lobe = 2 * cos * dot(normal, view) + lobe end -- R·V
      local g_s = lobe > 0 and lobe ^ n_s or 0
      local returned = ray.flux * c * (k_d * math.abs(cos) ^ n_d + k_s * g_s)
      if cos > 0 then reflected = reflected + returned end
      if cos < 0 then transmitted = transmitted + returned end
    end
  end
  return reflected, transmitted
end

--- A new throughput: `old` times a factor times a spectrum (or 1) to a power.
local function times(old, factor, values, power)
  local new = {}
  for band = 1, BANDS do
    local value = values and values[band] or 1
    new[band] = old[band] * factor * (power and value ^ power or value)
  end
  return new
end

local function is_below(throughput, limit)
  for band = 1, BANDS do
    if throughput[band] >= limit then return false end
  end
  return true
end

--- The refracted direction, or nil at total internal reflection. `normal` is on the viewer's side.
local function refracted(direction, normal, eta)
  local cos = -dot(direction, normal)
  local across = scaled(add(direction, normal, cos), eta)
  local rest = 1 - dot(across, across)
  return rest >= 0 and unit(add(across, normal, -math.sqrt(rest))) or nil
end

local follow

--- The transmitted and the mirrored ray of eq. 1.
local function follow_children(scene, hit, ray, limits, sum)
  local material, is_front = hit.surface.material, hit.is_front
  local mirror_share = material.k_rg or 0
  if hit.surface.F_t then
    local ior = material.ior or 1
    local onward = refracted(ray.direction, hit.normal, is_front and 1 / ior or ior)
    if onward then
      local body = ray.body
      if material.thickness then body = is_front and hit.surface or nil end
      follow(scene, {
        origin = hit.p, direction = onward, depth = ray.depth + 1, body = body,
        throughput =
          times(ray.throughput, material.k_tg, not material.thickness and hit.surface.F_t),
      }, limits, sum)
    else
      mirror_share = mirror_share + material.k_tg
    end
  end
  follow(scene, {
    origin = hit.p, depth = ray.depth + 1, body = ray.body,
    direction = unit(add(ray.direction, hit.normal, -2 * dot(ray.direction, hit.normal))),
    throughput = times(ray.throughput, mirror_share, hit.surface.F_r),
  }, limits, sum)
end

--- Adds what comes back along a ray to `sum`, which counts its hits and knows the deepest.
function follow(scene, ray, limits, sum)
  if is_below(ray.throughput, limits.min_throughput) then return end
  local hit = nearest_hit(scene, ray.origin, ray.direction)
  if not hit then return end
  if ray.body then
    local path = hit.distance / ray.body.material.thickness
    ray.throughput = times(ray.throughput, 1, ray.body.F_t, path)
    if is_below(ray.throughput, limits.min_throughput) then return end
  end
  hit.p = add(ray.origin, ray.direction, hit.distance)
  hit.is_front = dot(hit.normal, ray.direction) < 0
  if not hit.is_front then hit.normal = scaled(hit.normal, -1) end
  local view = scaled(ray.direction, -1)
  local reflected, transmitted =
    light_sums(scene.rays, hit.p, hit.normal, view, hit.surface.material)
  local F_r, F_t = hit.surface.F_r, hit.is_front and hit.surface.F_t
  for band = 1, BANDS do
    local returned = F_r[band] * reflected + (F_t and F_t[band] * transmitted or 0)
    sum[band] = sum[band] + ray.throughput[band] * scene.watts_per_lm[band] * returned
  end
  sum.hits, sum.depth = sum.hits + 1, math.max(sum.depth, ray.depth)
  if ray.depth < limits.max_depth then follow_children(scene, hit, ray, limits, sum) end
end

--- The spectral radiance along a ray at all bands, with `hits` and `depth`, the deepest hit's.
-- `limits` has `max_depth` and `min_throughput`, as scene:render.
function prediction.trace(scene, origin, direction, limits)
  local sum, throughput = { hits = 0, depth = 0 }, {}
  for band = 1, BANDS do sum[band], throughput[band] = 0, 1 end
  follow(scene, {
    origin = origin, direction = unit(direction), depth = 0, throughput = throughput,
  }, limits, sum)
  return sum
end

return prediction
