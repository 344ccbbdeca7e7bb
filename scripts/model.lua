--- Renders a lamp of Table 5: what the model scripts share.
--
--   model.render { name = "model1", lamp = { … }, lens = "red",
--                  shots = { { name = "00", lit = { … }, azimuth = 0 }, … } }
--
-- A shot's `lit` lists the burning bulbs: { chamber = 2, bulb = "P21/5W", filament = "major" }.
-- Each shot is saved as EXR and as PNG for the paper's display and for sRGB. `white` is the
-- luminance (of the scene's relative unit) that display white stands for; a pure red or amber at
-- full drive has a fifth to a half of white's luminance, so it lies well above the lens's.
-- The script's arguments: picture width, mesh coarseness, light samples a bulb.

local lampyris = require "lampyris"
local lamp = require "lamp"

local model = {}

local width = tonumber(arg[1]) or 640
local coarseness = tonumber(arg[2]) or 1
local light_samples = tonumber(arg[3]) or 1000000

local displays = { t766 = lampyris.display.eizo_t766, srgb = lampyris.display.srgb }

local function lights(built, lit)
  local list = {}
  for k, it in ipairs(lit) do
    list[k] = lampyris.bulb(it.bulb, {
      filament = it.filament,
      center = built.chambers[it.chamber].focus,
      samples = light_samples,
    })
  end
  return list
end

local function render(scene, shot)
  local view = lampyris.view {
    azimuth = shot.azimuth or 0,
    distance = 3000,
    target = { 0, 0, 60 },
    fov = 6.8,
    width = width,
    height = math.max(1, width * 3 // 4),
  }
  return scene:render(view, { samples = 4 })
end

--- PNGs for both displays; `white` is the luminance that display white stands for.
local function save_pngs(image, name, white)
  for display_name, display in pairs(displays) do
    local _, display_white = display:xyz(255, 255, 255)
    local path = ("%s_%s.png"):format(name, display_name)
    image:save(path, { display = display, exposure = white and display_white / white })
  end
end

--- Builds, lights, renders and saves; returns the images by shot name.
function model.render(options)
  local sizes = { coarseness = coarseness }
  for key, value in pairs(options.lamp or {}) do
    sizes[key] = value
  end
  local built = lamp.build(sizes)
  print(("%s: %d triangles"):format(options.name, built.triangle_count))
  local objects = lamp.objects(built, options.lens)
  local images = {}
  local scenes = {} -- one for all shots of the same burning bulbs
  for _, shot in ipairs(options.shots) do
    local name = options.name .. "_" .. shot.name
    scenes[shot.lit] = scenes[shot.lit]
      or lampyris.scene { objects = objects, lights = lights(built, shot.lit) }
    local image = render(scenes[shot.lit], shot)
    print(("%s: %.1f s"):format(name, image.stats.seconds))
    image:save(name .. ".exr")
    save_pngs(image, name, shot.white)
    images[shot.name] = image
  end
  return images
end

return model
