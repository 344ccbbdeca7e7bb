-- Lampyris as an entrant: reads FOLDER/reflector.obj and FOLDER/N/rays.csv, writes answer.txt.
--
--   lampyris run benches/many_rays/entrant.lua --read FOLDER --out OUT -- FOLDER N [LIGHT_ERROR]

local lampyris = require "lampyris"
local case = require "case"

local folder, count, light_error = arg[1], arg[2], tonumber(arg[3]) or 0.01
local mesh = lampyris.mesh.load(folder .. "/reflector.obj", { smooth = false })
local rays = lampyris.rayset.load(("%s/%s/rays.csv"):format(folder, count), { spectrum = 1 })
local answer, stats = case.luminances(mesh, rays, light_error)
case.write("answer.txt", answer)
print(("of this, sums: %.3f s; tree: %.3f s"):format(stats.seconds, stats.light_tree_seconds))
