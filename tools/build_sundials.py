"""Build the SUNDIALS module of the benchmarks next to its source; ``make peers`` runs this.

Needs Cython, a C compiler, and the headers and libraries of SUNDIALS (Debian's libsundials-dev).
"""

import os
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "benchmarks" / "other_codes" / "_sundials.pyx"
MODULE = "benchmarks.other_codes._sundials"
LIBRARIES = ("sundials_cvode", "sundials_arkode", "sundials_nvecserial",
             "sundials_sunnonlinsolfixedpoint")  # fmt: skip


def main() -> None:
    """Translate the source to C and compile it; ``CC``, ``CFLAGS`` and ``LDFLAGS`` are used."""
    folder = ROOT / "build"
    folder.mkdir(exist_ok=True)
    c_file = folder / "sundials.c"
    target = SOURCE.with_name(f"_sundials{sysconfig.get_config_var('EXT_SUFFIX')}")
    cython = [sys.executable, "-m", "cython", "-3", "--fast-fail", "--module-name", MODULE]
    subprocess.run([*cython, str(SOURCE), "-o", str(c_file)], check=True)
    flags = {name: shlex.split(os.environ.get(name, "")) for name in ("CFLAGS", "LDFLAGS")}
    compiler = shlex.split(os.environ.get("CC", "cc"))
    headers = [f"-I{sysconfig.get_path('include')}"]
    headers += [f"-I{ROOT / 'ancfsparse' / part}" for part in ("abi", "kernels")]
    libraries = [f"-l{name}" for name in LIBRARIES]
    subprocess.run(
        [*compiler, "-O2", "-shared", "-fPIC", *flags["CFLAGS"], *headers, str(c_file),
         *flags["LDFLAGS"], *libraries, "-o", str(target)],
        check=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
