-- The case of the many-ray benchmark: a paraboloid mirror with a rough coat around a coil that N rays
-- stand for. README.md has its format.

local lampyris = require "lampyris"

local case = { focal = 20, width = 64, height = 48, distance = 1000, fov = 6.5 }

case.k_d, case.k_s, case.n_s, case.reflectance = 0.08, 0.92, 1500, 0.9

--- The coil's N rays: Lambert's lobe about each, 460 lm together.
function case.rays(count)
  return lampyris.filament {
    wire_radius = 0.04, coil_radius = 0.41, pitch = 0.25, turns = 22, axis = { 1, 0, 0 },
    flux = 460, spectrum = 1, samples = count,
  }
end

--- z = (x² + y²)/(4 f) − f over 110 × 80 mm, a triangle mesh of 220 × 160 squares.
function case.mesh()
  return lampyris.mesh.surface {
    nu = 220, nv = 160, smooth = false,
    point = function(u, v)
      local x, y = 110 * (u - 0.5), 80 * (v - 0.5)
      return x, y, (x * x + y * y) / (4 * case.focal) - case.focal
    end,
  }
end

function case.view()
  return lampyris.view {
    distance = case.distance, fov = case.fov, width = case.width, height = case.height,
  }
end

function case.scene(mesh, rays)
  return lampyris.scene {
    objects = { { mesh = mesh, material = lampyris.material {
      reflectance = case.reflectance, k_rg = 0, k_tg = 0,
      k_d = case.k_d, n_d = 1, k_s = case.k_s, n_s = case.n_s,
    } } },
    lights = { rays }, photometry = "absolute", shadows = false,
  }
end

--- Luminance of each pixel, cd/m²: one ray through each center.
function case.luminances(mesh, rays, light_error)
  local image = case.scene(mesh, rays):render(case.view(), {
    samples = 1, light_error = light_error, max_depth = 0,
  })
  return image:luminances(), image.stats
end

--- One number a line.
function case.write(path, values)
  local lines = {}
  for k, value in ipairs(values) do lines[k] = ("%.9g"):format(value) end
  lampyris.write(path, table.concat(lines, "\n") .. "\n")
end

return case
