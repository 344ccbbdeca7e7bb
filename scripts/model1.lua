-- Model 1 (Table 5): a P21/5W in the tail and stop chamber of a red lamp with pillow optics,
-- from the front and 15° outward.
--
--   lampyris run scripts/model1.lua [-- WIDTH [COARSENESS [SAMPLES]]]

local model = require "model"

local stop = { { chamber = 2, bulb = "P21/5W" } }

local options = {
  name = "model1",
  lens = "red",
  shots = {
    { name = "00", lit = stop, azimuth = 0, white = 7 },
    { name = "15", lit = stop, azimuth = 15, white = 7 },
  },
}

if not ... then model.render(options) end -- not for a script that requires this one
return options
