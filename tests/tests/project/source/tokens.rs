//! Reads source text as tokens, as the compiler does: without comments, each string as one token.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

pub(crate) fn tokens(text: &str, file: &str) -> TokenStream {
    text.parse().unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// The tokens without items that are only for tests.
pub(crate) fn without_tests(stream: TokenStream) -> TokenStream {
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
            // An item ends with its body or with a semicolon.
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

/// Whether an attribute allows this lint, as `#[allow(unused, dead_code)]` allows `dead_code`.
pub(crate) fn allows(stream: TokenStream, lint: &str) -> bool {
    let tokens: Vec<TokenTree> = stream.into_iter().collect();
    let is_list = |pair: &[TokenTree]| match pair {
        [TokenTree::Ident(i), TokenTree::Group(g)] => i == "allow" && says(g.stream(), lint),
        _ => false,
    };
    let inside = |token: &TokenTree| matches!(token, TokenTree::Group(g) if allows(g.stream(), lint));
    tokens.windows(2).any(is_list) || tokens.iter().any(inside)
}

/// Whether a word occurs in the code, including bodies and macros, but not in comments and strings.
pub(crate) fn says(stream: TokenStream, word: &str) -> bool {
    stream.into_iter().any(|token| match token {
        TokenTree::Ident(i) => i == word,
        TokenTree::Group(g) => says(g.stream(), word),
        _ => false,
    })
}

#[test]
fn a_word_is_found_in_code_alone() {
    let says = |text: &str| says(tokens(text, "text"), "unsafe");
    assert!(says("fn f() { let x = unsafe { g() }; }") && says("macro_rules! m { () => { unsafe fn f() {} } }"));
    assert!(!says("//! unsafe\n/// unsafe\n#![allow(unsafe_code)] fn f() -> &'static str { \"unsafe\" } // unsafe"));
}

#[test]
fn an_attribute_is_found_in_code_alone() {
    let allows = |text: &str| allows(tokens(text, "text"), "dead_code");
    assert!(allows("#[allow(unused, dead_code)] // \"\nfn f() {}") && allows("mod a { #![allow(dead_code)] }"));
    assert!(!allows("/// allow(dead_code)\n#[allow(unused)] fn f() -> &'static str { \"allow(dead_code)\" }"));
}
