//! As much of Rust's grammar as it takes to find the paths of a file.

/// The tokens of a source that are neither comments nor literals, without what `#[cfg(test)]` switches off; and the names
/// of modules in files of their own that are only there for tests.
pub fn tokens_without_tests(source: &str) -> (Vec<String>, Vec<String>) {
    let tokens = tokens(source);
    let mut kept = Vec::new();
    let mut test_modules = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        if tokens[i] == "#" && tokens.get(i + 1).is_some_and(|t| t == "[") {
            let end = after_group(&tokens, i + 1);
            let attribute = &tokens[i..end];
            let has = |word: &str| attribute.iter().any(|t| t == word);
            if attribute[2] == "cfg" && has("test") && !has("not") {
                let item_end = after_item(&tokens, end);
                let item = &tokens[end..item_end];
                if let Some(at) = item.iter().position(|t| t == "mod").filter(|_| item.last().is_some_and(|t| t == ";"))
                {
                    test_modules.push(item[at + 1].clone());
                }
                i = item_end;
                continue;
            }
        }
        kept.push(tokens[i].clone());
        i += 1;
    }
    (kept, test_modules)
}

/// The paths from the crate's root that a file names, `crate` left out: those that begin with `crate`, and those that begin
/// with `super`, `self` or a module that the file declares, as seen from `module`. A glob ends in `*`.
pub fn imports(tokens: &[String], module: &[String]) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut module = module.to_vec();
    let declared = declared_modules(tokens);
    // For each open brace, whether it is that of a module written in place.
    let mut scopes = Vec::new();
    for i in 0..tokens.len() {
        let next = tokens.get(i + 1).map_or("", String::as_str);
        match tokens[i].as_str() {
            "{" if i > 1 && tokens[i - 2] == "mod" => {
                scopes.push(true);
                module.push(tokens[i - 1].clone());
            }
            "{" => scopes.push(false),
            "}" if scopes.pop() == Some(true) => drop(module.pop()),
            _ => {}
        }
        let first_of_path = i == 0 || tokens[i - 1] != "::";
        let base = match tokens[i].as_str() {
            "crate" if next == "as" => {
                found.push(vec!["*".to_string()]);
                continue;
            }
            _ if next != "::" || !first_of_path => continue,
            // The reach of a `pub(in ...)`.
            "crate" if i > 1 && tokens[i - 2..i] == ["(", "in"] => continue,
            "crate" => Vec::new(),
            "super" => module[..module.len().saturating_sub(1)].to_vec(),
            "self" => module.clone(),
            child if declared.contains(&child) => [module.as_slice(), &[child.to_string()]].concat(),
            _ => continue,
        };
        tree(tokens, i + 2, base, &mut found);
    }
    found.retain(|path| !path.is_empty());
    found
}

/// The paths from the crate's root that a file re-exports.
pub fn re_exported(tokens: &[String], module: &[String]) -> Vec<Vec<String>> {
    let declared = declared_modules(tokens);
    let mut found = Vec::new();
    for (i, _) in tokens.iter().enumerate().filter(|(_, token)| *token == "pub") {
        let reach = tokens.get(i + 1).is_some_and(|t| t == "(");
        let at = if reach { after_group(tokens, i + 1) } else { i + 1 };
        let Some([is_use, first]) = tokens.get(at..at + 2) else { continue };
        let (base, skipped) = match first.as_str() {
            _ if is_use != "use" => continue,
            "crate" => (Vec::new(), 2),
            "super" | "self" => (module.to_vec(), 0),
            child if declared.contains(&child) => (module.to_vec(), 0),
            _ => continue,
        };
        tree(tokens, at + 1 + skipped, base, &mut found);
    }
    found
}

/// The modules in files of their own that a file declares.
fn declared_modules(tokens: &[String]) -> Vec<&str> {
    let declares = |w: &&[String]| w[0] == "mod" && w[2] == ";";
    tokens.windows(3).filter(declares).map(|w| w[1].as_str()).collect()
}

/// Parses the use tree at `i` into full paths; the position after it.
fn tree(tokens: &[String], mut i: usize, mut path: Vec<String>, found: &mut Vec<Vec<String>>) -> usize {
    loop {
        match tokens.get(i).map(String::as_str) {
            Some("{") => {
                i += 1;
                while tokens.get(i).is_some_and(|t| t != "}") {
                    i = match tokens[i].as_str() {
                        "," => i + 1,
                        "as" => i + 2,
                        _ => tree(tokens, i, path.clone(), found),
                    };
                }
                return i + 1;
            }
            Some("super") => drop(path.pop()),
            Some("self") => {}
            Some(word) if word == "*" || is_identifier(word) => path.push(word.to_string()),
            // A turbofish, or the end of the file.
            _ => {
                found.push(path);
                return i + 1;
            }
        }
        i += 1;
        if tokens.get(i).is_none_or(|t| t != "::") {
            found.push(path);
            return i;
        }
        i += 1;
    }
}

fn is_identifier(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The position after the bracket that closes the one at `open`.
fn after_group(tokens: &[String], open: usize) -> usize {
    let mut depth = 0usize;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth -= 1;
                if depth == 0 {
                    return i + 1;
                }
            }
            _ => {}
        }
    }
    tokens.len()
}

/// The position after the item at `start`, its further attributes included.
fn after_item(tokens: &[String], start: usize) -> usize {
    let mut i = start;
    while tokens.get(i).is_some_and(|t| t == "#") {
        i = after_group(tokens, i + 1);
    }
    let is_use = tokens[i..].iter().take_while(|t| *t != ";" && *t != "{").any(|t| t == "use");
    while i < tokens.len() {
        match tokens[i].as_str() {
            ";" => return i + 1,
            "{" if !is_use => return after_group(tokens, i),
            "(" | "[" | "{" => i = after_group(tokens, i),
            _ => i += 1,
        }
    }
    i
}

/// Identifiers, `::` and single marks; comments, lifetimes, numbers and the insides of literals are left out.
fn tokens(source: &str) -> Vec<String> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let find = |from: usize, what: &str| {
        let what: Vec<char> = what.chars().collect();
        (from..chars.len()).find(|&i| chars[i..].starts_with(&what)).map_or(chars.len(), |i| i + what.len())
    };
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let c = chars[i];
        if c == '/' && at(i + 1) == '/' {
            i = find(i, "\n");
        } else if c == '/' && at(i + 1) == '*' {
            let mut depth = 1;
            i += 2;
            while depth > 0 && i < chars.len() {
                let step = match (at(i), at(i + 1)) {
                    ('/', '*') => 1,
                    ('*', '/') => -1,
                    _ => 0,
                };
                depth += step;
                i += if step == 0 { 1 } else { 2 };
            }
        } else if c == '"' {
            i += 1;
            while i < chars.len() && chars[i] != '"' {
                i += if chars[i] == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if c == '\'' {
            // A character literal closes after one character or an escape; otherwise it is a lifetime.
            i = if at(i + 1) == '\\' {
                find(i + 3, "'")
            } else if at(i + 2) == '\'' {
                i + 3
            } else {
                i + 1
            };
        } else if c.is_alphanumeric() || c == '_' {
            let start = i;
            while at(i).is_alphanumeric() || at(i) == '_' {
                i += 1;
            }
            let word: String = chars[start..i].iter().collect();
            let hashes = chars[i..].iter().take_while(|&&h| h == '#').count();
            if matches!(word.as_str(), "r" | "br" | "cr") && at(i + hashes) == '"' {
                i = find(i + hashes + 1, &format!("\"{}", "#".repeat(hashes)));
            } else if is_identifier(&word) {
                tokens.push(word);
            }
        } else if c == ':' && at(i + 1) == ':' {
            tokens.push("::".to_string());
            i += 2;
        } else {
            if !c.is_whitespace() {
                tokens.push(c.to_string());
            }
            i += 1;
        }
    }
    tokens
}
