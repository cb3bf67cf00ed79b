//! Runs the real binary in a folder of its own.
#![allow(dead_code, reason = "each test file uses its own part of this")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A temporary folder with a small scene in it.
pub struct Workplace {
    folder: tempfile::TempDir,
}

/// A box with a lamp, open towards +z.
const OBJ: &str = "\
mtllib box.mtl
v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1
v -.3 1.98 -.3\nv .3 1.98 -.3\nv .3 1.98 .3\nv -.3 1.98 .3
usemtl white
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
usemtl red
f 4 1 5 8
f 2 3 7 6
usemtl lamp
f 9 10 11 12
";

const MTL: &str = "\
newmtl white\nKd .7 .7 .7\nnewmtl red\nKd .6 .1 .1\nnewmtl lamp\nKd .5 .5 .5\nKe 12 11 9
";

impl Workplace {
    pub fn new() -> Self {
        let workplace = Self { folder: tempfile::tempdir().unwrap() };
        workplace.write("box.obj", OBJ);
        workplace.write("box.mtl", MTL);
        workplace
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Names of all files in the folder.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// The command with the arguments in `line` (split at blanks), in the folder, not yet started.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tamis"));
        command.args(line.split_whitespace()).current_dir(self.folder.path());
        command
    }

    /// Runs `tamis` with the arguments in `line`.
    pub fn tamis(&self, line: &str) -> Run {
        Run(self.command(line).output().unwrap())
    }

    /// Runs it and demands success.
    pub fn must(&self, line: &str) -> Run {
        let run = self.tamis(line);
        assert_eq!(run.code(), Some(0), "tamis {line}\n{}", run.stderr());
        run
    }
}

/// A finished run.
pub struct Run(Output);

impl Run {
    pub fn code(&self) -> Option<i32> {
        self.0.status.code()
    }

    pub fn stdout(&self) -> String {
        String::from_utf8(self.0.stdout.clone()).unwrap()
    }

    pub fn stderr(&self) -> String {
        String::from_utf8(self.0.stderr.clone()).unwrap()
    }

    /// The lines that report an error.
    pub fn errors(&self) -> Vec<String> {
        self.stderr().lines().filter(|line| line.starts_with("error:")).map(String::from).collect()
    }
}

/// The project's shared test scenes, when they are there.
pub fn shared(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(path);
    found.exists().then_some(found)
}
