--- Meshes over surfaces that are given as functions, with creases between their cells.
--
--   local pillows = sheet.new(point, 1.2, { columns = 9, rows = 4 })  -- edges near 1.2 mm
--   local mesh = sheet.mesh(pillows)
--
-- `point(u, v)` returns x, y, z in mm for u and v from 0 to 1; the front is the side from which u
-- runs right and v up. The surface is smooth within a cell (a pillow, a facet) and may break where
-- two meet: each cell has vertices of its own, so no normal is a mean over a crease.
-- A sheet is { point =, nu =, nv =, columns =, rows =, keep = }: nu × nv steps, and a function of
-- x, y, z that is false where the surface has a hole.

local lampyris = require "lampyris"

local sheet = {}

--- Mean length of the lines along which u (or v) runs.
local function mean_length(point, along_v)
  local lines, steps, sum = 9, 48, 0
  for line = 0, lines - 1 do
    local across = (line + 0.5) / lines
    local px, py, pz
    for step = 0, steps do
      local u, v = step / steps, across
      if along_v then u, v = v, u end
      local x, y, z = point(u, v)
      if px then
        sum = sum + math.sqrt((x - px) ^ 2 + (y - py) ^ 2 + (z - pz) ^ 2)
      end
      px, py, pz = x, y, z
    end
  end
  return sum / lines
end

--- A sheet whose edges are near `edge`, with whole numbers of them in each cell.
-- The mean edge of two right triangles is 1.14 times the side of their square.
function sheet.new(point, edge, cells, keep)
  local columns, rows = cells and cells.columns or 1, cells and cells.rows or 1
  local function count(length, of_cells)
    local least = of_cells > 1 and 2 or 1 -- a bulge has a middle
    return of_cells * math.max(least, math.floor(length / of_cells / (edge / 1.14) + 0.5))
  end
  return {
    point = point, columns = columns, rows = rows, keep = keep,
    nu = count(lampyris.keep(mean_length, point, false), columns),
    nv = count(lampyris.keep(mean_length, point, true), rows),
  }
end

--- The same places, facing the other way: v runs right and u up.
function sheet.turned(of)
  return {
    point = function(u, v) return of.point(v, u) end, keep = of.keep,
    nu = of.nv, nv = of.nu, columns = of.rows, rows = of.columns,
  }
end

--- x, y, z at each place of the grid, row by row, and whether it is kept.
local function evaluated(of)
  local places = { x = {}, y = {}, z = {}, kept = {}, stride = of.nu + 1 }
  local k = 0
  for j = 0, of.nv do
    for i = 0, of.nu do
      k = k + 1
      local x, y, z = of.point(i / of.nu, j / of.nv)
      places.x[k], places.y[k], places.z[k] = x, y, z
      places.kept[k] = not of.keep or of.keep(x, y, z)
    end
  end
  return places
end

--- Derivative by the step at place `k`, which is number `at` of 0 to `count` in its cell: exact for
-- parabolas, at the cell's border too.
local function derivative(list, k, stride, at, count)
  if count == 1 then
    return list[k + (1 - at) * stride] - list[k - at * stride]
  elseif at == 0 then
    return -1.5 * list[k] + 2 * list[k + stride] - 0.5 * list[k + 2 * stride]
  elseif at == count then
    return 1.5 * list[k] - 2 * list[k - stride] + 0.5 * list[k - 2 * stride]
  end
  return 0.5 * (list[k + stride] - list[k - stride])
end

--- The normal at place `k`, number (i, j) of its cell of m × n steps; mesh.new normalizes it.
local function normal(places, k, i, j, m, n)
  local stride = places.stride
  local ux, vx = derivative(places.x, k, 1, i, m), derivative(places.x, k, stride, j, n)
  local uy, vy = derivative(places.y, k, 1, i, m), derivative(places.y, k, stride, j, n)
  local uz, vz = derivative(places.z, k, 1, i, m), derivative(places.z, k, stride, j, n)
  return { uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx }
end

--- Adds a cell of m × n steps, whose first place is `first`, to the lists of `out`.
local function add_cell(out, places, first, m, n)
  local index = {}
  local function vertex(i, j)
    local k = first + j * places.stride + i
    if not index[k] then
      table.insert(out.positions, { places.x[k], places.y[k], places.z[k] })
      table.insert(out.normals, normal(places, k, i, j, m, n))
      index[k] = #out.positions
    end
    return index[k]
  end
  local function is_kept(i, j) return places.kept[first + j * places.stride + i] end
  for j = 0, n - 1 do
    for i = 0, m - 1 do
      if is_kept(i, j) and is_kept(i + 1, j) and is_kept(i, j + 1) and is_kept(i + 1, j + 1) then
        local a, c = vertex(i, j), vertex(i + 1, j + 1)
        table.insert(out.triangles, { a, vertex(i + 1, j), c })
        table.insert(out.triangles, { a, c, vertex(i, j + 1) })
      end
    end
  end
end

local function mesh(of)
  local places = evaluated(of)
  local m, n = of.nu // of.columns, of.nv // of.rows
  local out = { positions = {}, normals = {}, triangles = {} }
  for row = 0, of.rows - 1 do
    for column = 0, of.columns - 1 do
      add_cell(out, places, 1 + row * n * places.stride + column * m, m, n)
    end
  end
  return lampyris.mesh.new(out)
end

function sheet.mesh(of)
  return lampyris.keep(mesh, of)
end

--- One mesh of several sheets.
function sheet.merged_mesh(sheets)
  local meshes = {}
  for k, of in ipairs(sheets) do meshes[k] = sheet.mesh(of) end
  return lampyris.mesh.merge(meshes)
end

--- A rectangle from a corner along two edges; its front is the side of a × b.
function sheet.panel(corner, a, b)
  local function at(i, j)
    return { corner[1] + i * a[1] + j * b[1], corner[2] + i * a[2] + j * b[2],
      corner[3] + i * a[3] + j * b[3] }
  end
  return lampyris.mesh.new {
    positions = { at(0, 0), at(1, 0), at(1, 1), at(0, 1) },
    triangles = { { 1, 2, 3 }, { 1, 3, 4 } }, smooth = false,
  }
end

return sheet
