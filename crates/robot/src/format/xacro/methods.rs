//! Methods of texts, lists and maps in xacro expressions, and slices, with the results of Python.

use std::rc::Rc;

use super::operations::MAX_LIST_ITEMS;
use super::value::XacroValue::{self, Bool, Int, List, Map, Text};

/// Longest text that a method takes or makes, bytes. A file can call methods 500 000 times, so this bounds their work.
const MAX_METHOD_BYTES: usize = 10_000;

/// Calls the method `name` of a value. Fails if Python has no such method, or if this program does not support it.
pub(super) fn method(value: &XacroValue, name: &str, arguments: &[XacroValue]) -> Result<XacroValue, String> {
    let of = value.kind();
    let is_long = |value: &XacroValue| matches!(value, Text(text) if text.len() > MAX_METHOD_BYTES);
    if is_long(value) || arguments.iter().any(is_long) {
        return Err(format!("`{name}` of a text of more than {MAX_METHOD_BYTES} bytes"));
    }
    let found = match value {
        Text(text) => of_text(text, name, arguments)?,
        _ => of_others(value, name, arguments),
    };
    let found = found.ok_or_else(|| format!("the method `{name}` of {of} is not known here with these arguments"))?;
    let is_large = matches!(&found, List(items) if items.len() > MAX_LIST_ITEMS);
    if is_large || is_long(&found) { Err(format!("`{name}` makes too long a list or text")) } else { Ok(found) }
}

/// A method of a text; `None` if this program does not support it.
fn of_text(text: &str, name: &str, arguments: &[XacroValue]) -> Result<Option<XacroValue>, String> {
    let word = |text: &str| Text(text.into());
    let among = |set: &XacroValue| {
        let set = if let Text(set) = set { set.clone() } else { String::new() };
        move |c: char| if set.is_empty() { c.is_whitespace() } else { set.contains(c) }
    };
    // Only these methods, with these counts and types of arguments, are supported.
    Ok(Some(match (name, arguments) {
        ("split", []) => list(text.split_whitespace().map(word)),
        ("split", [Text(by)]) if !by.is_empty() => list(text.split(by.as_str()).map(word)),
        ("split", [Text(by), Int(most @ 0..)]) if !by.is_empty() => {
            list(text.splitn(*most as usize + 1, by.as_str()).map(word))
        }
        ("strip" | "lstrip" | "rstrip", [] | [Text(_)]) => {
            let among = among(arguments.first().unwrap_or(&XacroValue::None));
            let text = if name == "rstrip" { text } else { text.trim_start_matches(&among) };
            word(if name == "lstrip" { text } else { text.trim_end_matches(&among) })
        }
        ("lower", []) => Text(text.to_lowercase()),
        ("upper", []) => Text(text.to_uppercase()),
        ("replace", [Text(old), Text(new)]) => {
            // The length is checked first, because the result can be much longer than the text and the arguments.
            if text.matches(old.as_str()).count() * new.len() > MAX_METHOD_BYTES {
                return Err("`replace` makes too long a text".into());
            }
            Text(text.replace(old.as_str(), new))
        }
        ("startswith", [Text(start)]) => Bool(text.starts_with(start.as_str())),
        ("endswith", [Text(end)]) => Bool(text.ends_with(end.as_str())),
        ("find", [Text(part)]) => Int(text.find(part.as_str()).map_or(-1, |at| text[..at].chars().count() as i64)),
        ("count", [Text(part)]) => Int(text.matches(part.as_str()).count() as i64),
        ("isdigit", []) => Bool(!text.is_empty() && text.chars().all(|c| c.is_ascii_digit())),
        ("join", [List(items)]) => {
            let texts: Option<Vec<&str>> =
                items.iter().map(|item| if let Text(item) = item { Some(item.as_str()) } else { None }).collect();
            let texts = texts.ok_or("`join` of a list with entries that are no texts")?;
            if texts.iter().map(|item| item.len() + text.len()).sum::<usize>() > MAX_METHOD_BYTES {
                return Err("`join` makes too long a text".into());
            }
            Text(texts.join(text))
        }
        _ => return Ok(None),
    }))
}

/// A method of a list or a map; `None` if this program does not support it.
fn of_others(value: &XacroValue, name: &str, arguments: &[XacroValue]) -> Option<XacroValue> {
    Some(match (value, name, arguments) {
        (List(items), "count", [one]) => Int(items.iter().filter(|item| *item == one).count() as i64),
        (List(items), "index", [one]) => Int(items.iter().position(|item| item == one)? as i64),
        (Map(entries), "keys", []) => list(entries.keys().map(|key| Text(key.clone()))),
        (Map(entries), "values", []) => list(entries.values().cloned()),
        (Map(entries), "items", []) => {
            list(entries.iter().map(|(key, value)| list([Text(key.clone()), value.clone()].into_iter())))
        }
        (Map(_), "get", [key]) => value.entry(key).unwrap_or(XacroValue::None),
        (Map(_), "get", [key, other]) => value.entry(key).unwrap_or(other.clone()),
        _ => return None,
    })
}

fn list(items: impl Iterator<Item = XacroValue>) -> XacroValue {
    List(Rc::new(items.collect()))
}

/// The part `value[from:to]` of a text or a list. A missing end is [`XacroValue::None`]. A negative index counts from the end.
///
/// Fails if the value has no parts, or if an index is no whole number.
pub(super) fn slice(value: &XacroValue, from: &XacroValue, to: &XacroValue) -> Result<XacroValue, String> {
    let place = |index: &XacroValue, length: usize, missing: usize| match index {
        XacroValue::None => Ok(missing),
        Int(i) if *i < 0 => Ok(length.saturating_sub(i.unsigned_abs() as usize)),
        Int(i) => Ok((*i as usize).min(length)),
        other => Err(format!("{} is no index", other.kind())),
    };
    let ends = |length: usize| -> Result<(usize, usize), String> {
        let from = place(from, length, 0)?;
        Ok((from, place(to, length, length)?.max(from)))
    };
    match value {
        Text(text) => {
            let (from, to) = ends(text.chars().count())?;
            Ok(Text(text.chars().skip(from).take(to - from).collect()))
        }
        List(items) => ends(items.len()).map(|(from, to)| list(items[from..to].iter().cloned())),
        other => Err(format!("{} has no parts", other.kind())),
    }
}

#[cfg(test)]
mod tests {
    use super::super::expression::value;
    use super::super::value::{NameSource, XacroValue};
    use super::MAX_METHOD_BYTES;

    struct Long;

    impl NameSource for Long {
        fn value(&mut self, _: &str) -> Result<XacroValue, String> {
            Ok(XacroValue::Text(" ".repeat(MAX_METHOD_BYTES)))
        }

        fn yaml(&mut self, _: &str) -> Result<XacroValue, String> {
            let list = XacroValue::List(std::rc::Rc::new(vec![XacroValue::Int(7), XacroValue::Int(8)]));
            Ok(XacroValue::Map(std::rc::Rc::new([("k".to_string(), list)].into())))
        }

        fn argument(&mut self, name: &str) -> Result<XacroValue, String> {
            Ok(XacroValue::Text(format!("{name} of the user")))
        }
    }

    /// The expected values have the form in which Python 3 prints them with `str`; texts of a list are without their quotes.
    #[test]
    fn methods_are_those_of_python() {
        for (text, printed) in [
            ("'0.1 0 0.2'.split(' ')[2]", "0.2"),
            ("' a  b '.split()", "[a, b]"),
            ("' a  b '.split(' ')", "[, a, , b, ]"),
            ("'a_b_c'.split('_', 1)", "[a, b_c]"),
            ("'  x '.strip() + 'xxay'.strip('xy') + 'xa'.lstrip('x') + 'ax '.rstrip()", "xaaax"),
            ("'Ab'.lower() + 'Ab'.upper()", "abAB"),
            ("'a-b-c'.replace('-', '')", "abc"),
            ("'left_arm'.startswith('left') and 'left_arm'.endswith('arm')", "True"),
            ("'left'.find('x') + 'left'.find('f')", "1"),
            ("'aXbXc'.count('X')", "2"),
            ("', '.join(['a', 'b'])", "a, b"),
            ("'abcdef'[1:3] + 'abcdef'[-2:] + 'abcdef'[:1] + 'abc'[5:2] + 'abc'[-1]", "bcefac"),
            ("[1, 2, 3][1:]", "[2, 3]"),
            ("load_yaml('f').get('k')[0] + load_yaml('f').get('z', 1)", "8"),
            ("list(load_yaml('f').keys())[0]", "k"),
            ("xacro.arg('m')", "m of the user"),
            ("'12'.isdigit() and not ''.isdigit()", "True"),
            ("1 if True else ''.undefined()", "1"),
        ] {
            match value(text, &mut Long) {
                Ok(found) => assert_eq!(found.text(), printed, "{text}"),
                Err(e) => panic!("{text}: {e}"),
            }
        }
    }

    #[test]
    fn what_is_too_long_or_unknown_is_refused() {
        for (text, wanted) in [
            ("'a'.encode()", "the method `encode` of a text is not known"),
            ("'a'.split('')", "the method `split`"),
            ("(1).split()", "the method `split` of a number"),
            ("'abc'[9]", "a text has no `9`"),
            ("'abc'['a':]", "a text is no index"),
            ("(1)[0:1]", "a number has no parts"),
            ("','.join([1])", "no texts"),
            ("(x + x).strip()", "a text of more than"),
            ("x.replace(' ', '12')", "too long"),
            ("x.join(['a', 'b'])", "too long"),
            ("x.split(' ')", "too long"),
        ] {
            let message = value(text, &mut Long).unwrap_err();
            assert!(message.contains(wanted), "{text}: {message}");
        }
    }
}
