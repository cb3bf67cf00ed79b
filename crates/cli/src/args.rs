//! Every flag of the command line. The doc comments are the help; settings of the libraries (`knobs!`) add theirs.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use stack::Knobs;
use stack::file::{Convention, Mapping, ReadOptions};

use crate::failure::usage;
use crate::memory::Bytes;
use crate::options::{Crop, PictureSize, Shutter, Sky, Triple, above_zero, finite, not_negative};
use crate::settings::{Preset, Settings};

/// What `--aov` is when it is not given.
pub const DEFAULT_AOV: &str = "inputs,mse";

/// Renders a scene on the CPU, or denoises another renderer's feature stack.
#[derive(Debug, Parser)]
#[command(name = "tamis", version, arg_required_else_help = true, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Task,
}

#[derive(Debug, Subcommand)]
pub enum Task {
    /// Trace a scene and reconstruct its picture.
    Render(Box<RenderArgs>),
    /// Reconstruct the picture of an existing feature stack.
    Denoise(DenoiseArgs),
    /// Add up renders of the same picture with different samples, and reconstruct it.
    Merge(MergeArgs),
    /// Print the commands that render a picture in slices on several machines, a line each, and the one that adds them
    /// up.
    Plan(Box<PlanArgs>),
    /// Measure how far pictures are from a reference.
    Compare(CompareArgs),
    /// Say what a scene or stack holds, as Tamis reads it.
    Info(InfoArgs),
    /// Reproduce a table of the documentation.
    Experiment(ExperimentArgs),
    /// Measure this machine: rays, samples and reconstructed pixels a second.
    Bench(BenchArgs),
    /// Print what a shell needs to complete commands and flags.
    Completions(CompletionsArgs),
    /// Print a manual page.
    Man(ManArgs),
}

impl Task {
    /// How much is said, where a command asks.
    pub fn report(&self) -> Option<&ReportArgs> {
        match self {
            Self::Render(args) => Some(&args.report),
            Self::Denoise(args) => Some(&args.rebuild.report),
            Self::Merge(args) => Some(&args.rebuild.report),
            Self::Plan(args) => Some(&args.render.report),
            Self::Experiment(args) => Some(&args.report),
            Self::Bench(args) => Some(&args.report),
            Self::Compare(_) | Self::Info(_) | Self::Completions(_) | Self::Man(_) => None,
        }
    }
}

/// How much is said, and in what form.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Reports")]
pub struct ReportArgs {
    /// Print one JSON object on standard output at the end.
    #[arg(long)]
    pub json: bool,
    /// Say nothing on standard error but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Say more on standard error.
    #[arg(long, short)]
    pub verbose: bool,
    /// Add what is said, and what would be with --verbose, to this file.
    #[arg(long, value_name = "FILE")]
    pub log_file: Option<PathBuf>,
    /// Worker threads; the picture does not depend on it [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// What is written where.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Output file: .exr (all layers), .png, .hdr or .pfm; may be given more than once.
    #[arg(long, short, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Layers of the .exr beside the picture: `inputs` (what `denoise` needs to start again), `all`, `none`, or a
    /// comma-separated list of inputs, mse, samples, spikes, bandwidth, rank.
    #[arg(long, value_name = "LIST", default_value = DEFAULT_AOV)]
    pub aov: String,
    /// Exposure of the .png in stops [default: chosen from the picture].
    #[arg(long, value_name = "EV", value_parser = finite::<f32>)]
    pub exposure: Option<f32>,
}

impl OutputArgs {
    /// The files to write: without any, `stem`.exr and `stem`.png in the working directory.
    pub fn files(&self, stem: &str) -> Vec<PathBuf> {
        if self.output.is_empty() {
            return ["exr", "png"].map(|ending| PathBuf::from(format!("{stem}.{ending}"))).to_vec();
        }
        self.output.clone()
    }
}

/// How the picture is reconstructed.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Settings to start from; single flags override it [default: best, or what the stack was made with].
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
}

#[derive(Debug, Default, Args)]
pub struct RenderArgs {
    /// Scene: .obj (with its MTL), .gltf, .glb or .toml.
    pub scene: PathBuf,

    /// Camera position.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Camera")]
    pub eye: Option<Triple>,
    /// Point the camera looks at.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Camera")]
    pub look_at: Option<Triple>,
    /// Direction that is up in the picture.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Camera")]
    pub up: Option<Triple>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEG", help_heading = "Camera")]
    pub fov: Option<f32>,
    /// Radius of the lens in scene units; 0 is a pinhole.
    #[arg(long, value_name = "R", help_heading = "Camera")]
    pub lens_radius: Option<f32>,
    /// Distance to the plane in focus.
    #[arg(long, value_name = "D", help_heading = "Camera")]
    pub focus_distance: Option<f32>,
    /// When the shutter opens and closes within the frame, whose time runs from 0 to 1.
    #[arg(long, value_name = "A,B", allow_hyphen_values = true, help_heading = "Camera")]
    pub shutter: Option<Shutter>,
    /// Camera of the scene file to use.
    #[arg(long, value_name = "NAME", help_heading = "Camera")]
    pub camera: Option<String>,
    /// Size of the picture [default: 512x512, or what the scene says].
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, help_heading = "Camera")]
    pub size: Option<PictureSize>,
    /// Trace only this rectangle of the picture.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, help_heading = "Camera")]
    pub crop: Option<Crop>,

    /// Sky that replaces the scene's: a latitude-longitude map (.hdr, .exr, .pfm), or a radiance that is the same
    /// everywhere.
    #[arg(long, value_name = "FILE|R,G,B", allow_hyphen_values = true, help_heading = "Light")]
    pub env: Option<Sky>,
    /// Turn of the sky's map round the vertical in degrees, counter-clockwise seen from above.
    #[arg(long, value_name = "DEG", value_parser = finite::<f32>, help_heading = "Light")]
    pub env_rotate: Option<f32>,
    /// Factor on the sky's radiance.
    #[arg(long, value_name = "S", value_parser = not_negative::<f32>, help_heading = "Light")]
    pub env_scale: Option<f32>,

    /// Mean samples per pixel [default: 32, or what the scene says].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Work")]
    pub spp: Option<u32>,
    /// Stop after this time (`90s`, `5m`, `1h`).
    #[arg(long, value_name = "TIME", value_parser = crate::options::duration, allow_hyphen_values = true,
        help_heading = "Work")]
    pub time: Option<std::time::Duration>,
    /// Stop when the estimated relative MSE of the picture is this low; exit 1 when the budget ends before.
    #[arg(long, value_name = "E", value_parser = above_zero, help_heading = "Work")]
    pub target_error: Option<f32>,
    /// The same number of samples for every pixel.
    #[arg(long, help_heading = "Work")]
    pub uniform: bool,
    /// Only the samples A to B-1 of every pixel (A..B), uniformly. `merge` adds such slices up; together they hold the
    /// same samples as one uniform render, but gathered light is made within each.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true,
        conflicts_with_all = ["spp", "time", "target_error"], help_heading = "Work")]
    pub samples: Option<crate::options::SampleRange>,
    /// Go on from the samples in the output's .exr, or in the .partial.exr that an interrupted run left, up to what is
    /// asked for.
    #[arg(long, help_heading = "Work")]
    pub resume: bool,
    /// Keep the samples there are in OUT.partial.exr, for --resume, so long after the last time (`5m`), as soon as up to eight
    /// samples of every pixel are done.
    #[arg(long, value_name = "TIME", value_parser = crate::options::duration, allow_hyphen_values = true,
        help_heading = "Output")]
    pub checkpoint: Option<std::time::Duration>,
    /// Leave the picture as it was sampled.
    #[arg(long, help_heading = "Picture")]
    pub no_denoise: bool,
    /// Another denoiser's picture of the same render (.exr, .pfm, .hdr), mixed in at the end where it is likely to be nearer to the
    /// truth.
    #[arg(long, value_name = "FILE", conflicts_with = "no_denoise", help_heading = "Picture")]
    pub guide: Option<PathBuf>,
    /// Show the picture while it is made in the image viewer tev, at localhost:14158 if no other address is given.
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = crate::options::TEV_ADDRESS,
        help_heading = "Output")]
    pub tev: Option<crate::options::Address>,

    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

impl RenderArgs {
    /// What outputs are called that have no other name.
    pub fn stem(&self) -> String {
        self.scene.file_stem().map_or_else(|| "picture".into(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// What files are, where they do not say so themselves.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadingArgs {
    /// What a layer is: a role (colour, emission, position, albedo, normal, visibility, depth, proximity, lit, alpha,
    /// samples), perhaps with -variance, -a or -b, and the layer's name; `none` where there is nothing. May be given more
    /// than once.
    #[arg(long, value_name = "ROLE=LAYER", value_parser = mapping)]
    pub map: Vec<Mapping>,
    /// Samples per pixel, where the files do not say or are wrong; of each half or bucket, or of all.
    #[arg(long, value_name = "N,N…", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub spp: Vec<u32>,
    /// What every variance in the files is: sample, mean, second-moment, standard-error or half-difference [default:
    /// what the renderer is known to write].
    #[arg(long, value_name = "KIND")]
    pub variance_is: Option<Convention>,
}

impl ReadingArgs {
    /// The same for the library.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            map: self.map.clone(),
            spp: self.spp.clone(),
            variance_is: self.variance_is,
            ..ReadOptions::default()
        }
    }
}

fn mapping(text: &str) -> Result<Mapping, String> {
    let (role, layer) = text.split_once('=').ok_or("expected ROLE=LAYER")?;
    Ok((role.parse()?, layer.to_string()))
}

/// How a stack that is there is reconstructed, and where its picture goes.
#[derive(Debug, Args)]
pub struct RebuildArgs {
    /// Take no more memory than this, as in 800M or 24G: at the price of time, the picture stays the same. Three quarters
    /// of the machine's when not given.
    #[arg(long, value_name = "SIZE")]
    pub max_memory: Option<Bytes>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

#[derive(Debug, Args)]
pub struct DenoiseArgs {
    /// One stack: an .exr with layers, or several files whose names say what they are, or ROLE=FILE. With a folder or a
    /// name with #### as output, several stacks; #### in a name stands for the number of a frame.
    #[arg(required_unless_present_any = ["buckets", "half_a"], conflicts_with = "buckets")]
    pub input: Vec<String>,
    /// One of two renders of equal standing, each with its own features.
    #[arg(long, value_name = "FILE", requires = "half_b", conflicts_with = "buckets")]
    pub half_a: Option<PathBuf>,
    /// The other.
    #[arg(long, value_name = "FILE", requires = "half_a")]
    pub half_b: Option<PathBuf>,
    /// Independent renders of the same picture, each with its own features.
    #[arg(long, value_name = "FILE", num_args = 2..)]
    pub buckets: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Of several stacks, leave out those whose output is there already.
    #[arg(long)]
    pub resume: bool,
    /// What must be there, comma-separated: roles (position, albedo, normal, visibility, depth, proximity, lit, emission,
    /// alpha, samples), `noise` (something is known about the colour's), `variance` or `buckets` (what).
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub require: Vec<String>,
    /// Another denoiser's picture of the same stack (.exr, .pfm, .hdr), mixed in where it is likely to be nearer to the truth.
    #[arg(long, value_name = "FILE", conflicts_with = "also", help_heading = "Picture")]
    pub guide: Option<PathBuf>,
    /// Layers of light that the file carries along (passes, groups of lights), comma-separated: rebuilt with the weights
    /// of the picture, so that they still add up to it, and written under their own names.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub also: Vec<String>,
    #[command(flatten)]
    pub rebuild: RebuildArgs,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Files that `render` wrote, of one scene, camera, size and crop: slices of one seed (--samples), or of several
    /// seeds. Their order does not matter.
    #[arg(required = true, value_name = "SLICE")]
    pub slices: Vec<PathBuf>,
    #[command(flatten)]
    pub rebuild: RebuildArgs,
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Slices to divide the samples of every pixel into.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Work")]
    pub slices: u32,
    #[command(flatten)]
    pub render: RenderArgs,
}

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The picture that is right.
    pub reference: PathBuf,
    /// The pictures to measure.
    #[arg(required = true)]
    pub images: Vec<PathBuf>,
    /// A second, independent reference: its noise no longer counts (`rmse_cross`).
    #[arg(long, value_name = "FILE")]
    pub ref2: Option<PathBuf>,
    /// What keeps the relative measures finite where the reference is black.
    #[arg(long, value_name = "E", value_parser = finite::<f32>, default_value_t = 0.001)]
    pub epsilon: f32,
    /// Exit 1 when an image's relative MSE is above this.
    #[arg(long, value_name = "X", value_parser = not_negative::<f64>)]
    pub max_rmse: Option<f64>,
    /// Exit 1 when an image's LDR-FLIP is above this.
    #[arg(long, value_name = "X", value_parser = not_negative::<f64>)]
    pub max_flip: Option<f64>,
    /// A picture of the same size: pixels that are black in it are left out of every measure.
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// Write a page that shows the pictures, their errors and their settings in a browser: one file, which needs no other.
    #[arg(long, value_name = "PAGE.html")]
    pub html: Option<PathBuf>,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Scenes (.obj, .gltf, .glb, .toml) or stacks (.exr, .pfm, .phm); several files that are one stack together are read as one.
    #[arg(required = true)]
    pub files: Vec<String>,
    #[command(flatten)]
    pub reading: ReadingArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Scene to measure on [default: a room of 130,000 triangles that comes along].
    pub scene: Option<PathBuf>,
    /// Size of the picture that is traced and reconstructed.
    #[arg(long, value_name = "WxH", default_value = "320x240")]
    pub size: PictureSize,
    /// Samples per pixel.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub spp: u32,
    /// Rounds, of which the best counts for every step.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
    /// What `tamis bench --json` printed earlier, to be set beside.
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Exit 1 when a step is slower than it was by more than this share.
    #[arg(long, value_name = "X", value_parser = finite::<f64>, requires = "against")]
    pub max_loss: Option<f64>,
    #[command(flatten)]
    pub report: ReportArgs,
}

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Which shell.
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub struct ManArgs {
    /// Command whose page it is [default: that of the program].
    pub command: Option<String>,
}

#[derive(Debug, Args)]
pub struct ExperimentArgs {
    /// Which one.
    #[arg(value_enum)]
    pub name: crate::experiment::name::Experiment,
    /// Inputs: folders of bucket stacks, or scenes, as the experiment says.
    pub inputs: Vec<PathBuf>,
    /// Folder for the table, the pictures and the references.
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Size of rendered pictures.
    #[arg(long, value_name = "WxH", default_value = "256x256")]
    pub size: PictureSize,
    /// Samples per pixel of the pictures that are judged.
    #[arg(long, value_name = "N,N…", value_delimiter = ',', default_value = "8,32")]
    pub spp: Vec<u32>,
    /// Samples per pixel of reference pictures.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    pub reference_spp: u32,
    /// Renders of each scene whose errors are averaged, with seeds of their own.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub seeds: u64,
    #[command(flatten)]
    pub picture: PictureArgs,
    /// A setting to change, as the flags of `render` are called; may be given more than once. What the experiment sets
    /// itself cannot be changed.
    #[arg(long = "set", value_name = "FLAG=VALUE")]
    pub changes: Vec<String>,
    /// Program that denoises a stack with Open Image Denoise, called with the stack and `-o DIR`, for instance "python
    /// scripts/denoise_with_oidn.py".
    #[arg(long, value_name = "COMMAND")]
    pub oidn: Option<String>,
    /// Numbers of the paper's figures to make [default: all].
    #[arg(long, value_name = "N,N…", value_delimiter = ',')]
    pub figures: Vec<u32>,
    #[command(flatten)]
    pub report: ReportArgs,
}

impl ExperimentArgs {
    /// The settings of the preset, changed as asked for.
    ///
    /// # Errors
    /// When there is no such flag, or it does not take the value.
    pub fn settings(&self) -> anyhow::Result<Settings> {
        let mut settings = Settings::of(self.picture.preset.unwrap_or_default());
        self.change(&mut settings)?;
        Ok(settings)
    }

    /// Changes `settings` as asked for.
    ///
    /// # Errors
    /// As [`Self::settings`].
    pub fn change(&self, settings: &mut Settings) -> anyhow::Result<()> {
        for change in &self.changes {
            let (flag, value) =
                change.split_once('=').ok_or_else(|| usage(format!("--set {change}: expected FLAG=VALUE")))?;
            settings.set(flag, value).ok_or_else(|| usage(format!("--set: no setting is called {flag}")))??;
        }
        Ok(())
    }
}

/// The whole command line, with one flag for every setting of the libraries.
pub fn command() -> Command {
    let all = |command: Command| Settings::describe().into_iter().fold(command, with_knob);
    let rebuild = |command: Command| {
        let command = reconstruct::Settings::describe().into_iter().fold(command, with_knob);
        Settings::describe_sampling().into_iter().fold(command, refusing_knob)
    };
    let command = ["render", "plan"].into_iter().fold(Cli::command(), |whole, name| whole.mut_subcommand(name, all));
    let command = ["denoise", "merge"].into_iter().fold(command, |whole, name| whole.mut_subcommand(name, rebuild));
    command.mut_subcommands(|command| command.mut_args(taking_negative_numbers))
}

/// A flag that reads a negative number as its value: what is wrong with it says the flag itself, where `clap` would only
/// take it for another flag.
fn taking_negative_numbers(arg: Arg) -> Arg {
    let takes_one = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append)
        && !arg.is_positional()
        && arg.get_num_args().is_none();
    if takes_one { arg.allow_negative_numbers(true) } else { arg }
}

/// A setting of how samples are taken, where they are there already: its flag is known, so that it can be said why not.
fn refusing_knob(command: Command, knob: stack::Knob) -> Command {
    let refuse = |_: &str| Err::<String, _>("only render takes samples; those of the input stay as they were taken");
    command.arg(
        Arg::new(knob.flag.clone())
            .long(knob.flag)
            .value_name("VALUE")
            .value_parser(refuse)
            .allow_hyphen_values(true)
            .hide(true),
    )
}

fn with_knob(command: Command, knob: stack::Knob) -> Command {
    let range = if knob.range == ".." { String::new() } else { format!(", {}", knob.range) };
    let help = format!("{} [default: {}{range}]", knob.help.trim().replace("\n ", " "), knob.default);
    command.arg(
        Arg::new(knob.flag.clone())
            .long(knob.flag)
            .value_name("VALUE")
            .help(help)
            .allow_hyphen_values(true)
            .help_heading("Settings"),
    )
}

/// Parses the process's arguments; usage errors end the process with exit code 2.
pub fn parse() -> (Cli, ArgMatches) {
    let matches = command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let (_, own) = matches.subcommand().map_or(("", ArgMatches::default()), |(name, own)| (name, own.clone()));
    (cli, own)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_command_line_is_consistent() {
        super::command().debug_assert();
    }
}
