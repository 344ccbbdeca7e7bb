-- Tolerances of model 1's stop lamp: its filament is moved by up to 0.3 mm along each axis and its flux is
-- up to 15 % off. How often does it fail the 19 points of UN R148 for a stop lamp (S1), and what makes it?
--
--   lampyris run scripts/study.lua [-- DRAWS [WIDTH [SAMPLES [COARSENESS]]]]      or with --shard 3/40, or "tiny"

local lampyris = require "lampyris"
local model = require "model"

local tiny = arg[1] == "tiny"
local draws = tiny and 4 or tonumber(arg[1]) or 1000
local width = tiny and 8 or tonumber(arg[2]) or 40
local samples = tiny and 100 or tonumber(arg[3]) or 4000
local coarseness = tiny and 8 or tonumber(arg[4]) or 1

local options = require "model1"
local built = model.build(options, coarseness)
local stop = built.shots[1].lit[1]
local focus = built.chambers[stop.chamber].focus
local filament = lampyris.bulb(stop.bulb, { filament = "major", samples = samples })
local nominal = filament.flux

--- Directions and limits of the regulation.
local function points_of(lamp)
  local dark = lampyris.scene { photometry = "absolute", objects = {}, lights = {} }
  return lampyris.photometry.grid { scene = dark, width = 1, height = 1 }:check(lamp).points
end
local points = points_of "S1"

--- Intensities at all points, cd, for one lumen: flux scales them all.
local function intensities(shift)
  local place = { focus[1] + shift[1], focus[2] + shift[2], focus[3] + shift[3] }
  local scene = lampyris.scene {
    photometry = "absolute",
    objects = built.objects,
    lights = { filament:transform { translate = place } },
  }
  local list = {}
  for k, point in ipairs(points) do
    local view = lampyris.view {
      azimuth = point.h, elevation = point.v,
      distance = 3000, target = { 0, 0, 60 }, fov = 6.8,
      width = width, height = math.max(1, width * 3 // 4),
    }
    local image = scene:render(view, { samples = 2, min_throughput = 0.04, wavelength_step = 20, light_error = 0.1 })
    list[k] = image:intensity() / nominal
  end
  return list
end

local study = lampyris.study {
  parameters = {
    dx = { uniform = { -0.3, 0.3 } }, dy = { uniform = { -0.3, 0.3 } }, dz = { uniform = { -0.3, 0.3 } },
    flux = { uniform = { 0.85, 1.15 } },
  },
  samples = draws,
  output = "tolerances",
  run = function(p)
    local result = { pass = true, margin = math.huge }
    for k, per_lumen in ipairs(intensities { p.dx, p.dy, p.dz }) do
      local cd, point = per_lumen * nominal * p.flux, points[k]
      result.pass = result.pass and cd >= point.min and cd <= point.max
      result.margin = math.min(result.margin, cd / point.min, point.max / cd)
      local name = ("I_%d_%d"):format(point.h, point.v):gsub("-", "m")
      result[name] = cd
    end
    return result
  end,
}

local fails, low, high = study.probability(function(row) return row.pass == 0 end)
print(("%d draws: fails with %.1f %% (%.1f to %.1f %%)"):format(study.draws, 100 * fails, 100 * low, 100 * high))
print(("intensity on the axis: %.1f ± %.1f cd"):format(study.mean.I_0_0, study.sd.I_0_0))
if study.draws >= 100 then
  local shares, explained = study.sensitivity "margin"
  for _, name in ipairs { "dx", "dy", "dz", "flux" } do
    print(("%s: %.0f %% of the margin's variance"):format(name, 100 * shares[name].total))
  end
  print(("explained: %.0f %%"):format(100 * explained))
end
