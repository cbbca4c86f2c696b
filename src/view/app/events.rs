//! What other threads say, and what the user asks for.

use std::path::Path;
use std::sync::Arc;

use winit::event_loop::ActiveEventLoop;

use super::{App, Event, Said, watch_scene};
use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::scene::camera_text;
use crate::session::Session;
use crate::view::ask::Question;
use crate::view::notice::Notice;
use crate::view::panels;
use crate::view::recent::add_recent;
use crate::view::save::{Halves, Save, Saving, free_name};
use crate::view::state::{Command, Explained};
use crate::view::tracing::Traced;

impl<N: FnMut(&Notice)> App<N> {
    pub(super) fn hear(&mut self, event_loop: &ActiveEventLoop, event: Event) -> Result<()> {
        match event {
            Event::Said(said) if self.open.is_some() => self.hear_of_device(said?),
            // By a thread whose device is gone.
            Event::Said(_) => {}
            Event::Saved(path) => {
                if let Some(at) = self.saves.iter().position(|save| save.path == path) {
                    let save = self.saves.swap_remove(at);
                    return self.saved(save);
                }
            }
            // Of the scene before this one.
            Event::Scene(path, _) if path != self.state.path => {}
            Event::Scene(_, Ok((scene, camera))) => {
                self.state.reload(scene, camera);
                (self.notify)(&Notice::Reloaded);
            }
            Event::Scene(_, Err(error)) => {
                let error = in_words(error);
                (self.notify)(&Notice::SceneWrong { error: &error });
                self.state.scene_error = Some(error);
            }
            Event::Opened(path, Ok((scene, camera))) => {
                self.watch = watch_scene(&path, &self.options, &self.proxy)?;
                self.state.open(path, scene, camera);
                if let Some(open) = &self.open {
                    open.window.set_title(&self.title());
                }
                let path = self.state.path.clone();
                (self.notify)(&Notice::SceneOpened { path: &path });
                self.remember();
            }
            Event::Opened(path, Err(error)) => {
                let error = in_words(error);
                (self.notify)(&Notice::SceneWrong { error: &error });
                self.state.tell(format!("{} can't be opened: {error}", path.shown()));
            }
            Event::Interrupted => self.fail(event_loop, Error::Interrupted),
            Event::Lost(error) if self.open.is_some() => self.fail(event_loop, error),
            // With its window.
            Event::Lost(_) => {}
        }
        Ok(())
    }

    fn hear_of_device(&mut self, said: Said) {
        match said {
            Said::Traced(Traced::Picture(picture)) => self.state.picture = Some(picture),
            Said::Traced(Traced::More) => {}
            Said::Painted(painted) => {
                let place = painted.place;
                self.state.painted[place] = Some(painted);
            }
            Said::Hover(answer) => {
                self.state.answer(answer);
                let text = panels::hover_text(&self.state);
                (self.notify)(&Notice::Hover { text: &text });
            }
            Said::Explained((pixel, text)) => {
                if let Some(shown) = &mut self.state.explained
                    && [shown.question.x, shown.question.y] == pixel
                {
                    (self.notify)(&Notice::Explained { pixel, text: &text });
                    shown.text = Some(text);
                }
            }
        }
    }

    pub(super) fn carry_out(&mut self, event_loop: &ActiveEventLoop, command: Command) {
        match command {
            Command::PrintCamera => {
                let toml = camera_text(&self.state.rig.camera);
                self.state.tell("The camera is copied as TOML, and printed on standard output");
                (self.notify)(&Notice::Camera { toml: &toml });
            }
            Command::Save => self.save(),
            Command::Open(path) => self.reader.ask(path),
            Command::Explain(question) => {
                self.asked += 1;
                let serial = self.asked;
                let asked = question.clone();
                self.state.explained = Some(Explained { question: asked, text: None, serial });
                if let Some(open) = &self.open {
                    open.explain.ask(question);
                }
            }
            Command::Hover(question) => self.hover(question),
            Command::Quit => event_loop.exit(),
        }
    }

    fn hover(&mut self, question: Question) {
        let Some(open) = &mut self.open else { return };
        let is_known = |last: &Question| {
            Arc::ptr_eq(&last.scene, &question.scene)
                && (last.pixels, last.kernel, last.x, last.y)
                    == (question.pixels, question.kernel, question.x, question.y)
        };
        if !open.hovered.as_ref().is_some_and(is_known) {
            open.hovered = Some(question.clone());
            open.hover.ask(question);
        }
    }

    fn save(&mut self) {
        let Some(open) = &self.open else { return };
        let state = &self.state;
        let size = self.full_size().unwrap_or([state.area.width, state.area.height]);
        let (scene, device) = (state.saved_scene(), open.backend.device.clone());
        let mut session = Session::new(scene, device, state.kernels[1]);
        session.set_camera(state.rig.camera.clone());
        let halves =
            state.compares.then_some(Halves { kernels: state.kernels, divider: state.divider });
        let path = free_name(Path::new("."), &state.path, state.show, halves, &self.saves);
        let control = Arc::clone(&self.options.control);
        let saving = Saving { session, size, show: state.show, halves, control };
        let proxy = self.proxy.clone();
        let done = move |path| drop(proxy.send_event(Event::Saved(path)));
        match Save::start(saving, path, done) {
            Ok(save) => self.saves.push(save),
            Err(error) => self.state.tell(format!("The picture can't be saved: {error}")),
        }
    }

    /// Keeps that the scene was opened.
    pub(super) fn remember(&mut self) {
        let Some(list) = &self.options.recent else { return };
        match add_recent(list, &self.state.path) {
            Ok(recent) => self.state.recent = recent,
            Err(error) => {
                let message = format!("Recent files can't be kept: {error}");
                (self.notify)(&Notice::Trouble { message: &message });
            }
        }
    }

    /// Tells that a picture was saved.
    pub(super) fn saved(&mut self, save: Save) -> Result<()> {
        let (path, size) = (save.path.clone(), save.size);
        save.end()?;
        (self.notify)(&Notice::Saved { path: &path, size });
        self.state.tell(format!("Saved {}: {} × {}", path.shown(), size[0], size[1]));
        Ok(())
    }
}

/// An error in as many lines as it takes.
fn in_words(error: Error) -> String {
    match error {
        Error::Scene(wrong) => format!("{wrong}\n{}", wrong.help),
        other => other.to_string(),
    }
}
