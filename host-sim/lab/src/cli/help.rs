//! `servo-lab help`, `completions` and `man`.

use std::io::Write as _;
use std::path::PathBuf;

use clap::CommandFactory as _;
use diagnosis::effects::VOCABULARY;

use super::{Cli, Overwrite};
use crate::read::AxisKind;
use crate::read::vocabulary::{self, Occurs};
use crate::read::{FORMATS, nearest};
use crate::{Error, output};

/// Words that `help` explains beside the commands.
const TOPICS: &[&str] = &["effects", "formats"];

/// Flags of `help`.
#[derive(Debug, clap::Args)]
pub struct HelpArgs {
    /// A command; `effects` for the vocabulary of a diagnosis, `formats` for the logs that are read; or an effect.
    #[arg(value_name = "TOPIC")]
    topic: Option<String>,
}

/// Flags of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell they are for; they go to standard output.
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Flags of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder for the pages, one a command; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/man")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Prints what a topic is.
///
/// # Errors
/// A topic that is none.
pub fn help(args: &HelpArgs) -> Result<(), Error> {
    let mut cli = Cli::command();
    let Some(topic) = args.topic.as_deref() else { return output::print(&cli.render_long_help().to_string()) };
    match topic {
        "effects" => return output::print(&effects()),
        "formats" => return output::print(&formats()),
        _ => {}
    }
    if let Some(effect) = VOCABULARY.iter().find(|effect| effect.id == topic) {
        return output::print(&self::effect(effect.id, effect.sentence));
    }
    // Built, so that a command's help names the program before it.
    cli.build();
    if let Some(command) = cli.find_subcommand_mut(topic) {
        return output::print(&command.render_long_help().to_string());
    }
    let commands = cli.get_subcommands().map(clap::Command::get_name);
    let known = TOPICS.iter().copied().chain(VOCABULARY.iter().map(|effect| effect.id)).chain(commands);
    let near = nearest(topic, known).map_or_else(String::new, |near| format!("; is `{near}` meant?"));
    Err(Error::Usage(format!("there is no command and no topic `{topic}`{near}")))
}

/// The logs that are read.
fn formats() -> String {
    let mut text = "Logs that are read, each also packed as .gz, and what becomes a column.\n\n".to_owned();
    FORMATS.iter().for_each(|(name, columns)| text += &format!("{name}\n    {columns}\n"));
    text
}

/// The vocabulary.
fn effects() -> String {
    let mut text = "What a diagnosis may name; parameters as a machine file has them in [[effects]].\n\n".to_owned();
    VOCABULARY.iter().for_each(|known| text += &effect(known.id, known.sentence));
    text + "\nOf each, how it looks and how small it may be: servo-lab guide\n"
}

fn effect(id: &str, sentence: &str) -> String {
    let kind = vocabulary::effect(id);
    let parameters = kind.map_or(&[][..], |kind| kind.parameters).iter().map(|parameter| {
        let (rotary, linear) = (parameter.id(AxisKind::Rotary), parameter.id(AxisKind::Linear));
        if rotary == linear { rotary.to_owned() } else { format!("{rotary} ({linear})") }
    });
    let parameters = parameters.collect::<Vec<_>>().join(", ");
    let often = match kind.map(|kind| kind.occurs) {
        Some(Occurs::Repeatedly) => "; any number of times",
        Some(Occurs::InNamedRecording) => "; in the recording it names",
        _ => "",
    };
    format!("{id}\n    {sentence}\n    {parameters}{often}\n")
}

/// Prints the completions of a shell.
///
/// # Errors
/// Standard output that cannot be written.
pub fn completions(args: &CompletionsArgs) -> Result<(), Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "servo-lab", &mut script);
    output::print(&String::from_utf8_lossy(&script))
}

/// Writes a man page for every command.
///
/// # Errors
/// Pages that cannot be written.
pub fn man(args: &ManArgs) -> Result<(), Error> {
    let mut cli = Cli::command();
    cli.build();
    let mut pages = vec![("servo-lab.1".to_owned(), cli.clone())];
    pages.extend(cli.get_subcommands().map(|command| (format!("servo-lab-{}.1", command.get_name()), command.clone())));
    let mut files = args.overwrite.files();
    let out: Vec<_> = pages.iter().map(|(name, _)| files.writes(&args.out.join(name))).collect();
    let mut outputs = files.check()?;
    for (file, (name, command)) in out.into_iter().zip(pages) {
        let man = clap_mangen::Man::new(command).title(name.trim_end_matches(".1").to_owned());
        outputs.write(file, |to| {
            // A comment of troff; the mark by which the tool knows its own file again.
            writeln!(to, ".\\\" {}", output::mark::WORDS)?;
            man.render(to)
        })?;
    }
    outputs.finish()?;
    output::print(&format!("wrote the pages to {}\n", args.out.display()))
}
