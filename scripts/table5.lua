-- Table 5: the four lamps.
--
--   lampyris run scripts/table5.lua [-- tiny]

local model = require "model"
local paper = require "paper"

local coarseness = paper.size(1, 6)
local lenses = { red = "red PMMA", light_amber = "amber PMMA" }
local printed = { model1 = "P21W/5W", model2 = "P21W", model3 = "PY21W", model4 = "PY21W/5W" }

local rows = {}
for k = 1, 4 do
  local options = require("model" .. k)
  local built = model.build(options, coarseness)
  local shots = paper.map(options.shots, function(shot) return shot.name end)
  local lit = model.lights(built, options.shots[1], 1)[1]
  table.insert(rows, {
    k, options.shots[1].lit[1].bulb, printed[options.name], "aluminium", lenses[options.lens],
    built.triangle_count, lit.flux, table.concat(shots, ", "),
  })
end

local report = paper.report("table5", "Table 5: the lamps")
report:table(
  { "model", "bulb", "in the paper", "reflector", "lens", "triangles", "lm, first view", "views" },
  rows
)
report:note("The paper gives 300 to 400 thousand triangles a lamp; its P21W/5W is R37's P21/5W.")
