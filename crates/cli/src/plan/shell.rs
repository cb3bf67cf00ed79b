//! Commands as text for a POSIX shell.

use std::ffi::OsStr;

use anyhow::Result;

use crate::failure::usage;

/// One line that a shell takes apart into `arguments` again.
pub fn line(arguments: &[String]) -> String {
    arguments.iter().map(|argument| quoted(argument)).collect::<Vec<_>>().join(" ")
}

/// An argument in quotes, where it needs them.
fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        return argument.into();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

/// An argument as text that can be printed.
///
/// # Errors
/// When it is no Unicode, or would break the line.
pub fn text(argument: &OsStr) -> Result<&str> {
    let text = argument.to_str().filter(|text| !text.contains(['\n', '\r', '\0']));
    text.ok_or_else(|| {
        usage(format!("{}: cannot be written in one line of Unicode", argument.to_string_lossy().escape_debug()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_shell_would_change_is_quoted() {
        let line = line(&["a-b/c.exr", "0..8", "my scene.obj", "it's", "$HOME", "", "*", "ä"].map(String::from));
        assert_eq!(line, r"a-b/c.exr 0..8 'my scene.obj' 'it'\''s' '$HOME' '' '*' 'ä'");
        assert!(text(OsStr::new("a\nb")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_shell_takes_the_line_apart_as_it_was() {
        let arguments = ["printf", "%s|", "a b", "it's", "$HOME `x`", "\"", "", "\\", "*"].map(String::from);
        let output = std::process::Command::new("sh").arg("-c").arg(line(&arguments)).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "a b|it's|$HOME `x`|\"||\\|*|");
    }
}
