//! Evaluates expressions in `${}`: Python arithmetic on numbers, texts, lists and maps, without access to files or data of the
//! computer, except YAML files that may be read. Operators, lowest precedence first:
//! ```text
//! x if c else y; or; and; not; == != < <= > >= in; + -; * / // %; - +; **; f(x), x[i], x[i:j], x.key, x.f(y); 1.5, 'text',
//! [x, y], name
//! ```

use std::rc::Rc;

use super::methods::{method, slice};
use super::operations::{binary, contains, function};
use super::tokens::tokens;
use super::value::{NameSource, XacroValue};

/// Largest length of an expression, bytes. It also bounds the recursion depth.
const MAX_EXPRESSION_BYTES: usize = 2000;
/// Largest depth of nested parentheses and powers.
const MAX_EXPRESSION_DEPTH: usize = 100;

/// Evaluates an expression. `names`: gives the values of names, and the content of YAML files.
pub(super) fn value(text: &str, names: &mut dyn NameSource) -> Result<XacroValue, String> {
    if text.len() > MAX_EXPRESSION_BYTES {
        return Err(format!("an expression of {} bytes: at most {MAX_EXPRESSION_BYTES} are read", text.len()));
    }
    let tokens = tokens(text)?;
    let mut reader = ExpressionParser { tokens: &tokens, at: 0, names, depth: 0, is_live: true };
    let value = reader.choice()?;
    match reader.peek() {
        None => Ok(value),
        Some(token) => Err(format!("`{token}` is not expected in `{}`", text.trim())),
    }
}

struct ExpressionParser<'a> {
    tokens: &'a [String],
    at: usize,
    names: &'a mut dyn NameSource,
    depth: usize,
    /// Whether the tokens are evaluated, or only parsed. The branch of a conditional that is not chosen is only parsed.
    is_live: bool,
}

impl ExpressionParser<'_> {
    fn peek(&self) -> Option<&str> {
        self.tokens.get(self.at).map(String::as_str)
    }

    fn take(&mut self, token: &str) -> bool {
        let is_it = self.peek() == Some(token);
        self.at += usize::from(is_it);
        is_it
    }

    fn expect(&mut self, token: &str) -> Result<(), String> {
        match self.take(token) {
            true => Ok(()),
            false => Err(format!(
                "`{token}` is missing before {}",
                self.peek().map_or("the end".into(), |t| format!("`{t}`"))
            )),
        }
    }

    /// Parses tokens without evaluating them.
    fn dead<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, String>) -> Result<T, String> {
        let was = std::mem::replace(&mut self.is_live, false);
        let found = read(self);
        self.is_live = was;
        found
    }

    fn binary(&self, operator: &str, left: &XacroValue, right: &XacroValue) -> Result<XacroValue, String> {
        if self.is_live { binary(operator, left, right) } else { Ok(XacroValue::None) }
    }

    fn choice(&mut self) -> Result<XacroValue, String> {
        self.depth += 1;
        if self.depth > MAX_EXPRESSION_DEPTH {
            return Err(format!("more than {MAX_EXPRESSION_DEPTH} parentheses stand in one another"));
        }
        let start = self.at;
        // In `x if c else y`, c comes after x. So x is first only parsed, and it is evaluated later if c holds.
        let first = self.dead(Self::either)?;
        let found = if self.take("if") {
            let condition = self.either()?;
            self.expect("else")?;
            if !self.is_live {
                self.choice()?;
                first
            } else if condition.holds() {
                self.dead(Self::choice)?;
                let end = std::mem::replace(&mut self.at, start);
                let found = self.either()?;
                self.at = end;
                found
            } else {
                self.choice()?
            }
        } else if self.is_live {
            self.at = start;
            self.either()?
        } else {
            first
        };
        self.depth -= 1;
        Ok(found)
    }

    fn either(&mut self) -> Result<XacroValue, String> {
        let mut left = self.both()?;
        while self.take("or") {
            let is_decided = left.holds();
            let right = if is_decided { self.dead(Self::both)? } else { self.both()? };
            left = if is_decided { left } else { right };
        }
        Ok(left)
    }

    fn both(&mut self) -> Result<XacroValue, String> {
        let mut left = self.negation()?;
        while self.take("and") {
            let goes_on = left.holds();
            let right = if goes_on { self.negation()? } else { self.dead(Self::negation)? };
            left = if goes_on { right } else { left };
        }
        Ok(left)
    }

    fn negation(&mut self) -> Result<XacroValue, String> {
        let mut turns = 0;
        while self.take("not") {
            turns += 1;
        }
        let value = self.comparison()?;
        Ok(if turns == 0 { value } else { XacroValue::Bool(value.holds() != (turns % 2 == 1)) })
    }

    fn comparison(&mut self) -> Result<XacroValue, String> {
        let left = self.sum()?;
        let Some(operator) = self.peek().map(str::to_string) else { return Ok(left) };
        // `not in` and `is not` have two tokens. `is` compares values here, and not identities as in Python.
        let is_not_in = operator == "not" && self.tokens.get(self.at + 1).is_some_and(|next| next == "in");
        if !["==", "!=", "<", "<=", ">", ">=", "in", "is"].contains(&operator.as_str()) && !is_not_in {
            return Ok(left);
        }
        self.at += 1 + usize::from(is_not_in);
        let is_not = operator == "is" && self.take("not");
        let right = self.sum()?;
        if !self.is_live {
            return Ok(XacroValue::None);
        }
        let equal = match (left.number(), right.number()) {
            (Some(a), Some(b)) => a == b,
            _ => left == right,
        };
        let found = match operator.as_str() {
            "==" => equal,
            "!=" => !equal,
            "is" => equal != is_not,
            "in" | "not" => contains(&right, &left)? != is_not_in,
            _ => {
                let order = match (left.number(), right.number(), &left, &right) {
                    (Some(a), Some(b), ..) => a.partial_cmp(&b),
                    (_, _, XacroValue::Text(a), XacroValue::Text(b)) => Some(a.cmp(b)),
                    _ => return Err(format!("{} and {} have no order", left.kind(), right.kind())),
                };
                order.is_some_and(|order| match operator.as_str() {
                    "<" => order.is_lt(),
                    "<=" => order.is_le(),
                    ">" => order.is_gt(),
                    _ => order.is_ge(),
                })
            }
        };
        Ok(XacroValue::Bool(found))
    }

    fn sum(&mut self) -> Result<XacroValue, String> {
        self.chain(&["+", "-"], Self::product)
    }

    fn product(&mut self) -> Result<XacroValue, String> {
        self.chain(&["*", "/", "//", "%"], Self::signed)
    }

    /// Terms with operators between them, applied from the left.
    fn chain(
        &mut self,
        operators: &[&str],
        term: fn(&mut Self) -> Result<XacroValue, String>,
    ) -> Result<XacroValue, String> {
        let mut left = term(self)?;
        while let Some(operator) = self.peek().filter(|t| operators.contains(t)).map(str::to_string) {
            self.at += 1;
            let right = term(self)?;
            left = self.binary(&operator, &left, &right)?;
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<XacroValue, String> {
        let mut turns = 0;
        while let Some(sign) = self.peek().filter(|t| ["+", "-"].contains(t)) {
            turns += usize::from(sign == "-");
            self.at += 1;
        }
        let value = self.power()?;
        if turns % 2 == 0 { Ok(value) } else { self.binary("-", &XacroValue::Int(0), &value) }
    }

    fn power(&mut self) -> Result<XacroValue, String> {
        let base = self.called()?;
        if !self.take("**") {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > MAX_EXPRESSION_DEPTH {
            return Err(format!("more than {MAX_EXPRESSION_DEPTH} powers stand in one another"));
        }
        let exponent = self.signed()?;
        self.depth -= 1;
        self.binary("**", &base, &exponent)
    }

    fn called(&mut self) -> Result<XacroValue, String> {
        let mut value = self.atom()?;
        // Each pass applies one suffix to the value: [i], [i:j], .key or .f(y).
        loop {
            let key = if self.take("[") {
                let key = if self.peek() == Some(":") { XacroValue::None } else { self.choice()? };
                if self.take(":") {
                    let end = if self.peek() == Some("]") { XacroValue::None } else { self.choice()? };
                    value = if self.is_live { slice(&value, &key, &end)? } else { XacroValue::None };
                    self.expect("]")?;
                    continue;
                }
                self.expect("]")?;
                key
            } else if self.take(".") {
                let key = self.peek().unwrap_or("").to_string();
                self.at += 1;
                if self.take("(") {
                    let arguments = self.arguments(")")?;
                    value = if self.is_live { method(&value, &key, &arguments)? } else { XacroValue::None };
                    continue;
                }
                XacroValue::Text(key)
            } else {
                return Ok(value);
            };
            if self.is_live {
                value = value.entry(&key).ok_or_else(|| format!("{} has no `{}`", value.kind(), key.text()))?;
            }
        }
    }

    fn atom(&mut self) -> Result<XacroValue, String> {
        let token = self.peek().ok_or("the expression ends too early")?.to_string();
        self.at += 1;
        let first = token.chars().next().unwrap_or(' ');
        match token.as_str() {
            "(" => {
                let value = self.choice()?;
                self.expect(")")?;
                return Ok(value);
            }
            "[" => return self.arguments("]").map(|items| XacroValue::List(Rc::new(items))),
            "True" | "true" => return Ok(XacroValue::Bool(true)),
            "False" | "false" => return Ok(XacroValue::Bool(false)),
            "None" => return Ok(XacroValue::None),
            _ => {}
        }
        if first == '\'' || first == '"' {
            return Ok(XacroValue::Text(token[1..].into()));
        }
        if first.is_ascii_digit() || first == '.' {
            let whole = token.parse().map(XacroValue::Int);
            return whole
                .or_else(|_| token.parse().map(XacroValue::Number))
                .map_err(|_| format!("`{token}` is no number"));
        }
        if !(first.is_alphabetic() || first == '_') {
            return Err(format!("`{token}` is not expected"));
        }
        // A function may be written with the name of its module, for example `math.sin`.
        let name = match token.as_str() {
            "xacro" | "math" | "python" if self.take(".") => {
                self.at += 1;
                self.tokens.get(self.at - 1).cloned().unwrap_or_default()
            }
            _ => token,
        };
        if self.take("(") {
            let arguments = self.arguments(")")?;
            return if self.is_live { function(&name, &arguments, self.names) } else { Ok(XacroValue::None) };
        }
        match name.as_str() {
            _ if !self.is_live => Ok(XacroValue::None),
            "pi" => self.names.value("pi").or(Ok(XacroValue::Number(std::f64::consts::PI))),
            name => self.names.value(name),
        }
    }

    fn arguments(&mut self, end: &str) -> Result<Vec<XacroValue>, String> {
        let mut found = Vec::new();
        while !self.take(end) {
            found.push(self.choice()?);
            if !self.take(",") {
                self.expect(end)?;
                break;
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct GivenNames;
    impl NameSource for GivenNames {
        fn value(&mut self, name: &str) -> Result<XacroValue, String> {
            match name {
                "a" => Ok(XacroValue::Int(3)),
                "x" => Ok(XacroValue::Number(0.5)),
                "name" => Ok(XacroValue::Text("arm".into())),
                "m" => {
                    let list = XacroValue::List(Rc::new(vec![XacroValue::Int(7), XacroValue::Int(8)]));
                    Ok(XacroValue::Map(Rc::new([("k".to_string(), list)].into())))
                }
                _ => Err(format!("`{name}` is not defined")),
            }
        }

        fn yaml(&mut self, file: &str) -> Result<XacroValue, String> {
            Ok(XacroValue::Text(file.into()))
        }

        fn argument(&mut self, name: &str) -> Result<XacroValue, String> {
            Err(format!("the argument `{name}` has no value"))
        }
    }
    /// Each expected text is the value as Python 3 prints it.
    #[test]
    fn expressions_are_those_of_python() {
        for (text, printed) in [
            ("1 + 2*3", "7"),
            ("-2**2", "-4"),
            ("2**-1", "0.5"),
            ("2**3**2", "512"),
            ("7/2", "3.5"),
            ("7//2", "3"),
            ("-7//2", "-4"),
            ("-7 % 3", "2"),
            ("1e-3*2", "0.002"),
            ("a*x", "1.5"),
            ("a - -x", "3.5"),
            ("cos(0) + radians(180)/pi", "2.0"),
            ("name + '_link'", "arm_link"),
            ("'a' if a > 2 else undefined", "a"),
            ("undefined if a < 2 else 1 if x else 2", "1"),
            ("not a == 3 or x < 1 and a", "3"),
            ("a in [1, 2, 3]", "True"),
            ("'r' in name and name != ''", "True"),
            ("m['k'][-1] + m.k[0]", "15"),
            ("min(3, 1.5, 2)", "1.5"),
            ("str(a) + \"b\"", "3b"),
            ("len(name)", "3"),
            ("xacro.load_yaml('f')", "f"),
            ("round(2.5)", "2"),
        ] {
            match value(text, &mut GivenNames) {
                Ok(found) => assert_eq!(found.text(), printed, "{text}"),
                Err(e) => panic!("{text}: {e}"),
            }
        }
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for (text, wanted) in [
            ("1 +", "ends too early"),
            ("(1", "`)` is missing"),
            ("1 2", "`2` is not expected"),
            ("b", "`b` is not defined"),
            ("1/0", "division by zero"),
            ("'a' * 3", "`*` of a text and a number"),
            ("open('/etc/passwd')", "the function `open`"),
            ("name.title()", "the method `title`"),
            ("m['z']", "a map has no `z`"),
            ("'a", "is not closed"),
        ] {
            let message = value(text, &mut GivenNames).unwrap_err();
            assert!(message.contains(wanted), "{text}: {message}");
        }
        assert!(value(&"(".repeat(500), &mut GivenNames).is_err());
        assert!(value(&"2**".repeat(500), &mut GivenNames).is_err());
    }
}
