-- Runs every figure, table and study, and writes one page of them: out/index.html.
--
--   lampyris run scripts/all.lua [-- tiny]

local lampyris = require "lampyris"
local paper = require "paper"

local of_the_paper = {
  "fig1", "fig3", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "fig11",
  "table2", "table3", "table4", "table5",
}
local beyond_it = {
  "fig8_samples", "start_points", "interfaces", "glare", "tradeoff", "target_error", "stability",
}

local style = [[
body { font: 16px/1.5 "DejaVu Sans", Verdana, sans-serif; color: #222; background: #fff;
       max-width: 1180px; margin: 2em auto; padding: 0 1.5em; }
h1 { font-size: 1.8em; margin-bottom: 0.2em; }
h2 { font-size: 1.45em; margin-top: 2.5em; border-top: 2px solid #999; padding-top: 1em; }
h3 { font-size: 1.15em; margin-top: 2.2em; border-top: 1px solid #ccc; padding-top: 1em; }
h2 + section h3 { border-top: none; margin-top: 0; }
nav a { margin-right: 1em; white-space: nowrap; }
a { color: #0b5394; }
figure { margin: 1em 0; }
figure svg { max-width: 100%; height: auto; }
figcaption, .note { color: #555; font-size: 0.92em; }
table { border-collapse: collapse; margin: 1em 0; font-size: 0.92em; }
th, td { text-align: left; padding: 0.2em 1.1em 0.2em 0; border-bottom: 1px solid #ddd;
         font-variant-numeric: tabular-nums; }
.wide { overflow-x: auto; }
@media print { section { break-inside: avoid-page; } nav { display: none; } }
]]

local function escaped(text)
  return (text:gsub("[&<>]", { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;" }))
end

--- An SVG that scales with the page.
local function inline(svg)
  svg = svg:gsub("^<%?xml.-%?>%s*", "")
  local width, height = svg:match('<svg[^>]-width="(%d+)"'), svg:match('<svg[^>]-height="(%d+)"')
  if not svg:match("<svg[^>]-viewBox") then
    svg = svg:gsub("<svg", ('<svg viewBox="0 0 %s %s"'):format(width, height), 1)
  end
  return svg
end

local function row(cells, tag)
  local html = paper.map(cells, function(cell)
    return ("<%s>%s</%s>"):format(tag, escaped(cell), tag)
  end)
  return "<tr>" .. table.concat(html) .. "</tr>"
end

local function table_html(part)
  local html = { '<div class="wide"><table>', row(part.rows[1], "th") }
  for k = 2, #part.rows do table.insert(html, row(part.rows[k], "td")) end
  table.insert(html, "</table></div>")
  return table.concat(html, "\n")
end

local to_html = {
  figure = function(part)
    return ("<figure>\n%s\n<figcaption>%s</figcaption>\n</figure>"):format(
      inline(part.figure:svg()), escaped(part.caption))
  end,
  note = function(part) return ('<p class="note">%s</p>'):format(escaped(part.text)) end,
  table = table_html,
  comparison = table_html,
}

local function section(report)
  local html = { ('<section id="%s">\n<h3>%s</h3>'):format(report.name, escaped(report.title)) }
  for _, part in ipairs(report.parts) do table.insert(html, to_html[part.kind](part)) end
  table.insert(html, ('<p class="note">scripts/%s.lua</p>\n</section>'):format(report.name))
  return table.concat(html, "\n")
end

--- A report's short name, as a link: "Fig. 1" of "Fig. 1: ray paths through the lamp".
local function link(report)
  local short = report.title:match("^(.-):") or report.title
  return ('<a href="#%s">%s</a>'):format(report.name, escaped(short))
end

--- Every number that was put beside another, in one table.
local function summary(reports)
  local html = { '<div class="wide"><table>', row({ "", "number", "Lampyris", "paper" }, "th") }
  for _, report in ipairs(reports) do
    for _, cells in ipairs(report.summary) do
      local rest = row(cells, "td"):gsub("^<tr>", "")
      table.insert(html, "<tr><td>" .. link(report) .. "</td>" .. rest)
    end
  end
  table.insert(html, "</table></div>")
  return table.concat(html, "\n")
end

--- Runs scripts; returns their reports.
local function run(names)
  local first = #paper.reports + 1
  for _, name in ipairs(names) do require(name) end
  return table.move(paper.reports, first, #paper.reports, 1, {})
end

local function chapter(title, reports)
  return ("<h2>%s</h2>\n"):format(title) .. table.concat(paper.map(reports, section), "\n")
end

local figures, studies = run(of_the_paper), run(beyond_it)
lampyris.write("index.html", table.concat({
  '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
  '<meta name="viewport" content="width=device-width, initial-scale=1">',
  "<title>Lampyris: the paper's figures and tables</title>",
  "<style>\n" .. style .. "</style>\n</head>\n<body>",
  "<h1>The paper's figures and tables</h1>",
  "<p>Lee, Lee &amp; Ha, “Rendering Method of Light Environment Based on Modeling of Physical"
    .. " Characteristic”, J. IEEK 43-SP-6, 2006, as Lampyris " .. lampyris.version
    .. " makes them."
    .. (paper.is_tiny and " A tiny run: for tests, not for reading." or "") .. "</p>",
  "<nav>" .. table.concat(paper.map(paper.reports, link), "\n") .. "</nav>",
  "<h2>In numbers</h2>\n" .. summary(paper.reports),
  chapter("The paper", figures),
  chapter("Beyond the paper", studies),
  "</body>\n</html>\n",
}, "\n"))
print("index.html")
