---@meta lampyris
--
-- The interface of Lampyris for the Lua language server: put this folder into
-- "workspace.library", and editors know names, units and ranges.
--
-- Lengths in mm, angles in degrees, wavelengths in nm, flux in lm. Vectors are {x, y, z}.

---@alias vector number[]  {x, y, z}

---@class lampyris
---@field version string  of the program
local lampyris = {}

-- Spectra ---------------------------------------------------------------------------------------

---@class lampyris.spectrum
lampyris.spectrum = {}

---Values over wavelength: linear between its rows. Outside of them a material's are constant, and a
---light's are 0.
---@class Spectrum
---@field range? number[]  {first, last} of the table, nm; nil of a constant
---@operator mul(Spectrum|number): Spectrum
---@operator add(Spectrum|number): Spectrum
local Spectrum = {}

---@class SpectrumLoadOptions
---@field column? integer  of the values, 1-based; 2 to 1000; default the one after the wavelengths
---@field row? integer|string  where each sample is a row: which, by number or name; default the only one
---@field clamp? boolean  values outside of 0 to 1 become 0 and 1; default false

---Reads a table, whatever its separators, decimal marks and encoding, and instruments' files: CGATS,
---JCAMP-DX, IES TM-27. `lampyris info` says what a file is taken for.
---@param path string
---@param options? SpectrumLoadOptions
---@return Spectrum
function lampyris.spectrum.load(path, options) end

---@param rows number[][]  {{nm, value}, …}, wavelengths ascending
---@return Spectrum
function lampyris.spectrum.new(rows) end

---@param value number
---@return Spectrum
function lampyris.spectrum.constant(value) end

---Planck's law, 1 at 560 nm.
---@param temperature number  K, 100 to 1e9
---@return Spectrum
function lampyris.spectrum.blackbody(temperature) end

---@param name "A"|"D65"|"E"
---@return Spectrum
function lampyris.spectrum.illuminant(name) end

---@param wavelength number  nm, above 0
---@return number
function Spectrum:at(wavelength) end

---No value outside of low to high.
---@param low number
---@param high number
---@return Spectrum
function Spectrum:clamped(low, high) end

---Values from 380 to 780 nm, of a material.
---@param step? 5|10|20  nm; default 5
---@return number[]
function Spectrum:values(step) end

---Tristimulus values (eq. 4).
---@return number X, number Y, number Z
function Spectrum:xyz() end

---Chromaticity.
---@return number x, number y
function Spectrum:xy() end

---683 Σ s(λ) V(λ) Δλ, lm for a spectrum in W/nm.
---@return number
function Spectrum:luminous_flux() end

-- Meshes ----------------------------------------------------------------------------------------

---@class lampyris.mesh
lampyris.mesh = {}

---@class Mesh
---@field triangle_count integer
---@field bounds vector[]  lowest and highest corner, mm
---@field area number  mm²
---@field volume number  mm³, of a closed mesh; negative if its fronts are inside
---@field open_edges integer  0: the mesh is closed
---@field groups string[]  names of the file's groups that have faces
---@field objects string[]  names of its objects that have faces
---@field materials string[]  names of its materials that have faces
local Mesh = {}

---@class MeshLoadOptions
---@field smooth? boolean  interpolated normals (eq. 3); default true
---@field scale? number  above 0; default 1
---@field unit? "mm"|"cm"|"m"|"um"|"inch"|"in"|"ft"  of the file's lengths; default "mm"
---@field group? string  only this group of the file; default all
---@field object? string  only this object (OBJ's `o`, a glTF node, an STL solid); default all
---@field material? string  only what has this material (OBJ's `usemtl`); default all
---@field weld? number  vertices this near are one, before normals are made; 0: those exactly equal; 0 or more mm; default 0
---@field crease? number  where the file has no normals and no smoothing groups, sharper edges stay sharp; 0 to 180 degrees; default 40

---Reads a mesh: OBJ, STL, PLY, glTF or GLB, told apart by content.
---@param path string
---@param options? MeshLoadOptions
---@return Mesh
function lampyris.mesh.load(path, options) end

---@class MeshNewOptions
---@field positions vector[]  mm
---@field triangles number[][]  {{i, j, k}, …}, 1-based, counter-clockwise from the front
---@field normals? vector[]  one for each position; default means of the adjoining faces' normals
---@field smooth? boolean  default true

---@param options MeshNewOptions
---@return Mesh
function lampyris.mesh.new(options) end

---@class MeshSurfaceOptions
---@field point fun(u: number, v: number): number, number, number  u, v from 0 to 1; x, y, z in mm
---@field keep? fun(x: number, y: number, z: number): boolean  default everything
---@field nu? integer  along u; 1 to 100000 cells; default 100
---@field nv? integer  along v; 1 to 100000 cells; default 100
---@field smooth? boolean  default true

---A grid of points; its front is the side of ∂/∂u × ∂/∂v.
---@param options MeshSurfaceOptions
---@return Mesh
function lampyris.mesh.surface(options) end

---One mesh of several.
---@param meshes Mesh[]
---@return Mesh
function lampyris.mesh.merge(meshes) end

---@class Rotation
---@field axis? vector  default {0, 1, 0}
---@field angle number  degrees, right-handed

---Scaled, then turned, then moved.
---@class Transform
---@field mirror? "x"|"y"|"z"  this coordinate changes its sign; fronts stay fronts; default none
---@field translate? vector  mm; default {0, 0, 0}
---@field rotate? Rotation
---@field scale? number  above 0; default 1

---@param transform Transform
---@return Mesh
function Mesh:transform(transform) end

---Writes an OBJ file below the output folder.
---@param path string
function Mesh:save(path) end

---The same mesh without interpolated normals.
---@return Mesh
function Mesh:flat() end

---@class SectionOptions
---@field through? vector  mm; default {0, 0, 0}
---@field normal? vector  default {1, 0, 0}

---Where a plane cuts the mesh.
---@param plane SectionOptions
---@return vector[][]  {{from, to}, …}, mm
function Mesh:section(plane) end

-- Materials -------------------------------------------------------------------------------------

---@class MaterialOptions
---@field name? string  for messages
---@field reflectance? Spectrum|number  F_r; 0 to 1; default 0, or 1 with `fresnel`
---@field transmittance? Spectrum|number  F_t; 0 to 1; default none: opaque
---@field thickness? number  F_t is the internal transmittance of this thickness; above 0 mm; default none: F_t at every interface crossed
---@field ior? Spectrum|number  index of refraction; 1 to 4; default none: rays go straight through
---@field fresnel? boolean  whether Fresnel's law shares out what is mirrored and what goes on; default false
---@field n? Spectrum|number  of a metal, with `k`; 0 to 100; default none
---@field k? Spectrum|number  of a metal, with `n`; 0 to 100; default none
---@field priority? integer  where bodies overlap, the higher one is there; -1000 to 1000; default 0
---@field k_d? number  proportion of the diffuse lobe; 0 to 1; default 0
---@field n_d? number  its exponent; 1 is Lambert's; 1 to 1000000; default 1
---@field k_s? number|number[]  proportion of the specular lobe, or of several; 0 to 1; default 0
---@field n_s? number|number[]  its exponent; 1 to 1000000; default 1
---@field lobe? "mirror"|"half"  of the specular lobes: about the mirror direction, or by the half vector as of a rough surface; default "mirror"
---@field k_rg? number  proportion of the mirrored ray; 0 to 1; default 0, or 1 with `fresnel`
---@field k_tg? number  proportion of the transmitted ray; 0 to 1; default 0, or 1 with `fresnel`
---@field k_a? number  proportion of the ambient light; 0 to 1; default 0

---@class Material

---@param options MaterialOptions
---@return Material
function lampyris.material(options) end

---@class OpticalConstants
---@field n Spectrum
---@field k Spectrum

---@class lampyris.optical
---@field aluminium OpticalConstants  evaporated, as in lamp reflectors
---@field pmma OpticalConstants  clear; `n` is a body's `ior`
lampyris.optical = {}

---@class LobeFitOptions
---@field points? number[][]  {{angle, value}, …}, degrees from the lobe's direction
---@field file? string  instead of points: a CSV file of angle and value
---@field column? integer  of the values in the file; 2 to 1000; default 2
---@field incidence? number  of a file of scatter: the measured one nearest to this; 0 to 90 degrees; default the first
---@field peak? number|"auto"  where the lobe is, for angles from elsewhere; "auto" finds it; -180 to 180 degrees; default 0
---@field range? number[]  {from, to}; 0 to 90 degrees; default {0, 90}
---@field weights? number[]  one for each point; 0 or more; default 1
---@field lobes? integer  1 to 2; default 1
---@field space? "linear"|"log"  what least squares are taken of; default "linear"

---@class FittedLobe
---@field n number  the exponent
---@field n_error number  standard error
---@field amplitude number
---@field amplitude_error number  standard error

---@class LobeFit
---@field lobes FittedLobe[]
---@field rms number  of the deviations
---@field rms_decades number  of those of log₁₀
---@field points integer  in the range

---The first lobe's figures, and those of the sum.
---@class LobeFitResult: FittedLobe, LobeFit
---@field eval fun(angle: number): number
---@field plot Figure measured points and fit

---Fits A cosⁿ to measured pairs (Fig. 3).
---@param options LobeFitOptions
---@return LobeFitResult
function lampyris.fit_lobe(options) end

-- Lights ----------------------------------------------------------------------------------------

---@class lampyris.rayset
lampyris.rayset = {}

---What start points lie on, in the set's own coordinates.
---@class FittedSurface
---@field kind "point"|"sphere"|"cylinder"|"plane"
---@field center vector  mm
---@field axis? vector  of a cylinder
---@field normal? vector  of a plane
---@field radius? number  mm; of a plane: that all starts are within
---@field length? number  mm, of a cylinder
---@field rms number  distance of the starts that it explains, mm
---@field share number  of the starts that it explains, 0 to 1
---@field is_source boolean  false where the rays come from inside of it

---@class Rayset
---@field directions number  exponent of the samples' lobes; 1 is Lambert's
---@field count integer
---@field flux number  lm
---@field spectrum Spectrum
---@field start_surface? FittedSurface  what the starts lie on, if a point, plane, sphere or cylinder
local Rayset = {}

---@class FittedSurface  in the set's own coordinates
---@field kind "point"|"sphere"|"cylinder"|"plane"
---@field center vector  mm
---@field radius number?  mm; of a plane: of the starts about the center
---@field length number?  mm, of a cylinder
---@field axis vector?  of a cylinder
---@field normal vector?  of a plane
---@field rms number  mm, of the starts that it explains
---@field share number  of the starts that it explains, 0 to 1
---@field is_source boolean  false where the rays come from a much thinner place inside

---@class Ray
---@field position vector  mm
---@field direction vector
---@field flux number  lm

---Every ray, where it is in the scene.
---@return Ray[]
function Rayset:rays() end

---The rays moved along themselves to where they come nearest to an axis or a point.
---@param surface StartOptions
---@return Rayset
function Rayset:starting_at(surface) end

---@class StartOptions
---@field axis? vector  of a line
---@field through? vector  a point of the line; mm; default {0, 0, 0}
---@field point? vector  instead of a line; mm
---@field radius? number  0 or more mm; default 0

---@class RaysetLoadOptions
---@field spectrum? Spectrum|number  default the file's
---@field flux? number  above 0 lm; default the header's, else the sum of the rays
---@field radius? number  of the disc on which the rays of a photometric file start; 0 or more mm; default 0: a point
---@field samples? integer  keep this many rays, drawn evenly; of a photometric file, make as many; 1 to 100000000; default all
---@field seed? integer  of the draw; 0 to 9007199254740992; default 1
---@field start? StartOptions  moves the rays' starts along the rays; default as they are
---@field directions? "lambert"|"measured"|number  how narrow the rays' own lobes are; 1 is Lambert's; 1 to 30000; default "lambert"
---@field emitter? "fit"|EmitterShape  the surface that the rays come from; default none
---@field transform? Transform

---Reads a ray file: TM-25, Zemax, LightTools, ASAP, CSV, told apart by content.
---@param path string
---@param options? RaysetLoadOptions
---@return Rayset
function lampyris.rayset.load(path, options) end

---@class RaysetNewOptions
---@field positions vector[]  mm
---@field directions vector[]
---@field flux number|number[]  in all, or one for each ray; above 0 lm
---@field spectrum Spectrum|number
---@field exponent? number  how narrow the rays' own lobes are; 1 is Lambert's; 1 to 30000; default 1

---@param options RaysetNewOptions
---@return Rayset
function lampyris.rayset.new(options) end

---@class CylinderShape
---@field center? vector  mm; default {0, 0, 0}
---@field axis? vector  default {0, 0, 1}
---@field radius number  above 0 mm
---@field length number  above 0 mm

---@class SphereShape
---@field center? vector  mm; default {0, 0, 0}
---@field radius number  above 0 mm

---@class DiscShape
---@field center? vector  mm; default {0, 0, 0}
---@field normal? vector  to the side where it shines; default {0, 0, 1}
---@field radius number  above 0 mm

---@class PlaneShape
---@field center? vector  mm; default {0, 0, 0}
---@field normal? vector  to the side where it shines; default {0, 0, 1}
---@field across? vector  along the width; what of it is across the normal counts; default {1, 0, 0}
---@field width number  above 0 mm
---@field height number  above 0 mm

---@class EmitterShape
---@field cylinder? CylinderShape  default none
---@field sphere? SphereShape  default none
---@field disc? DiscShape  default none
---@field plane? PlaneShape  default none

---@class EmitterOptions
---@field mesh Mesh  counter-clockwise triangles shine; their backs are black
---@field flux? number  above 0 lm; default from the radiance
---@field radiance? number  instead of the flux; above 0 cd/m²; default from the flux
---@field spectrum Spectrum|number
---@field samples? integer  for the lobes of other surfaces; 1 to 100000000; default 10000
---@field seed? integer  of the samples; 0 to 9007199254740992; default 1
---@field visible? boolean  its surface is seen by camera, mirrored and transmitted rays; default true

---A surface that shines evenly; seen, unless it is not visible.
---@param options EmitterOptions
---@return Rayset
function lampyris.emitter(options) end

---@class CylinderOptions
---@field radius number  above 0 mm
---@field length number  above 0 mm
---@field flux number  above 0 lm
---@field spectrum Spectrum|number
---@field center? vector  mm; default {0, 0, 0}
---@field axis? vector  default {1, 0, 0}
---@field samples? integer  rays; 1 to 100000000; default 10000
---@field seed? integer  of the samples; 0 to 9007199254740992; default 1
---@field visible? boolean  its surface is seen by camera, mirrored and transmitted rays; default false

---The comparison source of Fig. 8: a cylinder that emits evenly from its lateral surface.
---@param options CylinderOptions
---@return Rayset
function lampyris.cylinder(options) end

---@class FilamentOptions
---@field wire_radius number  above 0 mm
---@field coil_radius number  above 0 mm
---@field pitch number  of one turn; above 0 mm
---@field turns number  above 0
---@field flux number  above 0 lm
---@field spectrum Spectrum|number
---@field center? vector  mm; default {0, 0, 0}
---@field axis? vector  default {1, 0, 0}
---@field samples? integer  rays; 1 to 100000000; default 100000
---@field seed? integer  of the samples; 0 to 9007199254740992; default 1
---@field visible? boolean  its coil is seen by camera, mirrored and transmitted rays; default false

---A coiled filament.
---@param options FilamentOptions
---@return Rayset
function lampyris.filament(options) end

---@class Glass
---@field radius number  outer; above 0 mm
---@field thickness number  above 0 mm
---@field material Material  with ior, k_tg and transmittance

---@class BulbOptions
---@field center? vector  of the light; mm; default {0, 0, 0}
---@field axis? vector  of the cap, pointing to the filament; default {0, 0, 1}
---@field filament_axis? vector  default {1, 0, 0}
---@field filament? "major"|"minor"  default "major"
---@field flux? number  above 0 lm; default the category's
---@field spectrum? Spectrum|number  default the category's
---@field samples? integer  rays; 1 to 100000000; default 100000
---@field seed? integer  of the samples; 0 to 9007199254740992; default 1
---@field visible? boolean  its filament is seen by camera, mirrored and transmitted rays; default false
---@field glass? Glass  a hollow sphere about the light; default none

---A bulb by its UN R37 category.
---@param category "P21W"|"PY21W"|"P21/5W"|"PY21/5W"|"W5W"
---@param options? BulbOptions
---@return Rayset
function lampyris.bulb(category, options) end

---@param transform Transform
---@return Rayset
function Rayset:transform(transform) end

---Writes a ray file below the output folder; its kind follows from the name's ending.
---@param path string
function Rayset:save(path) end

---@class RaysetHalvesOptions
---@field seed? integer  0 to 9007199254740992; default 1

---Two disjoint halves, drawn evenly, with the whole flux each.
---@param options? RaysetHalvesOptions
---@return Rayset, Rayset
function Rayset:halves(options) end

---@class RaysetNoiseOptions
---@field image fun(rays: Rayset): Image
---@field seed? integer  of the first split; 0 to 9007199254740992; default 1
---@field splits? integer  1 to 1000; default 1

---Relative error of a picture from the number of rays alone.
---@param options? RaysetNoiseOptions  none: of a measured emitter's table
---@return number
function Rayset:noise(options) end

---What a measured emitter's table holds: luminance by place and by direction.
---@return Figure
function Rayset:plot_luminance() end

-- Surroundings ---------------------------------------------------------------------------------

---What a ray sees that leaves the scene, and light for its lobes: a scene's `background`.
---@class Environment
local Environment = {}

lampyris.environment = {}

---@class EnvironmentLoadOptions
---@field rotate? number  right-handed about +Y; at 0 the picture's middle is -Z, behind the lamp; -360 to 360 degrees; default 0
---@field luminance? number  of the file's white (1, 1, 1); 0 to 1000000000000 cd/m²; default the file's; else 179 for Radiance, 1 for others
---@field illuminance? number  of all of it on a level plane; above 0 lx; default what follows from luminance
---@field scale? number  times as bright; above 0; default 1

---A latitude-longitude picture: EXR or Radiance.
---@param path string
---@param options? EnvironmentLoadOptions
---@return Environment
function lampyris.environment.load(path, options) end

---@class SunOptions
---@field elevation number  above the horizon; 0 to 90 degrees
---@field azimuth? number  as a view's: 0 is behind the viewer of the lamp's front; -360 to 360 degrees; default 0
---@field illuminance? number  facing it; 0 leaves the disc out; 0 to 1000000000 lx; default by turbidity and elevation; 0 for skies 1 to 6
---@field cct? number  of CIE daylight; 4000 to 25000 K; default a spectrum that the air has filtered

---@class SkyOptions
---@field kind "overcast"|"clear"|integer  overcast (Moon and Spencer), clear, or the number of a sky of CIE S 011
---@field sun? SunOptions  where it stands; default none: skies 2, 4 and 6 to 15 need it
---@field turbidity? number  luminous, of the air: 1 is clean, 5 hazy; 1 to 20; default 2.5
---@field illuminance? number  of sky and sun on a level plane; above 0 lx; default by kind and elevation
---@field cct? number  of the sky (CIE daylight); 4000 to 25000 K; default 6500 overcast, 8000, 12000 clear
---@field ground? Spectrum|number  reflectance of the ground below the horizon; 0 to 1; default 0

---A CIE sky.
---@param options SkyOptions
---@return Environment
function lampyris.environment.sky(options) end

---@class PanelOptions
---@field size number[]  along x and z; above 0 mm
---@field luminance number  0 to 1000000000000 cd/m²
---@field center? number[]  x and z; default {0, 0}

---@class RoomOptions
---@field size? number[]  along x and z; above 0 mm; default {8000, 12000}
---@field above? number  of the ceiling over the lamp; above 0 mm; default 2500
---@field below? number  of the floor under the lamp; above 0 mm; default 1000
---@field rows? integer  luminous rectangles in the ceiling: rows along z; 0 to 1000; default 3
---@field columns? integer  along x; 0 to 1000; default 2
---@field panel? number[]  of each rectangle, along x and z; above 0 mm; default {1500, 1500}
---@field panels? PanelOptions[]  rectangles of their own, beside those in rows; default {}
---@field luminance? number  of the rectangles; 0 to 1000000000000 cd/m²; default 3000
---@field ceiling? number  0 to 1000000000000 cd/m²; default 120
---@field walls? number  0 to 1000000000000 cd/m²; default 80
---@field floor? number  0 to 1000000000000 cd/m²; default 30
---@field cct? number  of all (CIE daylight); 4000 to 25000 K; default 5000
---@field spectrum? Spectrum|number  of the rectangles, in place of daylight; default daylight of cct
---@field illuminance? number  on a level plane: scales everything; above 0 lx; default what follows
---@field rotate? number  right-handed about +Y; -360 to 360 degrees; default 0

---A room with luminous rectangles in its ceiling, and the lamp in its middle.
---@param options? RoomOptions
---@return Environment
function lampyris.environment.room(options) end

---CIEDE2000 of colors that became spectra and colors again: mean and largest.
---@param gamut "srgb"|"p3"
---@return number, number
function lampyris.environment.round_trip(gamut) end

---lx on a plane with this normal, by default a level one, the sun included.
---@param normal? vector
---@return number
function Environment:illuminance(normal) end

---X, Y, Z in a direction; Y in cd/m².
---@param azimuth number
---@param elevation number
---@return number, number, number
function Environment:xyz(azimuth, elevation) end

---Spectral radiance in a direction.
---@param azimuth number
---@param elevation number
---@return Spectrum
function Environment:spectrum(azimuth, elevation) end

-- Scene, view, render ---------------------------------------------------------------------------

---@class SceneObject
---@field mesh Mesh
---@field material Material

---@class InterreflectionOptions

---@class SceneOptions
---@field objects SceneObject[]
---@field lights? Rayset[]  default {}
---@field background? Spectrum|number|Environment  0 or more; default 0
---@field ambient? Spectrum|number  0 or more; default 0
---@field photometry? "relative"|"absolute"  default "relative"
---@field shadows? boolean  whether opaque surfaces hide light samples; default false, or true in absolute photometry
---@field contact? number  surfaces of different objects that are this near are one interface; 0 to 1000 mm; default 0
---@field interreflection? InterreflectionOptions  light that surfaces return diffusely lights others; absolute photometry only; default none

---@class Scene
local Scene = {}

---@param options SceneOptions
---@return Scene
function lampyris.scene(options) end

---@class ViewOptions
---@field azimuth? number  to the right; -360 to 360 degrees; default 0
---@field elevation? number  up; -90 to 90 degrees; default 0
---@field distance? number  from eye to target; above 0 mm; default 3000
---@field target? vector  mm; default {0, 0, 0}
---@field fov? number  full vertical angle; between 0 and 180 degrees; default 6
---@field width? integer  1 to 65536 pixels; default 640
---@field height? integer  1 to 65536 pixels; default 480

---@class View: ViewOptions

---@param options ViewOptions
---@return View
function lampyris.view(options) end

---@class AdaptiveSamples
---@field min? integer  2 to 1000000; default 4
---@field max? integer  not below min; 2 to 1000000; default 256, or min if that is more
---@field error? number  relative standard error of a pixel's luminance; above 0; default 0.01

---@class QualityOptions
---@field samples? integer|AdaptiveSamples  of a pixel; 1 is its center; 1 to 1000000; default 4
---@field target_error? number  instead of all others: relative rms error of luminance over lit pixels; between 0 and 1
---@field light_error? number  bound on the relative error of the sum over light samples; 0 is the exact sum; 0 to 1; default 0.01
---@field layers? "lights"|"paths"  parts that the picture keeps: for each light, or direct, mirrored and transmitted light; default none
---@field max_depth? integer|"auto"  0 to 10000; default 8
---@field min_throughput? number  0 to 1; default 0.001
---@field dispersion? integer  directions into which a ray splits where ior depends on the wavelength; 1 does not split; 1 to 81; default 1
---@field wavelength_step? 5|10|20  nm; default 5

---@param view View
---@param quality? QualityOptions
---@return Image
function Scene:render(view, quality) end

---@class LightErrorOptions
---@field hits? integer  1 to 1000000; default 300
---@field light_error? number  0 to 1; default 0.01
---@field max_depth? integer|"auto"  0 to 10000; default 8
---@field min_throughput? number  0 to 1; default 0.001
---@field dispersion? integer  directions into which a ray splits where ior depends on the wavelength; 1 does not split; 1 to 81; default 1
---@field wavelength_step? 5|10|20  nm; default 5

---@class LightCheck
---@field sums integer  compared: one for each side of a hit and light that shine
---@field median number  of the relative errors
---@field percentile_95 number
---@field largest number
---@field largest_of_estimate number  largest ratio of an error to its estimate
---@field speedup number  time of the exact sums over that of these; some thousand hits make it reliable

---Compares light sums with exact ones at hits of the view.
---@param view View
---@param options? LightErrorOptions
---@return LightCheck
function Scene:check_light_error(view, options) end

---@class PathOptions
---@field x? number  image position in pixels, pixel 0's center being 0.5; default the middle
---@field y? number  default the middle
---@field max_depth? integer|"auto"  0 to 10000; default 8
---@field min_throughput? number  0 to 1; default 0.001
---@field dispersion? integer  directions into which a ray splits where ior depends on the wavelength; 1 does not split; 1 to 81; default 1
---@field wavelength_step? 5|10|20  nm; default 5

---@class PathSegment
---@field kind "camera"|"mirrored"|"transmitted"
---@field depth integer  0 for the camera's
---@field start vector  mm
---@field direction vector
---@field throughput number  mean over the bands
---@field finish vector  mm; nil where it hits nothing
---@field normal vector  of the surface that it hits
---@field object integer  of the scene, 1-based

---The rays that one image position asks for.
---@param view View
---@param options? PathOptions
---@return PathSegment[]
function Scene:paths(view, options) end

-- Images ----------------------------------------------------------------------------------------

---@class lampyris.image
lampyris.image = {}

---@class ImageLoadOptions
---@field luminance? number  of the picture's white; the image is then in cd/m²; 0 to 1000000000000 cd/m²; default the file's, where it has one

---An image from an EXR file of lampyris, with all its bands; or from a picture of colors (PNG, JPEG,
---TIFF, Radiance, EXR), with smooth spectra that have them.
---@param path string
---@param options? ImageLoadOptions
---@return Image
function lampyris.image.load(path, options) end

---The picture of lamps dimmed to these shares of their light; `a + b` and `0.3 * a` are short for it.
---@param terms (Image|table)[]  {{image, weight}, …}; an image alone has the weight 1
---@return Image
function lampyris.image.sum(terms) end

---@class TargetReport
---@field error number  estimated, relative rms of luminance over lit pixels
---@field reached boolean  whether the error is within the target
---@field sampling_error number  its share of camera rays
---@field light_sum_error number  its share of light sums
---@field truncation_error number  its share of max_depth and min_throughput
---@field samples number  mean of a pixel
---@field most_samples integer  of a pixel
---@field max_depth integer  chosen
---@field min_throughput number  chosen
---@field light_error number  chosen
---@field wavelength_step number  nm

---@class Stats
---@field camera_rays integer
---@field mirror_rays integer
---@field transmitted_rays integer
---@field shadow_rays integer
---@field rays_cut integer  that ended at max_depth with more than 1 % of their light
---@field light_sums integer  one for each side of a hit and light that shine
---@field nodes_per_sum number  of light trees
---@field samples_per_sum number  of lights
---@field light_error number  of mean luminance by the light sums, relative
---@field largest_light_error number  of a pixel, relative
---@field interreflection_error? number  of the light that bounces, from the number of its samples
---@field target TargetReport  what target_error chose; nil without

---@class Cost
---@field seconds number  of rendering
---@field expected_seconds number  of rendering, as thought after the first samples; nil without target_error
---@field bvh_seconds number  of building the scene's BVH
---@field light_tree_seconds number  of building its light trees
---@field peak_memory_mb number  of the program so far

---@class ImageStats: Stats, Cost

---@class Image
---@operator add(Image): Image
---@operator mul(number): Image
---@field width integer
---@field height integer
---@field layers table<string, Image>  parts that add up to the image: "light 1", …, "surroundings", or "direct", "mirrored", "transmitted"
---@field stats? ImageStats  nil unless this script rendered the image
local Image = {}

---@class RegionOptions
---@field x? integer  0-based from the left; 0 to 65536; default 0
---@field y? integer  0-based from the top; 0 to 65536; default 0
---@field width? integer  1 to 65536 pixels; default 1
---@field height? integer  1 to 65536 pixels; default 1

---Mean spectrum of a region, or of the whole image.
---@param region? RegionOptions
---@return Spectrum
function Image:spectrum(region) end

---@param region? RegionOptions
---@return number X, number Y, number Z
function Image:xyz(region) end

---@param region? RegionOptions
---@return number  cd/m² in an absolute scene
function Image:luminance(region) end

---Luminance of each pixel of a region, row by row.
---@param region? RegionOptions
---@return number[]
function Image:luminances(region) end

---@class ImageDifference
---@field lit_pixels integer  which all but spectral_rms are about
---@field relative_rms number  of luminance
---@field worst number  relative, of a pixel's luminance
---@field mean_delta_e_2000 number
---@field percentile_95_delta_e_2000 number
---@field spectral_rms number  relative to the rms of the reference

---How far this image is from a reference of the same size.
---@param reference Image
---@return ImageDifference
function Image:compare(reference) end

---@class UncertaintyOptions
---@field region? RegionOptions  of luminance and chromaticity; the whole image unless one is given
---@field inputs table<string, UncertainInput>
---@field correlation? {[1]: string, [2]: string, [3]: number}[]  `{{"a", "b", r}, …}`: coefficients of fluxes and numbers that are not independent
---@field quality? QualityOptions  of the image, for the scenes that are tried
---@class UncertainInput
---@field u Spectrum|number  standard uncertainty: of a value in its unit; of a flux or spectrum relative, 0.02 is 2 %; 0 or more
---@field light? integer  of the scene, from 1; the image has layers = "lights"; 1 to 100000
---@field spectrum? Spectrum  of that light, if it and not the flux is uncertain
---@field scene? fun(value: number): Scene  from the value to the scene; without a value, from a factor of an uncertain spectrum
---@field value? number
---@field correlation? number  of a spectrum's errors: r = exp(−Δλ/this); 0 is independent bands; 0 to 1000000 nm; default 0
---@class UncertaintyBudget
---@field Y number  luminance of the region
---@field x number
---@field y number
---@field I number  intensity of the image, cd; 0 where it has none
---@field u_Y number  combined standard uncertainty
---@field u_x number
---@field u_y number
---@field u_I number
---@field budget UncertaintyContribution[]  by input, the largest u_Y first
---@class UncertaintyContribution
---@field input string
---@field u_Y number  from this input alone
---@field u_x number
---@field u_y number
---@field u_I number

---Standard uncertainties of luminance, chromaticity and intensity from those of the inputs.
---@param options UncertaintyOptions
---@return UncertaintyBudget
function Image:uncertainty(options) end

---@class HomogeneityOptions
---@field region? RegionOptions  the whole image unless one is given
---@field grid? integer[]  columns and rows of cells; 1 to 65536; default one a pixel
---@field halves? Image[]  pictures with rayset:halves, two for each split: they tell the noise of the rays; default {}
---@class Homogeneity
---@field mean number  luminance
---@field min number  luminance of the darkest cell
---@field max number  luminance of the brightest cell
---@field contrast number  RMS: standard deviation of the cells over their mean
---@field uniformity number  darkest over brightest cell
---@field gradient number  largest step between cells side by side, over the mean
---@field cells integer[]  columns and rows
---@field rays? NoiseShare  noise from the number of light rays; nil without halves
---@field samples? NoiseShare  noise from the number of camera rays; nil unless samples are adaptive
---@class NoiseShare
---@field noise number  RMS contrast that it makes on an even surface
---@field mean number  standard error
---@field min number  likewise
---@field max number  likewise
---@field contrast number  likewise, with what noise adds
---@field uniformity number  standard error
---@field gradient number  likewise

---How even the luminance of a region is, with the errors that rays and samples leave.
---@param options? HomogeneityOptions
---@return Homogeneity
function Image:homogeneity(options) end

---Luminous intensity toward the eye, of a scene with photometry = "absolute".
---@return number  cd
function Image:intensity() end

---@class FalseColorOptions
---@field log? boolean  default true
---@field range? number[]  default what the image needs
---@field label? string  of the scale bar; default luminance, in cd/m² or relative as the scene is

---A figure of the luminance in false colors, with a scale bar.
---@param options? FalseColorOptions
---@return Figure
function Image:false_color(options) end

---@class GlareOptions
---@field age? number  0 to 120 years; default 25
---@field pigment? number  0 to 1.2; default 0.5
---@field strength? number  0 to 1; default 1

---@class ExposureOptions
---@field ev? number  -100 to 100 stops
---@field adaptation? number  luminance that an eye is adapted to, shown as middle gray; above 0 cd/m²

---How a picture is shown.
---@class LookOptions
---@field display? Display  default sRGB
---@field bits? integer  of a channel; 1 to 16; default the display's
---@field exposure? "auto"|number|ExposureOptions  a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²; factor above 0; default "auto"
---@field gamut? "clip"|"desaturate"  default "clip"
---@field glare? boolean|Glare  of the eye; true is the default eye's; default none
---@field tone? "linear"|"reinhard"|"photographic"|fun(luminance: number): number  the curve on luminance, from and to luminance relative to display white; default "linear"
---@field camera? false|Camera  looks in place of the eye; default none

---@class PngOptions
---@field look? "paper"|"seen"|"camera"|LookOptions  which the options beside it change; default "paper"
---@field display? Display  default sRGB
---@field bits? integer  of a channel; 1 to 16; default the display's
---@field exposure? "auto"|number|ExposureOptions  a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²; factor above 0; default "auto"
---@field gamut? "clip"|"desaturate"  default "clip"
---@field glare? boolean|Glare  of the eye; true is the default eye's; default none
---@field tone? "linear"|"reinhard"|"photographic"|fun(luminance: number): number  the curve on luminance, from and to luminance relative to display white; default "linear"
---@field camera? false|Camera  looks in place of the eye; default none

---What was done to a picture's light for its display.
---@class PngReport
---@field glare_lost number  share of the light scattered out of the frame
---@field exposure number  factor from the image's XYZ to the display's cd/m²
---@field outside_gamut integer  pixels that the display cannot show
---@field too_dark integer  pixels darker than its black
---@field too_bright integer  pixels brighter than its white
---@field too_saturated integer  pixels outside of its primaries
---@field mean_delta_e_2000 number
---@field max_delta_e_2000 number

---@class HdrOptions
---@field colors? "rgbe"|"xyze"  Radiance's RGB, to which more saturated colors are toned down; or tristimulus values; default "rgbe"

---@class JpegOptions
---@field quality? integer  1 to 100; default 95
---@field look? "paper"|"seen"|"camera"|LookOptions  which the options beside it change; default "paper"
---@field display? Display  default sRGB
---@field bits? integer  of a channel; 1 to 16; default the display's
---@field exposure? "auto"|number|ExposureOptions  a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²; factor above 0; default "auto"
---@field gamut? "clip"|"desaturate"  default "clip"
---@field glare? boolean|Glare  of the eye; true is the default eye's; default none
---@field tone? "linear"|"reinhard"|"photographic"|fun(luminance: number): number  the curve on luminance, from and to luminance relative to display white; default "linear"
---@field camera? false|Camera  looks in place of the eye; default none

---@class TiffOptions
---@field samples? "integer"|"float"  digits, of 16 bits unless more is said; or linear Rec. 709 of the light; default "integer"
---@field look? "paper"|"seen"|"camera"|LookOptions  which the options beside it change; default "paper"
---@field display? Display  default sRGB
---@field bits? integer  of a channel; 1 to 16; default the display's
---@field exposure? "auto"|number|ExposureOptions  a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²; factor above 0; default "auto"
---@field gamut? "clip"|"desaturate"  default "clip"
---@field glare? boolean|Glare  of the eye; true is the default eye's; default none
---@field tone? "linear"|"reinhard"|"photographic"|fun(luminance: number): number  the curve on luminance, from and to luminance relative to display white; default "linear"
---@field camera? false|Camera  looks in place of the eye; default none

---@class ExrOptions
---@field bands? "float"|"half"|"pxr24"|"none"  of which float reads back bit for bit; default "float"

---Writes light (.exr, .hdr) or a picture of it (.png, .jpg, .tif).
---@param path string  below the output folder
---@param options? PngOptions|JpegOptions|TiffOptions|ExrOptions|HdrOptions
---@return PngReport  of a picture
function Image:save(path, options) end

-- Cameras ---------------------------------------------------------------------------------------

---@class Camera

---@class lampyris.camera
---@field nikon_d5100 Camera  measured at NPL
---@field sigma_sd_merrill Camera  measured at NPL
lampyris.camera = {}

---@class CameraOptions
---@field red Spectrum|number  response to equal radiant power
---@field green Spectrum|number
---@field blue Spectrum|number
---@field exposure? "auto"|number|ExposureOptions  "auto": 99.5 % of the pixels fill no channel; factor above 0; default "auto"
---@field full_well? number  level of a full channel, relative to display white; above 0; default 1
---@field white? number[]  {x, y} that the white balance makes neutral: D65; between 0 and 1; default {0.3127, 0.329}
---@field name? string  default "camera"

-- Displays --------------------------------------------------------------------------------------

---@class lampyris.display
---@field eizo_t766 Display  the paper's EIZO FlexScan T766
---@field srgb Display
---@field p3 Display  Display P3, 80 cd/m²
---@field rec2020 Display  BT.2020's primaries with sRGB's curve, 80 cd/m²
lampyris.display = {}

---@class PqOptions
---@field peak? number  between 0 and 10000 cd/m²; default 1000
---@field bits? integer  of a channel; 1 to 16; default 16

---An HDR display with P3's primaries; luminance is absolute.
---@param options? PqOptions
---@return Display
function lampyris.display.p3_pq(options) end

---An HDR display with BT.2020's primaries (HDR10); luminance is absolute.
---@param options? PqOptions
---@return Display
function lampyris.display.rec2020_pq(options) end

---@class Display
---@field verdict? string  of a fitted display: whether gain, offset and gamma describe it, and where not
---@field gain number[]  k_g of red, green, blue
---@field offset number[]  k_o
---@field gamma number[]
---@field bits integer
---@field channels table<"red"|"green"|"blue", DisplayChannel>
---@field plot Figure tone curves, and the measured points of a fitted display
local Display = {}

---@class DisplayChannel
---@field gain number  k_g
---@field offset number  k_o
---@field gamma number
---@field gain_error? number  standard error; nil unless the display was fitted
---@field gamma_error? number
---@field rms? number  relative to the channel's maximum

---@class DisplayNewOptions
---@field gain? number[]  k_g of red, green, blue; above 0; default {1, 1, 1}
---@field offset? number[]  k_o; default {0, 0, 0}
---@field gamma? number[]  above 0; default {2.2, 2.2, 2.2}
---@field black? number[]  {X, Y, Z}; 0 or more cd/m²; default {0, 0, 0}
---@field matrix number[][]  cd/m²
---@field bits? integer  of a channel; 1 to 16; default 8
---@field name? string  default "display"

---@param options DisplayNewOptions
---@return Display
function lampyris.display.new(options) end

---@class DisplayFitOptions
---@field red? number[][]  {{d, luminance}, …} or {{d, X, Y, Z}, …}
---@field green? number[][]
---@field blue? number[][]
---@field file? string  instead of red, green and blue
---@field matrix? number[][]  cd/m²; default from the ramps' XYZ
---@field black? number[]  {X, Y, Z}; 0 or more cd/m²; default what the ramps show at digit 0, else 0
---@field curves? "gog"|"measured"  eq. 5, or curves through the measured levels; default "gog"
---@field bits? integer  of a channel; 1 to 16; default 8
---@field name? string  default "display"

---Gain, offset and gamma from measured ramps.
---@param options DisplayFitOptions
---@return Display
function lampyris.display.fit(options) end

---@class DisplayLoadOptions
---@field luminance? number  of white; above 0 cd/m²; default the profile's, else 80

---A monitor's ICC profile with a matrix and tone curves.
---@param path string
---@param options? DisplayLoadOptions
---@return Display
function lampyris.display.load(path, options) end

---@class DisplayRampsOptions
---@field bits? integer  1 to 16; default 8

---Rows of a file, as display.fit takes them.
---@param path string
---@param options? DisplayRampsOptions
---@return table  red, green, blue
function lampyris.display.ramps(path, options) end

---@param r number  0 to 2ⁿ − 1
---@param g number
---@param b number
---@return number X, number Y, number Z
function Display:xyz(r, g, b) end

---@param X number  cd/m²
---@param Y number
---@param Z number
---@return integer r, integer g, integer b
function Display:digital(X, Y, Z) end

---@class PatchError
---@field digits number[]  {r, g, b}
---@field measured number[]  {X, Y, Z}, cd/m²
---@field predicted number[]  {X, Y, Z}, cd/m²
---@field delta_e_ab number
---@field delta_e_2000 number
---@field lightness_error number

---@class Verification
---@field mean number  ΔE*ab
---@field max number  ΔE*ab
---@field mean_2000 number  ΔE00
---@field max_2000 number  ΔE00
---@field patches PatchError[]
---@field worst PatchError[]  ten at most, the worst first
---@field verdict string  in words

---@param patches number[][]|string  {{r, g, b, X, Y, Z}, …} or a file
---@return Verification
function Display:verify(patches) end

---@param path string  below the output folder, ending in .icc
function Display:save(path) end

-- Sweeps ----------------------------------------------------------------------------------------

---@class SweepView
---@field view? View
---@field scene? Scene  default the sweep's
---@field name? string  of the view's files: letters, digits and _ - + .; default view_0001, …

---@class SweepOptions
---@field scene? Scene  of all views that name none
---@field views? (View|SweepView)[]|fun(index: integer): View|SweepView|nil, Scene|nil  a list; or a function that returns one view (and scene) after the other, or yields them
---@field output string  a folder below the output folder
---@field quality? QualityOptions
---@field png? PngOptions
---@field regions? table<string, RegionOptions>  whose spectra and chromaticities manifest and page show; default none
---@field exposure? "one"|"each"  automatic exposure of the pictures: the brightest view's for all, or each view's own; default "one"
---@field false_color? "one"|"each"  range of the pictures of luminance; default "one"

---@class SweepReport
---@field views integer  rendered and kept
---@field rendered integer
---@field kept integer  that were there already

---@class SweepDone: SweepReport
---@field folder string

---Renders views into a folder that can be stopped, resumed, shared out and verified.
---@param options SweepOptions
---@return SweepDone
function lampyris.sweep(options) end

-- Studies ---------------------------------------------------------------------------------------

---@class Spread
---@field normal? number[]  mean and standard deviation
---@field uniform? number[]  lower and upper end
---@field list? number[]  each value alike

---@class StudyOptions
---@field parameters table<string, Spread|number[]>  `name = {normal = {mean, sd}}`, `{uniform = {low, high}}` or `{a, b, …}`
---@field samples? integer  draws; a grid has as many as fit evenly; 1 to 65536; default 1000
---@field design? "sobol"|"latin hypercube"|"grid"  how draws are spread; default "sobol"
---@field seed? integer  of the draws; 0 to 9007199254740992; default 1
---@field output string  below the output folder; gets draws.csv and index.html
---@field run fun(parameters: table<string, number>): table<string, number|boolean>  from parameters by name to results by name: numbers, or true and false

---@class Study
---@field rows table<string, number>[]  parameters and results by name, a table a draw
---@field draws integer  that are there
---@field made integer  by this run
---@field mean table<string, number>  by result
---@field sd table<string, number>  by result
local Study = {}

---What `percent` of all draws do not exceed, the ends of its interval, and their confidence: 0.95 or what so
---few draws allow.
---@param name string  of a result
---@param percent number
---@return number value
---@return number low
---@return number high
---@return number confidence
function Study.percentile(name, percent) end

---Shares of a result's variance by parameter, and how much of it they explain (1 at best).
---@param name string  of a result
---@return table<string, {first: number, total: number}> shares
---@return number explained
function Study.sensitivity(name) end

---The share of draws for which the function returns true, and its 95 % confidence interval.
---@param predicate fun(row: table<string, number>): boolean
---@return number value
---@return number low
---@return number high
function Study.probability(predicate) end

---Many runs with inputs that vary; one that was stopped goes on where it was.
---@param options StudyOptions
---@return Study
function lampyris.study(options) end

-- Photometry ------------------------------------------------------------------------------------

---@class lampyris.photometry
lampyris.photometry = {}

---@class Grid
---@field h number[]  degrees
---@field v number[]  degrees
---@field flux number  of the scene's lights, lm
local Grid = {}

---@class GridOptions
---@field scene Scene  with photometry = "absolute"
---@field h? number[]  to the right, ascending; -360 to 360 degrees; default {-20, -10, -5, 0, 5, 10, 20}
---@field v? number[]  up, ascending; -90 to 90 degrees; default {-10, -5, 0, 5, 10}
---@field distance? number  above 0 mm; default 3000
---@field target? vector  mm; default {0, 0, 0}
---@field fov? number  the whole lamp has to fit; between 0 and 180 degrees; default 6
---@field width? integer  1 to 65536 pixels; default 320
---@field height? integer  1 to 65536 pixels; default 240
---@field quality? QualityOptions

---Luminous intensity over horizontal and vertical angles.
---@param options GridOptions
---@return Grid
function lampyris.photometry.grid(options) end

---Linear between the grid's angles.
---@param h number  degrees
---@param v number  degrees
---@return number  cd
function Grid:at(h, v) end

---@class GridCheckOptions
---@field lamp string  a lamp of the file
---@field file? string  CSV: lamp, color, h, v, min, max; default UN R148
---@field marked_d? boolean  the maximum of lamps marked "D"; default false
---@field side? "left"|"right"  of the vehicle as seen from behind: checks the field of visibility
---@field position? Grid  of the position lamp combined with this stop lamp: checks their ratio

---@class PointCheck
---@field h number  degrees
---@field v number  degrees
---@field min? number  cd
---@field max? number  cd
---@field intensity? number  cd; nil where the grid does not reach
---@field color? string  of signal lights
---@field pass boolean

---@class WeakestPoint
---@field h number  degrees
---@field v number  degrees
---@field min number
---@field pass boolean
---@field intensity? number  cd, of field
---@field ratio? number  of ratio

---@class GridCheck
---@field pass boolean
---@field color string
---@field points PointCheck[]
---@field field? WeakestPoint  of the field of visibility
---@field ratio? WeakestPoint  of stop lamp to position lamp

---Compares with a lamp's limits, point by point.
---@param lamp "R1"|"R2"|"S1"|"S2"|"S3"|"S4"|"2a"|"2b"|GridCheckOptions
---@return GridCheck
function Grid:check(lamp) end

---@class GridSaveOptions
---@field name? string  of the lamp; default "lamp"
---@field issued? string  .ies: the file's date of issue; default none

---@param path string  below the output folder, ending in .csv, .ies or .ldt
---@param options? GridSaveOptions
function Grid:save(path, options) end


-- Figures and text ------------------------------------------------------------------------------

---@class FigureAxis
---@field label? string  with its unit; default ""
---@field log? boolean  default false
---@field range? number[]  default what the series need

---@class FigureSeries
---@field points number[][]  {{x, y}, …}; {} parts a line
---@field name? string  for the legend; default ""
---@field style? "line"|"dashes"|"points"|"both"  default "line"
---@field errors? number[]  half lengths of error bars, one for each point
---@field color? number[]  {red, green, blue}; 0 to 255

---@class ChartPanel
---@field series FigureSeries[]
---@field x? FigureAxis
---@field y? FigureAxis
---@field title? string  default ""

---@class PicturePanel
---@field image Image
---@field crop? RegionOptions
---@field false_color? boolean|FalseColorOptions  instead of the picture: its luminance; default false
---@field title? string  default ""
---@field look? "paper"|"seen"|"camera"|LookOptions  default "paper"
---@field exposure? "auto"|number|ExposureOptions  a factor, or stops or an adaptation in a table; a PQ display shows its own cd/m²; factor above 0; default "auto"
---@field gamut? "clip"|"desaturate"  default "clip"
---@field glare? boolean|Glare  of the eye; true is the default eye's; default none
---@field tone? "linear"|"reinhard"|"photographic"|fun(luminance: number): number  the curve on luminance, from and to luminance relative to display white; default "linear"
---@field camera? false|Camera  looks in place of the eye; default none

---Lines in space.
---@class SegmentsPanel
---@field segments vector[][]  {{from, to}, …}, mm
---@field dots? boolean  green dots where segments start, white lines on dark ground; default false
---@field azimuth? number  degrees; default 30
---@field elevation? number  degrees; default 20
---@field title? string  default ""

---`panels`, or the keys of one panel.
---@class FigureOptions
---@field panels? (ChartPanel|PicturePanel|SegmentsPanel)[]  instead of the keys of one panel
---@field columns? integer  of panels; 1 to 100; default all in one row
---@field width? integer  1 to 16384 pixels; default 800
---@field height? integer  1 to 16384 pixels; default 600
---@field title? string  default ""

---@class Figure
local Figure = {}

---@param options FigureOptions|ChartPanel|PicturePanel|SegmentsPanel
---@return Figure
function lampyris.figure(options) end

---@param path string  below the output folder, ending in .png or .svg
function Figure:save(path) end

---@return string  SVG text
function Figure:svg() end

---f(…); under `lampyris watch`, what it returned in an earlier run where f, all that it reaches and
---the arguments hold the same. For what takes long: f says and changes nothing, and its result is of
---meshes, rays, spectra, numbers, texts, truth values, and tables of these.
---@generic T
---@param f fun(...): T
---@param ... any
---@return T
function lampyris.keep(f, ...) end

---Writes a text file below the output folder.
---@param path string
---@param text string
function lampyris.write(path, text) end

---Reads a text file.
---@param path string
---@return string
function lampyris.read(path) end

return lampyris
