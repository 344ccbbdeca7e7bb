//! Lua values as people read them: what is in a table.

use mlua::{Table, Value};

/// Entries of a table, and tables in tables, that are shown.
const MOST_ENTRIES: usize = 50;
const DEEPEST: usize = 4;

/// A table by its entries; anything else as `tostring` has it.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Table(table) => shown_table(table, 0),
        other => other.to_string().unwrap_or_else(|_| other.type_name().to_owned()),
    }
}

/// The list's part first, then names in order.
fn shown_table(table: &Table, depth: usize) -> String {
    let says_itself =
        table.metatable().is_some_and(|meta| meta.contains_key("__tostring").unwrap_or(false));
    if says_itself {
        return Value::Table(table.clone()).to_string().unwrap_or_else(|_| "table".to_owned());
    }
    if depth == DEEPEST {
        return "{…}".to_owned();
    }
    let length = table.raw_len();
    let mut list = Vec::new();
    let mut named = Vec::new();
    for (key, value) in table.pairs::<Value, Value>().flatten() {
        let value = inner(&value, depth + 1);
        match key {
            Value::Integer(at) if at >= 1 && at as usize <= length => list.push((at, value)),
            Value::String(name) => named.push(format!("{} = {value}", name.to_string_lossy())),
            key => named.push(format!("[{}] = {value}", inner(&key, depth + 1))),
        }
    }
    list.sort();
    named.sort();
    let mut entries: Vec<String> = list.into_iter().map(|(_, value)| value).chain(named).collect();
    if entries.len() > MOST_ENTRIES {
        let more = entries.len() - MOST_ENTRIES;
        entries.truncate(MOST_ENTRIES);
        entries.push(format!("… {more} more"));
    }
    format!("{{{}}}", entries.join(", "))
}

fn inner(value: &Value, depth: usize) -> String {
    match value {
        Value::String(text) => format!("{:?}", text.to_string_lossy()),
        Value::Table(table) => shown_table(table, depth),
        Value::Function(_) => "function".to_owned(),
        other => shown(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_shown_by_their_entries() {
        let lua = mlua::Lua::new();
        let text = |code: &str| shown(&lua.load(code).eval::<Value>().unwrap());
        let expected = "{1, {2.5}, a = \"b\", f = function, [true] = false}";
        let same = |shown: &str| {
            let mut parts: Vec<&str> = shown.trim_matches(['{', '}']).split(", ").collect();
            parts.sort_unstable();
            parts.join(", ")
        };
        let found = text("return { 1, { 2.5 }, a = 'b', [true] = false, f = print }");
        assert_eq!(same(&found), same(expected));
        assert_eq!(text("return 'a'"), "a");
        assert_eq!(text("local t = {} t.t = t return t"), "{t = {t = {t = {t = {…}}}}}");
        let named = "return setmetatable({}, { __tostring = function() return 'mine' end })";
        assert_eq!(text(named), "mine");
        let many = text("local t = {} for i = 1, 60 do t[i] = i end return t");
        assert!(many.ends_with("50, … 10 more}"), "{many}");
    }
}
