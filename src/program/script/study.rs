//! `lampyris.study`.

use std::collections::BTreeMap;
use std::sync::Arc;

use mlua::{Function, Lua, MultiValue, Table, Value};

use super::fault;
use super::host;
use super::kinds::{Any, Callback, Choice, Count, Kind, List, Number, Numbers, Text, numbers};
use super::light::SEED;
use super::members::Functions;
use super::options::{self, Arguments, Range};
use super::record::{Record, options};
use super::sweep::source;
use crate::error::Error;
use crate::program::study::{
    self, Design, Distribution, Interval, MOST_DRAWS, Parameter, Study, StudyOutcome,
};

const DESIGNS: &[(&str, Design)] = &[
    ("sobol", Design::Sobol),
    ("latin hypercube", Design::LatinHypercube),
    ("grid", Design::Grid),
];

options! {
    /// Many runs with inputs that vary.
    struct StudyOptions {
        /// `name = {normal = {mean, sd}}`, `{uniform = {low, high}}` or `{a, b, …}`
        parameters: Value = Any { lua_type: "table<string, Spread|number[]>", expected: "a table of parameters by name" },
        /// draws; a grid has as many as fit evenly
        samples: usize = Count::new(1, MOST_DRAWS as u64).or(1000),
        /// how draws are spread
        design: Design = Choice(DESIGNS).or(Design::Sobol),
        /// of the draws
        seed: u64 = SEED,
        /// below the output folder; gets draws.csv and index.html
        output: String = Text("a folder below the output folder"),
        /// from parameters by name to results by name: numbers, or true and false
        run: Function = Callback {
            lua_type: "fun(parameters: table<string, number>): table<string, number|boolean>",
            expected: "a function of the parameters",
        },
    }
}

options! {
    /// How a parameter of a study varies: one of these.
    struct Spread {
        /// mean and standard deviation
        normal: Option<[f64; 2]> = PAIR.optional(""),
        /// lower and upper end
        uniform: Option<[f64; 2]> = PAIR.optional(""),
        /// each value alike
        list: Option<Vec<f64>> = values().optional(""),
    }
}

const PAIR: Numbers<2> = Numbers { range: Range::ANY, expected: "two numbers" };

fn values() -> List<Number> {
    numbers(Range::ANY)
}

pub(super) fn register(lua: &Lua, module: &Table) -> mlua::Result<()> {
    Functions::of_module(lua, module).add("study", 1, study)
}

fn study(lua: &Lua, mut arguments: Arguments) -> mlua::Result<Table> {
    let given: StudyOptions = arguments.record()?;
    let host = host::of(lua)?;
    host.note_seed("study", given.seed);
    let study = Study {
        parameters: parameters(&given.parameters)?,
        design: given.design,
        samples: given.samples,
        seed: given.seed,
        shard: host.settings.shard,
    };
    study.check()?;
    let folder = host.claim_folder("study", &given.output)?;
    let progress = host.progress(0);
    let begin = |made: usize, of: usize| progress.begin_draw(made + 1, of);
    let run = |cells: &[(String, f64)]| results(given.run.call(table_of(lua, cells)?)?);
    let made_from = source(&host, &mut Default::default())?;
    if host.settings.is_dry_run {
        let table = study.made(&folder, &made_from)?;
        let made = table.rows.len();
        let left = study.own_draws().count().saturating_sub(made);
        let folder = folder.display();
        host.say(&format!("{folder}: {left} draws would be made, {made} are there"));
        return answer(lua, study, StudyOutcome { table, made: 0, moved: None });
    }
    let done = study.run(&folder, &made_from, begin, run)?;
    if let Some(moved) = &done.moved {
        let moved = moved.display();
        host.warn(format!("study: draws of another study stood in the folder, now in {moved}"));
    }
    answer(lua, study, done)
}

fn parameters(value: &Value) -> mlua::Result<Vec<Parameter>> {
    const EXPECTED: &str = "a table of parameters by name";
    let Value::Table(table) = value else {
        return Err(options::wrong_type("study", "\"parameters\"", value, EXPECTED).into());
    };
    let mut parameters = BTreeMap::new();
    for pair in table.pairs::<Value, Value>() {
        let (name, spread) = pair?;
        let name = options::text("study: parameters", "name", &name)?;
        let distribution = distribution(&format!("study: parameter \"{name}\""), &spread)?;
        parameters.insert(name.clone(), Parameter { name, distribution });
    }
    Ok(parameters.into_values().collect())
}

fn distribution(object: &str, value: &Value) -> mlua::Result<Distribution> {
    if value.as_table().is_some_and(|table| table.raw_len() > 0) {
        return Ok(Distribution::List(values().read(object, "list", value)?));
    }
    let given = Spread::read(object, value.clone())?;
    match (given.normal, given.uniform, given.list) {
        (Some([mean, sd]), None, None) => Ok(Distribution::Normal { mean, sd }),
        (None, Some([low, high]), None) => Ok(Distribution::Uniform { low, high }),
        (None, None, Some(values)) => Ok(Distribution::List(values)),
        _ => {
            let problem = "expected one of normal = {mean, sd}, uniform = {low, high}, list = {…}";
            Err(Error::inconsistent(object, problem).into())
        }
    }
}

/// What the script's function returned, by name.
fn results(value: Value) -> mlua::Result<Vec<(String, f64)>> {
    const OBJECT: &str = "study: run";
    let Value::Table(table) = &value else {
        let expected = "a table of results by name";
        return Err(options::wrong_type(OBJECT, "its result", &value, expected).into());
    };
    let mut results = BTreeMap::new();
    for pair in table.pairs::<Value, Value>() {
        let (name, value) = pair?;
        let name = options::text(OBJECT, "name of a result", &name)?;
        let number = match value {
            Value::Boolean(holds) => f64::from(u8::from(holds)),
            value => options::number(OBJECT, &format!("\"{name}\""), &value, Range::ANY)?,
        };
        results.insert(name, number);
    }
    if results.is_empty() {
        return Err(Error::inconsistent(OBJECT, "returned no result").into());
    }
    Ok(results.into_iter().collect())
}

fn table_of(lua: &Lua, cells: &[(String, f64)]) -> mlua::Result<Table> {
    lua.create_table_from(cells.iter().map(|(name, value)| (name.as_str(), *value)))
}

/// `{ rows, mean, sd, percentile, sensitivity, probability }`.
fn answer(lua: &Lua, study: Study, done: StudyOutcome) -> mlua::Result<Table> {
    let answer = lua.create_table()?;
    let names = done.table.columns.get(study.parameters.len()..).unwrap_or_default().to_vec();
    let columns = |f: fn(&[f64]) -> f64| {
        let of = |name: &String| (name.clone(), f(&done.table.column(name).unwrap_or_default()));
        lua.create_table_from(names.iter().map(of))
    };
    answer.set("draws", done.table.rows.len())?;
    answer.set("made", done.made)?;
    answer.set("mean", columns(study::mean)?)?;
    answer.set("sd", columns(study::standard_deviation)?)?;
    let rows = lua.create_table()?;
    for (_, values) in &done.table.rows {
        let cells = done.table.columns.iter().map(String::as_str).zip(values.iter().copied());
        rows.push(lua.create_table_from(cells)?)?;
    }
    answer.set("probability", probability(lua, rows.clone())?)?;
    answer.set("rows", rows)?;
    let shared = Arc::new((study, done));
    let of = Arc::clone(&shared);
    let percentile = fault::function(lua, move |_, a| percentile(&of.1, a))?;
    answer.set("percentile", percentile)?;
    let of = Arc::clone(&shared);
    answer.set("sensitivity", fault::function(lua, move |lua, a| sensitivities(lua, &of, a))?)?;
    Ok(answer)
}

/// `study.percentile(name, percent)`: the value, the ends of its interval, and their confidence.
fn percentile(done: &StudyOutcome, arguments: MultiValue) -> mlua::Result<(f64, f64, f64, f64)> {
    let mut arguments = Arguments::new("study.percentile", arguments, 2)?;
    let values = column(done, "study.percentile", &arguments.text("name of a result")?)?;
    let percent = arguments.number("percent", Range::new(0.0, 100.0, "%"))?;
    let found = study::percentile_interval(&values, percent);
    let none = || Error::inconsistent("study.percentile", "there are no draws");
    let Interval { value, low, high, confidence } = found.ok_or_else(none)?;
    Ok((value, low, high, confidence))
}

/// `study.sensitivity(name)`: `{ first =, total = }` by parameter, and the share explained.
fn sensitivities(
    lua: &Lua,
    (study, done): &(Study, StudyOutcome),
    arguments: MultiValue,
) -> mlua::Result<(Table, f64)> {
    let name = Arguments::new("study.sensitivity", arguments, 1)?.text("name of a result")?;
    let values = column(done, "study.sensitivity", &name)?;
    let found = study.sensitivity(&done.table, &values)?;
    let by_parameter = lua.create_table()?;
    for (at, parameter) in study.parameters.iter().enumerate() {
        let shares = lua.create_table()?;
        shares.set("first", found.first[at])?;
        shares.set("total", found.total[at])?;
        by_parameter.set(parameter.name.as_str(), shares)?;
    }
    Ok((by_parameter, found.explained))
}

fn column(done: &StudyOutcome, object: &str, name: &str) -> mlua::Result<Vec<f64>> {
    let columns = &done.table.columns;
    let unknown = || {
        let names: Vec<&str> = columns.iter().map(String::as_str).collect();
        let found = format!("\"{name}\"{}", fault::nearest(name, &names));
        Error::out_of_range(object, "name", found, columns.join(", "))
    };
    Ok(done.table.column(name).ok_or_else(unknown)?)
}

/// `study.probability(predicate)`: the share of draws that pass, and its 95 % confidence interval.
fn probability(lua: &Lua, rows: Table) -> mlua::Result<Function> {
    fault::function(lua, move |_, arguments| {
        const OBJECT: &str = "study.probability";
        let predicate = Arguments::new(OBJECT, arguments, 1)?.value();
        let expected = "a function of a draw's parameters and results";
        let Value::Function(passes) = &predicate else {
            return Err(options::wrong_type(OBJECT, "argument 1", &predicate, expected).into());
        };
        let draws = rows.raw_len();
        let mut passed = 0;
        for row in rows.sequence_values::<Table>() {
            passed += usize::from(passes.call::<bool>(row?)?);
        }
        let none = || Error::inconsistent(OBJECT, "there are no draws");
        let Interval { value, low, high, .. } =
            study::probability(passed, draws).ok_or_else(none)?;
        Ok((value, low, high))
    })
}
