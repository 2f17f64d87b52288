//! `servo-lab help`, `completions` and `man`.

use std::io::Write as _;
use std::path::PathBuf;

use clap::CommandFactory as _;
use diagnosis::effects::{VOCABULARY, find};

use super::{Cli, Overwrite};
use crate::read::AxisKind;
use crate::read::vocabulary::{self, Occurs};
use crate::read::{FORMATS, misspelt};
use crate::{Error, output};

/// Words that `help` explains beside the commands.
const TOPICS: &[&str] = &["effects", "formats"];
/// What is said of a word that is neither.
const NONE: &str = "there is no command and no topic";

/// Flags of `help`.
#[derive(Debug, clap::Args)]
pub struct HelpArgs {
    /// A command, with an action of it behind where it has some (`link run`); `effects` for the vocabulary of a diagnosis, `formats` for
    /// the logs that are read; or an effect.
    #[arg(value_name = "TOPIC")]
    topic: Vec<String>,
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
    /// Folder for the pages, one a command and action; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/man")]
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
    let [topic, actions @ ..] = &args.topic[..] else { return output::print(&cli.render_long_help().to_string()) };
    match (explained(topic), actions) {
        (Some(text), []) => return output::print(&text),
        (Some(_), [action, ..]) => {
            return Err(Error::Usage(format!("`{topic}` is no command with an action `{action}`")));
        }
        (None, _) => {}
    }
    // Built, so that a command's help names the program before it.
    cli.build();
    output::print(&help_of(&mut cli, &args.topic, TOPICS)?)
}

/// What a word says that is no command.
fn explained(topic: &str) -> Option<String> {
    match topic {
        "effects" => Some(effects()),
        "formats" => Some(formats()),
        _ => find(topic).map(|known| effect(known.id, known.sentence)),
    }
}

/// The help of the command at that path below this one; `topics` are known beside its subcommands.
fn help_of(command: &mut clap::Command, path: &[String], topics: &[&str]) -> Result<String, Error> {
    let [name, rest @ ..] = path else { return Ok(command.render_long_help().to_string()) };
    let known: Vec<String> = command.get_subcommands().map(|one| one.get_name().to_owned()).collect();
    let whose = if topics.is_empty() { format!("`{}` has no action", command.get_name()) } else { NONE.to_owned() };
    match command.find_subcommand_mut(name) {
        Some(next) => help_of(next, rest, &[]),
        None => Err(Error::Usage(format!("{whose} `{name}`; {}", instead(name, &known, topics)))),
    }
}

/// What else there is: the word that was meant, where one is near; all of them, where none is.
fn instead(word: &str, commands: &[String], topics: &[&str]) -> String {
    let effects = VOCABULARY.iter().map(|effect| effect.id).filter(|_| !topics.is_empty());
    let all = commands.iter().map(String::as_str).chain(topics.iter().copied());
    match misspelt(word, all.clone().chain(effects)) {
        Some(near) => format!("is `{near}` meant?"),
        _ if commands.is_empty() => "it has none".to_owned(),
        _ if topics.is_empty() => format!("there are {}", all.collect::<Vec<_>>().join(", ")),
        _ => format!("there are {}; and each effect that `help effects` lists", all.collect::<Vec<_>>().join(", ")),
    }
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

/// A command by the name of its page, and all below it.
fn pages(command: &clap::Command, name: &str) -> Vec<(String, clap::Command)> {
    let mut all = vec![(name.to_owned(), command.clone())];
    for below in command.get_subcommands() {
        all.extend(pages(below, &format!("{name}-{}", below.get_name())));
    }
    all
}

/// Writes a man page for every command and every action of one.
///
/// # Errors
/// Pages that cannot be written.
pub fn man(args: &ManArgs) -> Result<(), Error> {
    let mut cli = Cli::command();
    cli.build();
    let pages = pages(&cli, "servo-lab");
    let mut files = args.overwrite.files();
    let out: Vec<_> = pages.iter().map(|(name, _)| files.writes(&args.out.join(format!("{name}.1")))).collect();
    let mut outputs = files.check()?;
    for (file, (name, command)) in out.into_iter().zip(pages) {
        let man = clap_mangen::Man::new(command).title(name);
        outputs.write(file, |to| {
            // A comment of troff; the mark by which the tool knows its own file again.
            writeln!(to, ".\\\" {}", output::mark::WORDS)?;
            man.render(to)
        })?;
    }
    outputs.finish()?;
    output::print(&format!("wrote the pages to {}\n", args.out.display()))
}
