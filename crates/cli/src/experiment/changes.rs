//! What may be changed of an experiment: what it sets itself is refused, for passed over in silence it would look as if it had
//! been tried.

use anyhow::Result;
use stack::Knob;

use super::methods::METHODS;
use super::name::Experiment;
use crate::args::ExperimentArgs;
use crate::failure::usage;
use crate::settings::Settings;

/// Refuses a preset or settings that the experiment would not use, and such as do not exist.
///
/// # Errors
/// The first of them.
pub fn check(args: &ExperimentArgs) -> Result<()> {
    args.settings()?;
    let name = args.name;
    if args.picture.preset.is_some() && (is_fixed(name) || name == Experiment::Methods) {
        return Err(usage("--preset: this experiment compares settings of its own, each with its preset"));
    }
    let flags = args.changes.iter().filter_map(|change| change.split_once('='));
    match flags.into_iter().find_map(|(flag, _)| Some((flag, why_not(name, flag)?))) {
        Some((flag, why)) => Err(usage(format!("--set {flag}: {why}"))),
        None => Ok(()),
    }
}

/// Whether all of its settings are its own.
const fn is_fixed(name: Experiment) -> bool {
    matches!(name, Experiment::Stages | Experiment::Figures | Experiment::Fireflies)
}

/// Why the setting `flag` cannot be changed.
fn why_not(name: Experiment, flag: &str) -> Option<&'static str> {
    let is_sampling = || Settings::describe_sampling().iter().any(|knob: &Knob| knob.flag == flag);
    match name {
        _ if is_fixed(name) => Some("this experiment compares settings of its own"),
        Experiment::Methods if METHODS.iter().any(|(.., flags)| flags.iter().any(|(own, _)| *own == flag)) => {
            Some("the methods that are compared differ by it")
        }
        Experiment::Sequences if ["sequences", "seed"].contains(&flag) => Some("this experiment compares values of it"),
        Experiment::Methods | Experiment::Scenes | Experiment::Errormap if flag == "seed" => {
            Some("renders have the seeds 0, 1 …, as many as --seeds says")
        }
        Experiment::Degrade | Experiment::Guide if is_sampling() => Some("this experiment takes no samples"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Task};

    fn checked(line: &str) -> Result<()> {
        let words = ["tamis", "experiment"].into_iter().chain(line.split(' ')).chain(["-o", "out"]);
        let Task::Experiment(args) = Cli::parse_from(words).command else { panic!("an experiment") };
        check(&args)
    }

    #[test]
    fn what_an_experiment_would_not_use_is_refused() {
        for line in [
            "stages --set window-radius=5",
            "figures --preset fast",
            "methods a.toml --preset fast",
            "methods a.toml --set method=nfor",
            "methods a.toml --set light-apart=false",
            "scenes a.toml --set seed=3",
            "sequences a.toml --set sequences=4",
            "guide a --set max-depth=3",
            "methods a.toml --set nonsense=3",
        ] {
            let flag = line.rsplit(' ').find(|word| word.starts_with("--p") || word.contains('=')).unwrap();
            let found = checked(line).map_err(|error| error.to_string()).expect_err(line);
            assert!(found.contains(flag.split('=').next().unwrap()), "{line}: {found}");
        }
    }

    #[test]
    fn what_an_experiment_uses_may_be_changed() {
        for line in
            ["methods a.toml --set max-depth=3 --set fit-second-radius=5", "lbf --set seed=3", "guide a --preset fast"]
        {
            checked(line).unwrap();
        }
    }
}
