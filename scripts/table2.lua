-- Table 2: gain, offset and gamma of a display, from five levels a channel.
--
--   lampyris run scripts/table2.lua [-- tiny]

local lampyris = require "lampyris"
local crt = require "crt"
local paper = require "paper"

local t766 = lampyris.display.eizo_t766
local rows = {}
for k, channel in ipairs(crt.channels) do
  local fit = crt.fitted.channels[channel]
  table.insert(rows, {
    channel, fit.gain, fit.gain_error, fit.offset, fit.gamma, fit.gamma_error, fit.rms,
    t766.gain[k], t766.offset[k], t766.gamma[k],
  })
end

local report = paper.report("table2", "Table 2: gain, offset and gamma")
report:table({
  "channel", "k_g", "± (standard error)", "k_o", "γ", "±", "rms of full", "k_g, paper's T766", "k_o, T766", "γ, T766",
}, rows)
report:note("Another CRT than the paper's (Psychtoolbox, 2006), whose EIZO T766 is built in.")
