//! `index.html` of a study: each result's spread, what causes it, and its scatter over parameters.

use std::fmt::Write;
use std::path::Path;

use super::run::Study;
use super::summary::{mean, percentile_interval, standard_deviation};
use super::table::DrawTable;
use crate::error::Result;
use crate::output;
use crate::program::figure::{Chart, ChartAxis, Figure, Panel, Series, figure_svg};

const STYLE: &str = "body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;max-width:1100px;\
    margin:2em auto;padding:0 1.5em}td,th{padding:.15em 1em .15em 0;text-align:left}\
    td{font-variant-numeric:tabular-nums}.bar{background:#ccc;height:1em}\
    .bar div{background:#0072b2;height:1em}svg{max-width:100%;height:auto}";

/// More points than this only darken a scatter plot.
const MOST_POINTS: usize = 2000;

/// The same table gives the same bytes.
///
/// Errors: [`crate::Error::Io`].
pub(super) fn write(folder: &Path, study: &Study, table: &DrawTable) -> Result<()> {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Study</title>\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'; img-src data:\"><style>{STYLE}</style></head><body>\n\
         <h1>Study of {} draws</h1>\n",
        table.rows.len()
    );
    for result in &table.columns[study.parameters.len().min(table.columns.len())..] {
        page += &section(study, table, result)?;
    }
    output::write_text(&folder.join("index.html"), &(page + "</body></html>\n"))
}

/// Names are letters, digits, `_` and `.`: nothing to escape.
fn section(study: &Study, table: &DrawTable, result: &str) -> Result<String> {
    let values = table.column(result).unwrap_or_default();
    let mut html = format!("<h2>{result}</h2>\n<table>");
    for (name, value) in [("mean", mean(&values)), ("sd", standard_deviation(&values))] {
        let _ = write!(html, "<tr><th>{name}</th><td>{value:.6}</td><td></td></tr>");
    }
    for percent in [2.5, 16.0, 50.0, 84.0, 97.5] {
        if let Some(found) = percentile_interval(&values, percent) {
            let _ = write!(
                html,
                "<tr><th>{percent} %</th><td>{:.6}</td><td>{:.1} % confidence: {:.6} to {:.6}</td></tr>",
                found.value,
                100.0 * found.confidence,
                found.low,
                found.high
            );
        }
    }
    html += "</table>\n";
    html += &tornado(study, table, &values);
    Ok(html + &figure_svg(&scatter(study, table, result, &values))? + "\n")
}

/// Parameters by their share of the variance, the largest on top.
fn tornado(study: &Study, table: &DrawTable, values: &[f64]) -> String {
    let found = match study.sensitivity(table, values) {
        Ok(found) => found,
        Err(error) => return format!("<p>No sensitivities: {error}</p>\n"),
    };
    let mut order: Vec<usize> = (0..study.parameters.len()).collect();
    order.sort_by(|&a, &b| found.total[b].total_cmp(&found.total[a]));
    let mut html = format!(
        "<h3>What the variance comes from</h3>\n<p>{:.1} % of it is explained. Blue: the parameter \
         alone; gray: with its interactions.</p>\n<table>",
        100.0 * found.explained
    );
    for parameter in order {
        let [first, total] = [found.first[parameter], found.total[parameter]].map(|s| 100.0 * s);
        let inner = if total > 0.0 { 100.0 * first / total } else { 0.0 };
        let _ = write!(
            html,
            "<tr><th>{}</th><td>{first:.1} %</td><td>{total:.1} %</td><td style=\"width:60%\">\
             <div class=\"bar\" style=\"width:{total:.1}%\"><div style=\"width:{inner:.1}%\"></div>\
             </div></td></tr>",
            study.parameters[parameter].name
        );
    }
    html + "</table>\n"
}

fn scatter(study: &Study, table: &DrawTable, result: &str, values: &[f64]) -> Figure {
    let panel = |name: &str| {
        let x = table.column(name).unwrap_or_default();
        let points = x.iter().zip(values).take(MOST_POINTS).map(|(&x, &y)| [x, y]).collect();
        Panel::Chart(Chart {
            title: String::new(),
            x: ChartAxis::linear(name),
            y: ChartAxis::linear(result),
            series: vec![Series::scatter("", points)],
        })
    };
    let panels: Vec<Panel> = study.parameters.iter().map(|p| panel(&p.name)).collect();
    let columns = panels.len().min(3);
    let rows = panels.len().div_ceil(columns);
    Figure {
        width: 360 * columns as u32,
        height: 300 * rows as u32,
        title: String::new(),
        panels,
        columns,
    }
}
