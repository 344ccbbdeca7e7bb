-- Fig. 6: the tone curves of a display: measured levels and the fitted gain-offset-gamma model.
--
--   lampyris run scripts/fig6.lua [-- tiny]

local lampyris = require "lampyris"
local crt = require "crt"
local paper = require "paper"

local colors = { red = { 213, 40, 20 }, green = { 0, 140, 60 }, blue = { 0, 90, 190 } }

local series, rows = {}, {}
for k, channel in ipairs(crt.channels) do
  local ramp = crt.ramps[channel]
  local black, full = ramp[1][3], ramp[#ramp][3]
  local function relative(row) return { row[1], (row[3] - black) / (full - black) } end
  local gain, offset, gamma = crt.fitted.gain[k], crt.fitted.offset[k], crt.fitted.gamma[k]
  local curve, worst = {}, 0
  for digit = 0, 255, 3 do
    table.insert(curve, { digit, math.max(0, gain * digit / 255 + offset) ^ gamma })
  end
  for _, row in ipairs(ramp) do
    local model = math.max(0, gain * row[1] / 255 + offset) ^ gamma
    worst = math.max(worst, math.abs(model - relative(row)[2]))
  end
  table.insert(rows, { channel, #crt.levels[channel], #ramp, worst })
  table.insert(series, { name = channel .. ", fitted", points = curve, color = colors[channel] })
  table.insert(series, {
    points = paper.map(ramp, relative), style = "points", color = colors[channel],
  })
end

local report = paper.report("fig6", "Fig. 6: tone curves of a measured CRT")
report:figure("fig6", lampyris.figure {
  x = { label = "digital value", range = { 0, 256 } },
  y = { label = "luminance relative to full drive", range = { 0, 1.02 } },
  series = series,
}, "dots: all measured levels, black subtracted; lines: the model fitted to 5 of them")
report:table({ "channel", "levels fitted", "levels measured", "largest difference of full" }, rows)
