-- How far an answer is from the exact sums: over pixels of at least a hundredth of the brightest.
--
--   lampyris run benches/many_rays/score.lua --read FOLDER -- EXACT ANSWER

local lampyris = require "lampyris"

local function numbers(path)
  local list = {}
  for word in lampyris.read(path):gmatch "%S+" do table.insert(list, tonumber(word)) end
  return list
end

local exact, answer = numbers(arg[1]), numbers(arg[2])
assert(#exact == #answer, ("the answer has %d pixels, not %d"):format(#answer, #exact))
local brightest = math.max(table.unpack(exact))
local squares, worst, lit = 0, 0, 0
for k, value in ipairs(exact) do
  if value >= 0.01 * brightest then
    local error = math.abs(answer[k] / value - 1)
    squares, worst, lit = squares + error ^ 2, math.max(worst, error), lit + 1
  end
end
print(("%d lit pixels: rms error %.2g, worst %.2g"):format(lit, math.sqrt(squares / lit), worst))
