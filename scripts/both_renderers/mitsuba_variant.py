"""Mitsuba's variant that all modules use; they take `mi` and `dr` from here.

Mitsuba needs a libLLVM of version 17 or later (older ones stop with "Cannot select … fminimum"). Unless
DRJIT_LIBLLVM_PATH names one, the one in the Rust toolchain is taken.
"""

import glob
import os
import subprocess


def rust_llvm():
    """The libLLVM of the Rust toolchain, where there is one."""
    try:
        told = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return []
    return sorted(glob.glob(os.path.join(told.stdout.strip(), "lib", "libLLVM.so.*")))


# It is looked for once, when Mitsuba is imported.
for found in rust_llvm()[:1]:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", found)
import drjit as dr  # noqa: E402, F401
import mitsuba as mi  # noqa: E402

mi.set_variant("llvm_ad_rgb")
