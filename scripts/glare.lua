-- The eye's glare: a lit lamp as an eye of 25 and of 70 years sees it (CIE total glare function).
--
--   lampyris run scripts/glare.lua [-- tiny]

local lampyris = require "lampyris"
local model = require "model"
local paper = require "paper"

local width = paper.size(400, 40)
local built = model.build(require "model1", paper.size(2, 6))
local shot = built.shots[1]
local scene = model.scene(built, shot, paper.size(20000, 100))
local image = scene:render(model.view(shot, width), { samples = 4 })

local eyes = {
  { title = "without glare" },
  { title = "25 years", glare = { age = 25, pigment = 0.5 } },
  { title = "70 years", glare = { age = 70, pigment = 0.5 } },
}
local panels = {}
for k, eye in ipairs(eyes) do
  local exposure = paper.exposure(shot.white / 6) -- bright, so that the halo shows
  panels[k] = { title = eye.title, glare = eye.glare, image = image, exposure = exposure }
  image:save(("glare_%d.png"):format(k), { glare = eye.glare, exposure = exposure })
end

local report = paper.report("glare", "Glare: a lit lamp and what the eye makes of it")
report:figure("glare", lampyris.figure {
  width = 1350, height = 380, columns = 3, panels = panels,
}, "model 1, six times as bright as in Fig. 11; the picture's file of light is never touched")
report:note("The paper names the eye's and the display's dynamic range as future work.")
