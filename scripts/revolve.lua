--- Bodies of revolution about z, and boards of LEDs: what the lamps of today share.

local lampyris = require "lampyris"

local revolve = {}

--- The sheet between two points (r, z) of a profile that is walked with the body on its left, as
-- seen with r to the right and z up. `curve(t)` returns r, z from the first to the second.
function revolve.sheet(curve, steps_around, steps_along)
  local function profile_normal(t)
    local h = 1e-4
    local r0, z0 = curve(math.max(t - h, 0))
    local r1, z1 = curve(math.min(t + h, 1))
    return z1 - z0, r0 - r1 -- the way turned right: outward
  end
  local positions, normals, triangles = {}, {}, {}
  for j = 0, steps_along do
    local t = j / steps_along
    local r, z = curve(t)
    local nr, nz = profile_normal(t)
    for i = 0, steps_around do
      local angle = 2 * math.pi * (i % steps_around) / steps_around
      local c, s = math.cos(angle), math.sin(angle)
      table.insert(positions, { r * c, r * s, z })
      table.insert(normals, { nr * c, nr * s, nz })
    end
  end
  for j = 0, steps_along - 1 do
    for i = 1, steps_around do
      local a = j * (steps_around + 1) + i
      local b, c, d = a + 1, a + steps_around + 2, a + steps_around + 1
      table.insert(triangles, { a, b, c })
      table.insert(triangles, { a, c, d })
    end
  end
  return lampyris.mesh.new { positions = positions, normals = normals, triangles = triangles }
end

--- A straight part of a profile.
function revolve.line(r0, z0, r1, z1)
  return function(t) return r0 + t * (r1 - r0), z0 + t * (z1 - z0) end
end

--- The TIR collimator of docs/truth.md: a paraboloid wall from r = 3.2 to 12 mm, a flat exit at its
-- rim, and a well of radius 3 and depth 5 for the LED at the origin.
function revolve.collimator(steps)
  local function wall(t)
    local r = 3.2 + t * (12 - 3.2)
    return r, (r * r - 3.2 * 3.2) / (4 * 1.6)
  end
  local exit = (12 * 12 - 3.2 * 3.2) / (4 * 1.6)
  local parts = {
    revolve.sheet(revolve.line(0, 5, 3, 5), steps, 4), -- the well's roof
    revolve.sheet(revolve.line(3, 5, 3, 0), steps, 4), -- its wall
    revolve.sheet(revolve.line(3, 0, 3.2, 0), steps, 1),
    revolve.sheet(wall, steps, math.max(steps // 4, 8)),
    revolve.sheet(revolve.line(12, exit, 0, exit), steps, 8),
  }
  return lampyris.mesh.merge(parts)
end

--- A rectangle about (x, y, z) that faces the viewer.
function revolve.plate(x, y, z, width, height)
  local a, b = width / 2, height / 2
  return lampyris.mesh.new {
    positions = { { x - a, y - b, z }, { x + a, y - b, z }, { x + a, y + b, z }, { x - a, y + b, z } },
    triangles = { { 1, 2, 3 }, { 1, 3, 4 } },
    smooth = false,
  }
end

--- An LED's spectrum: a bell of this width at half height about its peak, in nm. Made, not measured.
function revolve.led_spectrum(peak, width)
  local pairs = {}
  for lambda = 380, 780, 5 do
    pairs[#pairs + 1] = { lambda, math.exp(-4 * math.log(2) * ((lambda - peak) / width) ^ 2) }
  end
  return lampyris.spectrum.new(pairs)
end

--- Clear PMMA, with Fresnel's law.
function revolve.pmma(options)
  local given = { transmittance = 1, ior = 1.49, fresnel = true }
  for key, value in pairs(options or {}) do given[key] = value end
  return lampyris.material(given)
end

--- A sky behind a lamp, in cd/m² of daylight: 20 at dusk, 200 on a dark day.
function revolve.sky(luminance)
  local daylight = lampyris.spectrum.illuminant "D65"
  return daylight * (luminance / select(2, daylight:xyz()))
end

--- Renders the views of a lamp as an eye sees them, and prints the intensity of each, without the sky.
function revolve.render(name, scene, views)
  for _, shot in ipairs(views) do
    shot.quality.layers = "lights"
    local layered = scene:render(lampyris.view(shot.view), shot.quality)
    local image, candela = 1 * layered, 0
    for layer, of_light in pairs(layered.layers) do
      if layer ~= "surroundings" then candela = candela + of_light:intensity() end
    end
    image:save(("%s_%s.exr"):format(name, shot.name))
    image:save(("%s_%s.png"):format(name, shot.name), { look = "seen", exposure = shot.exposure })
    print(("%s %s: %.4g cd"):format(name, shot.name, candela))
  end
end

return revolve
