--- The measured CRT of data/displays, and what is fitted to five levels of each channel.
--
--   local crt = require "crt"
--   crt.fitted  crt.ramps.red  crt.levels.red  crt.primaries

local lampyris = require "lampyris"

local ramps = lampyris.display.ramps("../data/displays/ptb_crt_75hz_2006_xyz_rgb_ramps.csv")
local channels = { "red", "green", "blue" }

--- Five evenly spaced levels, as the paper measured: black (which the file has subtracted) and the
-- drives nearest to quarters of full.
local function five_of(ramp)
  local levels = { { 0, 0, 0, 0 } }
  for quarter = 1, 4 do
    local best = ramp[1]
    for _, row in ipairs(ramp) do
      if math.abs(row[1] - 63.75 * quarter) < math.abs(best[1] - 63.75 * quarter) then best = row end
    end
    table.insert(levels, best)
  end
  return levels
end

local crt = { channels = channels, ramps = ramps, levels = {} }
local measurement = { name = "measured CRT" }
for _, channel in ipairs(channels) do
  crt.levels[channel] = five_of(ramps[channel])
  measurement[channel] = crt.levels[channel]
end
crt.fitted = lampyris.display.fit(measurement)

return crt
