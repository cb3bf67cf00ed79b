//! Pictures the training has not seen.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::args::ExperimentArgs;
use crate::experiment::case::Case;
use crate::experiment::reference::references;
use crate::experiment::stage::{OWN_SCENES, Stage};
use crate::progress::Progress;

/// Every folder of buckets, and every scene at every number of samples; without inputs our scenes as they are, of which
/// the training sees variations.
///
/// # Errors
/// When an input cannot be opened or traced.
pub fn held_out(args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Case>> {
    let own = OWN_SCENES.map(PathBuf::from);
    let inputs = if args.inputs.is_empty() { &own[..] } else { &args.inputs };
    let mut cases = Vec::new();
    for input in inputs {
        if input.is_dir() { cases.push(Case::open(input)?) } else { cases.extend(of_scene(input, args, progress)?) }
    }
    Ok(cases)
}

fn of_scene(file: &Path, args: &ExperimentArgs, progress: &Progress) -> Result<Vec<Case>> {
    let stage = Stage::open(file, args, progress)?;
    let references = references(args, &stage, progress)?;
    let case = |spp: &u32| {
        let stack = stage.sample(&args.settings()?, *spp, progress)?;
        Ok(Case {
            name: format!("{} {spp} spp", stage.name),
            stack,
            references: references.clone(),
            others: Vec::new(),
        })
    };
    args.spp.iter().map(case).collect()
}
