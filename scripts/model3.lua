-- Model 3 (Table 5): a PY21W as turn signal, in a fluted reflector behind an amber lens with bars.
--
--   lampyris run scripts/model3.lua [-- WIDTH [COARSENESS [SAMPLES]]]

local model = require "model"

local options = {
  name = "model3",
  lens = "light_amber", -- an amber lens for white bulbs makes an amber bulb too red for UN R48
  lamp = {
    width = 408, height = 144, taper = 0.25, lift = 0.9, slant = 0.15,
    optics = { kind = "flutes", width = 11, depth = 0.6 },
    lens = { front = 128, optics = { kind = "bars", height = 9, depth = 0.45 } },
  },
  shots = { { name = "turn", lit = { { chamber = 2, bulb = "PY21W" } }, white = 25 } },
}

if not ... then model.render(options) end -- not for a script that requires this one
return options
