//! `kugelblitz man`

use std::iter::once;
use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, italic, roman};
use kugelblitz::output;
use kugelblitz::plain::Shown;
use kugelblitz::scene::schema::SECTIONS;
use kugelblitz::{Error, Result};

use crate::Run;
use crate::args::{Cli, EXIT_CODES};
use crate::manual::{ENVIRONMENT, EXAMPLES, SCENE_EXAMPLE, SCENE_INTRODUCTION, SCENE_NOTES};
use crate::output::{STDOUT, print, written};
use kugelblitz::words::did_you_mean;

/// Print a manual page (roff), or write all of them
#[derive(Args)]
pub struct ManArgs {
    /// Command, or `scene` for the scene format [default: the program]
    #[arg(value_name = "COMMAND")]
    of: Vec<String>,
    /// Write all pages to this folder, which is created if it does not exist
    #[arg(long, value_name = "DIR", conflicts_with = "of")]
    dir: Option<PathBuf>,
}

/// The name of the page about scenes.
const SCENE_PAGE: &str = "scene";

/// Prints the manual page of the program, of one command or of the scene format, or writes all.
pub fn run(args: &ManArgs, run: &Run) -> Result<()> {
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    if let Some(dir) = &args.dir {
        std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
        let mut files = vec![written(&dir.join("kugelblitz-scene.5"), &scene_page())?];
        for command in with_subcommands(&program) {
            files.push(written(&dir.join(format!("{}.1", title(command))), &page(command)?)?);
        }
        return output::commit(files, &run.control);
    }
    match &args.of[..] {
        [only] if only == SCENE_PAGE => print(&scene_page()),
        names => print(&page(find(&program, names)?)?),
    }
}

fn find<'a>(program: &'a Command, names: &[String]) -> Result<&'a Command> {
    names.iter().try_fold(program, |command, name| {
        command.find_subcommand(name).ok_or_else(|| {
            let known = command.get_subcommands().map(Command::get_name).chain([SCENE_PAGE]);
            let near = did_you_mean(known, name);
            let hint = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
            Error::Usage(
                format!("there is no page `{}`; {hint}see kugelblitz --help", name.shown()).into(),
            )
        })
    })
}

/// A command and all below it.
fn with_subcommands(command: &Command) -> Vec<&Command> {
    once(command).chain(command.get_subcommands().flat_map(with_subcommands)).collect()
}

/// `kugelblitz-render`
fn title(command: &Command) -> &str {
    command.get_display_name().unwrap_or_else(|| command.get_name())
}

fn page(command: &Command) -> Result<Vec<u8>> {
    let man = Man::new(command.clone())
        .source(concat!("kugelblitz ", env!("CARGO_PKG_VERSION")))
        .manual("Kugelblitz");
    let mut page = Vec::new();
    let mut render = || {
        man.render_title(&mut page)?;
        man.render_name_section(&mut page)?;
        man.render_synopsis_section(&mut page)?;
        man.render_description_section(&mut page)?;
        man.render_options_section(&mut page)?;
        if command.has_subcommands() {
            man.render_subcommands_section(&mut page)?;
        }
        more_sections(command).to_writer(&mut page)
    };
    render().map_err(Error::io(STDOUT))?;
    Ok(page)
}

/// What clap knows nothing of.
fn more_sections(command: &Command) -> Roff {
    let mut roff = Roff::new();
    if command.get_name() == "kugelblitz" {
        roff.control("SH", ["ENVIRONMENT"]);
        for (name, meaning) in ENVIRONMENT {
            roff.control("TP", []).text([bold(name)]).text([roman(meaning)]);
        }
    }
    roff.control("SH", ["EXIT STATUS"]);
    verbatim(&mut roff, EXIT_CODES.lines().skip(1));
    let mut own = EXAMPLES.iter().filter(|(page, ..)| *page == title(command)).peekable();
    if own.peek().is_some() {
        roff.control("SH", ["EXAMPLES"]);
    }
    for (_, line, meaning) in own {
        paragraph(&mut roff, meaning);
        verbatim(&mut roff, once(*line));
    }
    let see = [bold("kugelblitz"), roman("(1), "), bold("kugelblitz-scene"), roman("(5)")];
    roff.control("SH", ["SEE ALSO"]).text(see);
    roff
}

fn paragraph(roff: &mut Roff, text: &str) {
    roff.control("PP", []).text([roman(text)]);
}

fn verbatim<'a>(roff: &mut Roff, lines: impl IntoIterator<Item = &'a str>) {
    roff.control("PP", []).control("RS", ["4"]).control("nf", []);
    for line in lines {
        roff.text([roman(if line.is_empty() { " " } else { line })]);
    }
    roff.control("fi", []).control("RE", []);
}

/// The page about scenes.
fn scene_page() -> Vec<u8> {
    let mut roff = Roff::new();
    let source = concat!("kugelblitz ", env!("CARGO_PKG_VERSION"));
    roff.control("TH", ["kugelblitz-scene", "5", "", source, "Kugelblitz"]);
    roff.control("SH", ["NAME"]);
    roff.text([roman("kugelblitz-scene - the scenes that Kugelblitz reads")]);
    roff.control("SH", ["DESCRIPTION"]);
    SCENE_INTRODUCTION.iter().for_each(|text| paragraph(&mut roff, text));
    for section in SECTIONS {
        let header = section.header;
        let title = header.strip_prefix("the ").map_or(header.to_owned(), str::to_uppercase);
        roff.control("SH", [&*title]);
        paragraph(&mut roff, section.meaning);
        for key in section.keys.iter().filter(|key| !key.example.is_empty()) {
            let line = [bold(key.name), roman(" = "), italic(key.example)];
            roff.control("TP", []).text(line).text([roman(key.meaning)]);
        }
    }
    roff.control("SH", ["NOTES"]);
    SCENE_NOTES.iter().for_each(|text| paragraph(&mut roff, text));
    roff.control("SH", ["EXAMPLES"]);
    verbatim(&mut roff, SCENE_EXAMPLE.lines());
    let see = [bold("kugelblitz"), roman("(1), "), bold("kugelblitz-render"), roman("(1)")];
    roff.control("SH", ["SEE ALSO"]).text(see);
    roff.render().into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_an_example_that_is_its_own() {
        let mut program = Cli::command().disable_help_subcommand(true);
        program.build();
        let titles: Vec<&str> = with_subcommands(&program).into_iter().map(title).collect();
        // What only leads to others has theirs.
        for title in titles.iter().filter(|title| **title != "kugelblitz-generate") {
            assert!(EXAMPLES.iter().any(|(page, ..)| page == title), "{title} has no example");
        }
        for (page, line, _) in EXAMPLES {
            assert!(titles.contains(page), "there is no command for the examples of {page}");
            let words = page.replace('-', " ");
            assert!(line.contains(&words), "`{line}` on the page {page}");
        }
    }
}
