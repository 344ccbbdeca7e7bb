-- Random calls of the whole interface: values of every type in the place of every argument and option.
local L = require "lampyris"
local state = tonumber(arg[1])
local function random(count)
  state = (state * 1103515245 + 12345) % 2147483648
  return state // 65536 % count + 1
end
local functions = {}
for _, name in ipairs { "bulb", "camera", "cylinder", "figure", "filament", "fit_lobe", "material",
  "read", "scene", "study", "sweep", "view", "write" } do
  functions[#functions + 1] = L[name]
end
for _, module in ipairs { L.spectrum, L.mesh, L.rayset, L.image, L.display, L.photometry } do
  for _, name in ipairs { "load", "new", "constant", "blackbody", "illuminant", "surface", "merge", "sum",
    "fit", "ramps", "p3_pq", "grid" } do
    local found, f = pcall(function() return module[name] end)
    if found then functions[#functions + 1] = f end
  end
end
local keys, methods = {}, {}
for key in arg[2]:gmatch "[%w_]+" do keys[#keys + 1] = key end
for _, name in ipairs { "at", "values", "xyz", "xy", "transform", "save", "section", "flat", "halves", "noise",
  "rays", "starting_at", "render", "paths", "check_light_error", "luminance", "compare", "false_color",
  "intensity", "verify", "digital", "check", "svg", "spectrum", "stats", "bounds" } do
  methods[#methods + 1] = name
end
local handles = {
  L.spectrum.constant(1), L.material {}, L.scene { objects = {} }, L.view { width = 2, height = 2 },
  L.mesh.new { positions = { {0,0,0}, {1,0,0}, {0,1,0} }, triangles = { {1,2,3} } },
  L.cylinder { radius = 1, length = 1, flux = 1, samples = 4, spectrum = L.spectrum.constant(1) },
  L.display.srgb, L.figure { series = {} },
}
handles[#handles + 1] = handles[3]:render(handles[4])
local plain = { 0, 1, 2, 3.5, -1, 0.5, 1e300, 1 / 0, 0 / 0, math.mininteger, "", "x", "a.png", "a.exr", "a.csv",
  "P21W", "R1", "auto", "\0\255", true, false, {}, { 1, 2, 3 }, { {} }, print, coroutine.create(print),
  function() end, function() error "no" end, function(...) return ... end,
  coroutine.wrap(function() while true do coroutine.yield(1) end end) }
local function value(depth)
  local kind = random(10)
  if kind <= 4 then return plain[random(#plain)] end
  if kind <= 7 then return handles[random(#handles)] end
  local t = {}
  if depth < 3 then
    for _ = 1, random(4) do
      if random(3) == 1 then t[#t + 1] = value(depth + 1) else t[keys[random(#keys)]] = value(depth + 1) end
    end
  end
  return t
end
print = function() end
for _ = 1, tonumber(arg[3]) do
  local ok, made
  if random(2) == 1 then
    ok, made = pcall(functions[random(#functions)], value(0), value(0))
  else
    local handle, method = handles[random(#handles)], methods[random(#methods)]
    local argument = value(0)
    ok, made = pcall(function() return handle[method](handle, argument) end)
  end
  if ok and type(made) == "userdata" then handles[#handles < 40 and #handles + 1 or 9 + random(30)] = made end
end
