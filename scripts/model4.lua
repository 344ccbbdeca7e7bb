-- Model 4 (Table 5): a PY21/5W in a free-form reflector behind a red lens with fine pillows:
-- the minor filament as tail lamp, the major one as turn signal.
--
--   lampyris run scripts/model4.lua [-- WIDTH [COARSENESS [SAMPLES]]]

local model = require "model"

local options = {
  name = "model4",
  lens = "red",
  lamp = {
    width = 424, height = 148, taper = 0.1, lift = 0.5, slant = 0,
    optics = { kind = "pillows", width = 28, height = 46, depth = 1.6, depth_up = 1.0 },
    lens = { optics = { kind = "pillows", width = 9, height = 9, depth = 0.15 } },
    chambers = {
      { from = 0, to = 0.3, focal = 25, back = -12, shape = "free" },
      { from = 0.3, to = 0.68, focal = 30, back = 0, shape = "free", spread = { 0.04, 0.02 } },
      { from = 0.68, to = 1, focal = 25, back = -12, shape = "free" },
    },
  },
  shots = {
    {
      name = "tail",
      lit = { { chamber = 2, bulb = "PY21/5W", filament = "minor" } },
      white = 0.4,
    },
    { name = "turn", lit = { { chamber = 2, bulb = "PY21/5W" } }, white = 3.5 },
  },
}

if not ... then model.render(options) end -- not for a script that requires this one
return options
