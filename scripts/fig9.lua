-- Fig. 9: the spectra that the lamps of Table 5 are made of.
--
--   lampyris run scripts/fig9.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"

local function material(name)
  return lampyris.spectrum.load(("../data/materials/%s.csv"):format(name))
end

local white = lampyris.bulb("P21W", { samples = 1 }).spectrum
local amber = lampyris.bulb("PY21W", { samples = 1 }).spectrum
local red_lens, amber_lens = material "pmma_red_3mm", material "pmma_light_amber_3mm"

local function line(name, spectrum, normalized)
  return { name = name, points = paper.spectrum_points(spectrum, normalized) }
end

local wavelength = { label = "wavelength (nm)", range = { 380, 780 } }
local function panel(title, label, series)
  local y = { label = label, range = { 0, 1.05 } }
  return { title = title, x = wavelength, y = y, series = series }
end

local report = paper.report("fig9", "Fig. 9: spectra of bulb, reflector and lens")
report:figure("fig9", lampyris.figure {
  width = 1350, height = 460, columns = 3,
  panels = {
    panel("bulb", "relative power", { line("P21W", white, true), line("PY21W", amber, true) }),
    panel("reflector", "reflectance", { line("aluminium", material "aluminium_mcpeak2015") }),
    panel("lens, 3 mm", "internal transmittance", {
      line("red", red_lens), line("light amber", amber_lens),
    }),
  },
}, "bulbs are normalized to their largest value")

local rows = {}
local function add(what, spectrum)
  local x, y = spectrum:xy()
  table.insert(rows, { what, x, y })
end
add("P21W", white)
add("PY21W", amber)
add("P21W through red", white * red_lens)
add("PY21W through light amber", amber * amber_lens)
report:table({ "light", "x", "y" }, rows)
report:note("UN R48 asks red for y ≤ 0.335 and y ≥ 0.980 − x, "
  .. "amber for y ≥ 0.390, y ≤ x − 0.120 and y ≥ 0.790 − 0.670x.")
