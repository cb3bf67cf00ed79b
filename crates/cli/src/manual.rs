//! What shells and `man` want to know of the command line, made from the same structs as `--help`.

use anyhow::{Context, Result};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::args::{CompletionsArgs, ManArgs, command};
use crate::failure::{Verdict, usage};
use crate::stdout::print_line;

/// Prints the completions of a shell.
pub fn completions(args: &CompletionsArgs) -> Result<Verdict> {
    print_line(completions_of(args.shell)?.trim_end())?;
    Ok(Verdict::Done)
}

fn completions_of(shell: Shell) -> Result<String> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command(), "tamis", &mut script);
    Ok(String::from_utf8(script)?)
}

/// Prints the manual page of the program or of one of its commands.
pub fn man(args: &ManArgs) -> Result<Verdict> {
    print_line(page(args.command.as_deref())?.trim_end())?;
    Ok(Verdict::Done)
}

/// The page in roff.
fn page(of: Option<&str>) -> Result<String> {
    let mut whole = command();
    whole.build();
    let shown = match of {
        None => whole,
        Some(name) => {
            let found = whole.find_subcommand(name).cloned();
            found.ok_or_else(|| usage(format!("there is no command '{name}'; tamis --help lists them")))?
        }
    };
    let mut roff = Vec::new();
    Man::new(shown)
        .source(concat!("tamis ", env!("CARGO_PKG_VERSION")))
        .render(&mut roff)
        .context("cannot make the page")?;
    Ok(String::from_utf8(roff)?)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;

    #[test]
    fn every_shell_completes_every_command_and_setting() {
        for shell in Shell::value_variants() {
            let script = completions_of(*shell).unwrap();
            for word in ["denoise", "experiment", "completions", "split-quantile"] {
                assert!(script.contains(word), "{shell}: {word}");
            }
        }
    }

    #[test]
    fn pages_tell_of_commands_and_flags() {
        assert!(page(None).unwrap().contains("tamis\\-render(1)"));
        let render = page(Some("render")).unwrap();
        assert!(render.contains("look\\-at") && render.contains("split\\-quantile"), "{render}");
        assert_eq!(
            page(Some("rendr")).unwrap_err().to_string(),
            "there is no command 'rendr'; tamis --help lists them"
        );
    }
}
