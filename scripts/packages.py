"""Says in one line which packages a script lacks, where `import` would print a traceback."""

import importlib.util
import sys

# Names for pip that are not those to import.
FOR_PIP = {"OpenEXR": "openexr", "PIL": "pillow"}


def need(description, *modules):
    """Ends the script where one of `modules` is not installed; asked for help, it still says what it does."""
    missing = [module for module in modules if importlib.util.find_spec(module) is None]
    if not missing:
        return
    wanted = " ".join(FOR_PIP.get(module, module) for module in missing)
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(description.strip())
        print(f"\n(pip install {wanted}: then --help lists the options, too)")
        sys.exit(0)
    sys.exit(f"{sys.argv[0]} needs packages that are not installed: pip install {wanted}")
