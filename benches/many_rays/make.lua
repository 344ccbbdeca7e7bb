-- Writes the many-ray benchmark: reflector.obj, and rays.csv and exact.txt for each number of rays.
--
--   lampyris run benches/many_rays/make.lua --out FOLDER [-- N …]      10⁴, 10⁵ and 10⁶ rays

local case = require "case"

local counts = #arg > 0 and arg or { 10000, 100000, 1000000 }
local mesh = case.mesh()
mesh:save("reflector.obj")
for _, count in ipairs(counts) do
  count = math.tointeger(tonumber(count))
  local rays = case.rays(count)
  rays:save(("%d/rays.csv"):format(count))
  local exact, stats = case.luminances(mesh, rays, 0)
  case.write(("%d/exact.txt"):format(count), exact)
  print(("%d rays: exact sums of %d pixels in %.2f s"):format(count, #exact, stats.seconds))
end
