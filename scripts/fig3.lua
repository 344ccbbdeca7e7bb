-- Fig. 3: the exponent of a specular lobe from a measured BRDF.
--
--   lampyris run scripts/fig3.lua [-- tiny] [-- FILE.csv [COLUMN]]
--
-- FILE holds angles from the specular direction in degrees and BRDF values. Without one the script
-- fits SYNTHETIC points: cos¹⁵⁰⁰ with 5 % noise, so that the right answer is known.

local lampyris = require "lampyris"
local paper = require "paper"

local file = not paper.is_tiny and arg[1] or nil

--- cosⁿ every quarter degree, times 1 + 5 % of a normal deviate (Box and Muller).
local function synthetic()
  local state = 20061122
  local function uniform() -- Park and Miller's generator: the same points everywhere
    state = state * 48271 % 2147483647
    return state / 2147483647
  end
  local points = {}
  for k = -24, 24 do
    local angle = k / 4
    local deviate = math.sqrt(-2 * math.log(uniform())) * math.cos(2 * math.pi * uniform())
    table.insert(points, { angle, math.cos(math.rad(angle)) ^ 1500 * (1 + 0.05 * deviate) })
  end
  return points
end

local function measured()
  local points = {}
  for line in lampyris.read(file):gmatch("[^\r\n]+") do
    local cells = {}
    for cell in line:gmatch("[^,]+") do table.insert(cells, tonumber(cell)) end
    local value = cells[tonumber(arg[2]) or 2]
    if not line:find("^#") and value then table.insert(points, { cells[1], value }) end
  end
  return points
end

local points = file and measured() or synthetic()
local from, to = points[1][1], points[#points][1]
-- Noise in proportion to the value weighs every point alike in log space.
local fits = {
  { name = "one lobe", result = lampyris.fit_lobe { points = points, space = "log" } },
}
if file then
  table.insert(fits, {
    name = "two lobes", result = lampyris.fit_lobe { points = points, lobes = 2, space = "log" },
  })
end

local name = file and "measured" or "synthetic cos¹⁵⁰⁰, 5 % noise"
local series = { { name = name, points = points, style = "points" } }
local rows = {}
for _, fit in ipairs(fits) do
  local curve = {}
  for k = 0, 400 do
    local angle = from + (to - from) * k / 400
    table.insert(curve, { angle, fit.result.eval(angle) })
  end
  table.insert(series, { name = fit.name, points = curve })
  for k, lobe in ipairs(fit.result.lobes) do
    local rms = fit.result.rms_decades
    table.insert(rows, { fit.name, k, lobe.n, lobe.n_error, lobe.amplitude, rms })
  end
end

local report = paper.report("fig3", "Fig. 3: the exponent of a specular lobe")
report:figure("fig3", lampyris.figure {
  x = { label = "angle from the specular direction (°)" },
  y = { label = file and "BRDF (1/sr)" or "BRDF (relative)", log = true },
  series = series,
}, file and ("fit to " .. file) or "fit to SYNTHETIC points, not to a measurement")
report:table({ "fit", "lobe", "n", "standard error", "amplitude", "rms (decades)" }, rows)
report:compare(file and "n" or "n (synthetic points with n = 1500)", fits[1].result.n, 1500)
