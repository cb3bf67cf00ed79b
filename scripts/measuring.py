"""What scripts that measure one run of `tamis` share. Plain Python, no packages."""

import json
import os
import subprocess
import tempfile


def report_of(command):
    """What a command of `tamis` tells by `--json`."""
    return json.loads(subprocess.run([*command, "--json"], check=True, stdout=subprocess.PIPE).stdout)


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
