"""What scripts that run `tamis` share. Plain Python, no packages."""

import json
import os
import subprocess
import sys
import tempfile


def call(command, **options):
    """Runs a command to its end; one that fails has said why, and ends the script, too."""
    try:
        outcome = subprocess.run(command, **options)
    except OSError as error:
        sys.exit(f"{command[0]}: cannot be run: {error.strerror} (cargo build makes tamis, --tamis says where it is)")
    if outcome.returncode != 0:
        sys.exit(f"{command[0]} {command[1]} ended with {outcome.returncode}")
    return outcome


def report_of(command):
    """What a command of `tamis` tells by `--json`."""
    return json.loads(call([*command, "--json"], stdout=subprocess.PIPE).stdout)


def run(parser, measure):
    """Calls `measure` with the options and a folder to write to, which is kept only if it was asked for."""
    parser.add_argument("--folder", help="where files are written, and kept; a temporary one by default")
    parser.add_argument("--tamis", default="target/debug/tamis")
    options = parser.parse_args()
    if options.folder:
        os.makedirs(options.folder, exist_ok=True)
        return measure(options, options.folder)
    with tempfile.TemporaryDirectory() as folder:
        return measure(options, folder)
