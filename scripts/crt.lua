--- The measured CRT of data/displays, and what is fitted to five levels of each channel.
--
--   local crt = require "crt"
--   crt.fitted  crt.ramps.red  crt.levels.red  crt.patches
--
-- Rows are { digit, X, Y, Z } in cd/m². The files have the display's black subtracted; here it is
-- added again, as an instrument measures it.

local lampyris = require "lampyris"

local folder = "../data/displays/ptb_crt_75hz_2006_"
local channels = { "red", "green", "blue" }

-- Per 4 nm in the file, per nm here.
local black = { (lampyris.spectrum.load(folder .. "ambient_spectrum.csv") * 0.25):xyz() }

local function with_black(row)
  return { row[1], row[2] + black[1], row[3] + black[2], row[4] + black[3] }
end

local crt = { channels = channels, black = black, ramps = {}, levels = {}, patches = {} }

local measurement = { name = "measured CRT", black = black }
local ramps = lampyris.display.ramps(folder .. "xyz_rgb_ramps.csv")
for _, channel in ipairs(channels) do
  local ramp = { with_black { 0, 0, 0, 0 } }
  for _, row in ipairs(ramps[channel]) do table.insert(ramp, with_black(row)) end
  crt.ramps[channel] = ramp
  -- Five evenly spaced levels, as the paper measured; of 30 those nearest to quarters.
  crt.levels[channel] = { ramp[1], ramp[8], ramp[16], ramp[24], ramp[31] }
  measurement[channel] = crt.levels[channel]
end
crt.fitted = lampyris.display.fit(measurement)

for line in lampyris.read(folder .. "SEMISYNTHETIC_216_patches.csv"):gmatch("[^\r\n]+") do
  local cells = {}
  for cell in line:gmatch("[^,]+") do table.insert(cells, tonumber(cell)) end
  if #cells == 6 then
    for k = 1, 3 do
      cells[k] = 255 * cells[k]
      cells[3 + k] = cells[3 + k] + black[k]
    end
    table.insert(crt.patches, cells)
  end
end

return crt
