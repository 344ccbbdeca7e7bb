-- Table 3: how well the fitted model predicts 216 patches (6 × 6 × 6 digital values).
--
--   lampyris run scripts/table3.lua [-- tiny]

local crt = require "crt"
local paper = require "paper"

local found = crt.fitted:verify(crt.patches)

local report = paper.report("table3", "Table 3: errors of the display model")
report:compare("patches", #found.patches, 216)
report:compare("mean ΔE*ab", found.mean, 1.9592)
report:compare("largest ΔE*ab", found.max, 5.3923)
report:compare("mean CIEDE2000", found.mean_2000)
report:compare("largest CIEDE2000", found.max_2000)
report:note("Verdict: " .. found.verdict)
report:note("The patches are sums of measured ramps (semi-synthetic): additivity is assumed, and what"
  .. " is left is the error of the tone curves.")
report:table({ "worst patches: R, G, B", "ΔE*ab", "CIEDE2000" }, paper.map(found.worst, function(patch)
  local digits = paper.map(patch.digits, function(digit) return ("%.0f"):format(digit) end)
  return { table.concat(digits, ", "), patch.delta_e, patch.delta_e_2000 }
end))
