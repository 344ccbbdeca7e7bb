--- What the scripts of the paper's figures and tables share: reports and lists of numbers.
--
--   local report = paper.report("fig9", "Spectra of bulb, reflector and lens")
--   report:figure("fig9", lampyris.figure { … }, "what it shows")  -- fig9.png, fig9.svg
--   report:compare("ΔE mean", 1.23, 1.9592)                        -- ours beside the paper's
--   report:table({ "model", "bulb" }, { { 1, "P21/5W" }, … })
--
-- Numbers are printed as they come; all.lua collects the reports into one page. The argument
-- "tiny" makes every script small enough for a test.

local lampyris = require "lampyris"

local paper = { reports = {} }

paper.is_tiny = arg[1] == "tiny"

--- The first value, or the second in a tiny run.
function paper.size(full, tiny)
  if paper.is_tiny then return tiny end
  return full
end

-- Reports. ---------------------------------------------------------------------------------------

local Report = {}
Report.__index = Report

function paper.report(name, title)
  local report = setmetatable({ name = name, title = title, parts = {}, summary = {} }, Report)
  table.insert(paper.reports, report)
  print(("%s: %s"):format(name, title))
  return report
end

function Report:add(part)
  table.insert(self.parts, part)
end

--- Saves a figure as PNG and SVG.
function Report:figure(name, figure, caption)
  figure:save(name .. ".png")
  figure:save(name .. ".svg")
  self:add { kind = "figure", name = name, figure = figure, caption = caption }
  print(("  %s.png, %s.svg: %s"):format(name, name, caption))
end

function Report:note(text)
  self:add { kind = "note", text = text }
  print("  " .. text)
end

--- Four digits, or what is no number as it is.
function paper.text(value)
  if math.type(value) == "float" then
    local text = ("%.4g"):format(value)
    return (text:find("e+", 1, true)) and ("%.0f"):format(value) or text
  end
  return tostring(value)
end

--- Columns as wide as their widest cell; bytes beyond ASCII count as one column a letter.
local function print_rows(rows)
  local widths = {}
  for _, row in ipairs(rows) do
    for k, cell in ipairs(row) do
      widths[k] = math.max(widths[k] or 0, utf8.len(cell))
    end
  end
  for _, row in ipairs(rows) do
    local line = {}
    for k, cell in ipairs(row) do
      line[k] = cell .. (" "):rep(widths[k] - utf8.len(cell))
    end
    print("  " .. table.concat(line, "  "):gsub("%s+$", ""))
  end
end

function Report:table(headings, rows)
  local texts = { headings }
  for _, row in ipairs(rows) do
    local line = {}
    for k = 1, #headings do
      line[k] = row[k] == nil and "" or paper.text(row[k])
    end
    table.insert(texts, line)
  end
  self:add { kind = "table", rows = texts }
  print_rows(texts)
end

--- A number of ours beside the paper's, or beside what the paper says, for the page's summary.
function Report:summarize(what, ours, theirs)
  local row = { what, paper.text(ours), theirs and paper.text(theirs) or "–" }
  table.insert(self.summary, row)
  print(("  %s: %s (paper: %s)"):format(table.unpack(row)))
  return row
end

--- The same, and in the report itself.
function Report:compare(what, ours, theirs)
  local last = self.parts[#self.parts]
  if not (last and last.kind == "comparison") then
    last = { kind = "comparison", rows = { { "", "Lampyris", "paper" } } }
    self:add(last)
  end
  table.insert(last.rows, self:summarize(what, ours, theirs))
end

-- Lists of numbers. ------------------------------------------------------------------------------

function paper.map(list, f)
  local result = {}
  for k, value in ipairs(list) do result[k] = f(value, k) end
  return result
end

function paper.mean(list)
  local sum = 0
  for _, value in ipairs(list) do sum = sum + value end
  return sum / #list
end

--- Standard deviation divided by the mean (RMS contrast).
function paper.contrast(list)
  local mean, squares = paper.mean(list), 0
  for _, value in ipairs(list) do squares = squares + (value - mean) ^ 2 end
  return math.sqrt(squares / #list) / mean
end

--- Pearson's correlation.
function paper.correlation(a, b)
  local mean_a, mean_b, ab, aa, bb = paper.mean(a), paper.mean(b), 0, 0, 0
  for k = 1, #a do
    local x, y = a[k] - mean_a, b[k] - mean_b
    ab, aa, bb = ab + x * y, aa + x * x, bb + y * y
  end
  return ab / math.sqrt(aa * bb)
end

--- Root mean square of the difference over that of the reference.
function paper.relative_rms(list, reference)
  local difference, squares = 0, 0
  for k, value in ipairs(reference) do
    difference, squares = difference + (list[k] - value) ^ 2, squares + value ^ 2
  end
  return math.sqrt(difference / squares)
end

--- A spectrum as points of a chart, its largest value 1 if `normalized`.
function paper.spectrum_points(spectrum, normalized)
  local values = spectrum:values()
  local largest = normalized and math.max(table.unpack(values)) or 1
  return paper.map(values, function(value, k) return { 375 + 5 * k, value / largest } end)
end

-- Pictures. --------------------------------------------------------------------------------------

--- From luminance to sRGB's cd/m², so that `white` becomes white.
function paper.exposure(white)
  local _, display_white = lampyris.display.srgb:xyz(255, 255, 255)
  return display_white / white
end

return paper
