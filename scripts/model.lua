--- The lamps of Table 5, lit: what the model scripts and the figures share.
--
--   local model = require "model"
--   local built = model.build(require "model1", 2)      -- edges twice as long
--   local shot = built.shots[1]
--   local scene = model.scene(built, shot, 100000)      -- light samples a bulb
--   local image = scene:render(model.view(shot, 640))
--
-- A model script returns { name = "model1", lamp = { … }, lens = "red", shots = { { name = "00",
-- lit = { … }, azimuth = 0, white = 7 }, … } }, and renders it if it is the script that was run.
-- `lamp` holds the sizes that differ from lamp.lua's. A shot's
-- `lit` lists the burning bulbs: { chamber = 2, bulb = "P21/5W", filament = "major" }. `white` is
-- the luminance (of the scene's relative unit) that display white stands for; a pure red or amber
-- at full drive has a fifth to a half of white's luminance, so it lies well above the lens's.

local lampyris = require "lampyris"
local lamp = require "lamp"

local model = {}

--- lamp.build for a model, with edges `coarseness` times as long and `more` sizes, its `objects` for
-- lampyris.scene, and its name and shots.
function model.build(options, coarseness, more)
  local sizes = { coarseness = coarseness }
  for key, value in pairs(options.lamp or {}) do sizes[key] = value end
  for key, value in pairs(more or {}) do sizes[key] = value end
  local built = lamp.build(sizes)
  built.name, built.shots = options.name, options.shots
  built.objects = lamp.objects(built, options.lens)
  return built
end

--- The burning bulbs of a shot, with this many samples each; drawn once for all scenes that ask.
function model.lights(built, shot, samples)
  built.lights = built.lights or {}
  local kept = built.lights[shot.lit]
  if kept and kept.samples == samples then return kept.list end
  local list = {}
  for k, it in ipairs(shot.lit) do
    list[k] = lampyris.bulb(it.bulb, {
      filament = it.filament,
      center = built.chambers[it.chamber].focus,
      samples = samples,
    })
  end
  built.lights[shot.lit] = { samples = samples, list = list }
  return list
end

function model.scene(built, shot, samples)
  return lampyris.scene { objects = built.objects, lights = model.lights(built, shot, samples) }
end

--- The view of a shot, this many pixels wide.
function model.view(shot, width)
  return lampyris.view {
    azimuth = shot.azimuth or 0,
    distance = 3000, target = { 0, 0, 60 }, fov = 6.8,
    width = width, height = math.max(1, width * 3 // 4),
  }
end

local displays = { t766 = lampyris.display.eizo_t766, srgb = lampyris.display.srgb }

--- PNGs for both displays; `white` is the luminance that display white stands for.
local function save_pngs(image, name, white)
  for display_name, display in pairs(displays) do
    local _, display_white = display:xyz(255, 255, 255)
    local path = ("%s_%s.png"):format(name, display_name)
    image:save(path, { display = display, exposure = white and display_white / white })
  end
end

--- The lamp at dusk, in cd/m²: with shadows, before a background that is not black.
function model.dusk(built, shot, samples)
  return lampyris.scene {
    objects = built.objects, lights = model.lights(built, shot, samples),
    photometry = "absolute", shadows = true,
    background = lampyris.spectrum.illuminant "D65" * model.dusk_background,
  }
end

--- Of the sky at dusk: 20 cd/m².
model.dusk_background = 20 / select(2, lampyris.spectrum.illuminant "D65":xyz())

--- The view of a shot, near enough that the lamp fills it.
function model.close_view(shot, width)
  return lampyris.view {
    azimuth = shot.azimuth or 0,
    distance = 3000, target = { 0, 5, 60 }, fov = 4.2,
    width = width, height = math.max(1, width * 9 // 20),
  }
end

--- Renders each shot: as the paper has it (EXR, and PNG for the paper's display and for sRGB), and
-- at dusk, as an eye and as a camera see it.
-- The script's arguments: picture width, mesh coarseness, light samples a bulb.
function model.render(options)
  local width, coarseness = tonumber(arg[1]) or 640, tonumber(arg[2]) or 1
  local samples = tonumber(arg[3]) or 1000000
  local built = model.build(options, coarseness)
  print(("%s: %d triangles"):format(built.name, built.triangle_count))
  local scenes = {} -- one for all shots of the same burning bulbs
  for _, shot in ipairs(built.shots) do
    scenes[shot.lit] = scenes[shot.lit] or {
      dusk = model.dusk(built, shot, samples),
      paper = model.scene(built, shot, samples),
    }
    local name = built.name .. "_" .. shot.name
    -- Shadows cost most of the time, and glare smooths what two samples leave.
    local dusk = scenes[shot.lit].dusk:render(model.close_view(shot, width), { samples = 2 })
    dusk:save(name .. "_seen.png", { look = "seen" })
    dusk:save(name .. "_camera.png", { look = "camera" })
    print(("%s_seen.png: %.1f s"):format(name, dusk.stats.seconds))
    local image = scenes[shot.lit].paper:render(model.view(shot, width), { samples = 4 })
    print(("%s: %.1f s"):format(name, image.stats.seconds))
    image:save(name .. ".exr")
    save_pngs(image, name, shot.white)
  end
end

return model
