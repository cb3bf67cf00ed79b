//! The `tamis` command: parses, hands over to one module per subcommand, and turns errors into exit codes.

mod any_picture;
mod args;
mod bench;
mod compare;
mod denoise;
mod experiment;
mod exposure;
mod failure;
mod guide;
mod info;
mod interrupt;
mod large_blocks;
mod log_file;
mod manual;
mod mask;
mod memory;
mod merge;
mod options;
mod output;
mod plan;
mod progress;
mod render;
mod report;
mod settings;
mod spool;
mod stderr;
mod stdout;
mod table;
mod threads;

use std::process::ExitCode;

use args::Task;

#[global_allocator]
static ALLOCATOR: large_blocks::HugePages = large_blocks::HugePages;

fn main() -> ExitCode {
    large_blocks::keep_freed();
    let (cli, matches) = args::parse();
    let log = cli.command.report().and_then(|report| report.log_file.as_deref()).map_or(Ok(()), log_file::open);
    let outcome = log.and_then(|()| match cli.command {
        Task::Render(args) => render::run(&args, &matches),
        Task::Denoise(args) => denoise::run(args, &matches),
        Task::Merge(args) => merge::run(&args, &matches),
        Task::Plan(args) => plan::run(&args, &matches),
        Task::Compare(args) => compare::run(&args),
        Task::Info(args) => info::run(&args),
        Task::Experiment(args) => experiment::run(&args),
        Task::Bench(args) => bench::run(&args),
        Task::Completions(args) => manual::completions(&args),
        Task::Man(args) => manual::man(&args),
    });
    match outcome {
        Ok(verdict) => verdict.into(),
        Err(error) => {
            let line = format!("error: {error:#}");
            log_file::add(&line);
            stderr::say_line(&line);
            failure::exit_code(&error)
        }
    }
}
