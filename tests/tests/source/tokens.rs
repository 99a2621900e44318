//! Source text as tokens: what the compiler reads, without comments and with texts as one token each.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The tokens of a file.
pub fn tokens(text: &str, file: &str) -> TokenStream {
    text.parse().unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Without the items that are there for tests only.
pub fn without_tests(stream: TokenStream) -> TokenStream {
    let mut kept = Vec::new();
    let mut rest = stream.into_iter().peekable();
    while let Some(token) = rest.next() {
        let is_test = match (&token, rest.peek()) {
            (TokenTree::Punct(p), Some(TokenTree::Group(g))) if p.as_char() == '#' => {
                g.stream().to_string().replace(' ', "") == "cfg(test)"
            }
            _ => false,
        };
        if is_test {
            // The item ends with its body or with a semicolon.
            let ends = |t: &TokenTree| match t {
                TokenTree::Group(g) => g.delimiter() == Delimiter::Brace,
                TokenTree::Punct(p) => p.as_char() == ';',
                _ => false,
            };
            rest.by_ref().find(ends);
            continue;
        }
        kept.push(match token {
            TokenTree::Group(g) => TokenTree::Group(proc_macro2::Group::new(g.delimiter(), without_tests(g.stream()))),
            other => other,
        });
    }
    kept.into_iter().collect()
}

/// What is left for later, as it stands in the code: `todo!`, `unimplemented!`, `#[ignore]`,
/// `allow(dead_code)`.
pub fn left_for_later(stream: TokenStream) -> Vec<&'static str> {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let mut found = Vec::new();
    for (k, token) in tokens.iter().enumerate() {
        let next = tokens.get(k + 1);
        let is_called = matches!(next, Some(TokenTree::Punct(p)) if p.as_char() == '!');
        let word = token.to_string();
        match (word.as_str(), next) {
            ("todo", _) if is_called => found.push("todo!"),
            ("unimplemented", _) if is_called => found.push("unimplemented!"),
            ("#", Some(TokenTree::Group(g))) if begins_with(g.stream(), "ignore") => found.push("#[ignore]"),
            ("allow", Some(TokenTree::Group(g))) if holds(g.stream(), "dead_code") => found.push("allow(dead_code)"),
            _ => {}
        }
        if let TokenTree::Group(g) = token {
            found.extend(left_for_later(g.stream()));
        }
    }
    found
}

fn begins_with(stream: TokenStream, word: &str) -> bool {
    stream.into_iter().next().is_some_and(|t| t.to_string() == word)
}

fn holds(stream: TokenStream, word: &str) -> bool {
    stream.into_iter().any(|t| matches!(&t, TokenTree::Ident(i) if i == word))
}

#[test]
fn texts_and_comments_leave_nothing_for_later() {
    let harmless = r##"// todo!()
        /// `#[ignore]`
        fn f() -> &'static str { "allow(dead_code) todo!()" }"##;
    assert!(left_for_later(tokens(harmless, "harmless")).is_empty());
    let guilty = r##"#[allow(unused, dead_code)] // "
        fn f(s: &str) { if s == "a" { todo!("b") } }
        #[ignore = "slow"] fn g() { unimplemented!() }"##;
    let found = left_for_later(tokens(guilty, "guilty"));
    assert_eq!(found, ["allow(dead_code)", "todo!", "#[ignore]", "unimplemented!"]);
}
