-- Model 2 (Table 5): a P21W in a faceted reflector behind a red lens with upright flutes.
--
--   lampyris run scripts/model2.lua [-- WIDTH [COARSENESS [SAMPLES]]]

local model = require "model"

local options = {
  name = "model2",
  lens = "red",
  lamp = {
    width = 400, height = 156, taper = 0.3, lift = 0.2, slant = -0.08,
    optics = { kind = "plain", facets = true, width = 18, height = 15 },
    lens = { front = 124, optics = { kind = "flutes", width = 8, depth = 0.3 } },
  },
  shots = { { name = "00", lit = { { chamber = 2, bulb = "P21W" } }, azimuth = 0, white = 6 } },
}

if not ... then model.render(options) end -- not for a script that requires this one
return options
