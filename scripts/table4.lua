-- Table 4: the parameters of reflector and lens that the shipped lamps are rendered with.
--
--   lampyris run scripts/table4.lua [-- tiny]

local lamp = require "lamp"
local paper = require "paper"

local materials = lamp.materials()
local printed = {
  k_tg = { 0.05, 0.95 }, k_rg = { 0.95, 0.05 },
  n_d = { 10, 50 }, n_s = { 1500, 1500 },
  k_d = { 0.08, 0.08 }, k_s = { 0.92, 0.92 },
}

local rows, different = {}, 0
for _, key in ipairs { "k_tg", "k_rg", "n_d", "n_s", "k_d", "k_s" } do
  local reflector, lens = materials.aluminium[key], materials.red[key]
  table.insert(rows, { key, reflector, printed[key][1], lens, printed[key][2] })
  if reflector ~= printed[key][1] or lens ~= printed[key][2] then different = different + 1 end
end

local report = paper.report("table4", "Table 4: parameters of reflector and lens")
report:table({ "", "reflector", "paper", "lens", "paper" }, rows)
report:compare("parameters that differ", different, 0)
