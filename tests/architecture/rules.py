#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The rules of the source tree that a compiler does not check. Standard library only.

  rules.py includes DIR          who may include whom
  rules.py macros DIR            no #if about CUDA outside physics/hd.hpp
  rules.py instantiations DIR    cuda/<module>/*.cu hold explicit instantiations and nothing else
  rules.py channels DIR          what a stage's bodies touch stands in its row of the stage table, and whether they
                                 step aside in pipeline/schedule.hpp
  rules.py map DIR               ARCHITECTURE.md names every formula header and stage, and functions where they stand; 150 lines
  rules.py sizes DIR             no folder holds more than 15 % of the library's lines, no function of src and cuda more than 40
  rules.py uses DIR              a file of src/ includes the header of each core:: function that it calls
  rules.py names DIR             no two bodies (kernels) have the same name
  rules.py symbols LIBRARY       the shared library exports names of meltsim only
  rules.py c_names ARCHIVE       the global names of C in an archive, which hosts link as a whole, begin with meltsim_
  rules.py headers DIR -- COMMAND...   every public header compiles alone; for nvcc together
  rules.py snippets DIR -- COMMAND...  the documents' C++ that starts with an #include compiles
  rules.py links DIR             links between documents lead to a file and a heading; paths that ARCHITECTURE.md names exist
  rules.py selftest              each rule finds what it is there to find

Every finding names file, line and rule. Exit code 1 when there is one.
"""
import concurrent.futures
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

MODULES = {"sph", "lsm", "thermal", "topology", "step", "surface", "sampling", "reading",
           "species"}  # they meet only in the channels of fields.def
# What every room may include; under src/. Rooms that are not named here are not there.
ROOMS = {"exec": {"exec"}, "shape": {"shape"}, "c_api": {"c_api"}, "frame": {"frame", "exec"},
         "pipeline": {"pipeline", "frame"}, "spatial": {"spatial", "pipeline", "frame", "exec"},
         "shared": {"shared", "spatial", "frame"}, "engine": {"engine", "pipeline", "frame", "exec", "spatial"},
         "description": {"description", "shape", "engine"},
         "world": {"world", "description", "engine", "pipeline", "frame", "exec", "shape"}, "trade": {"trade", "world", "engine"},
         **{room: {room, "world", "description", "engine", "pipeline", "frame", "exec", "shape"} for room in ("scene", "steering", "readout", "snapshot")},
         **{module: {module, "shared", "spatial", "pipeline", "frame", "exec"} for module in MODULES}}
SOURCE_SUFFIXES = {".hpp", ".cpp", ".cuh", ".cu", ".h", ".def"}

# Public headers may be included by a host that has none of these.
FORBIDDEN_IN_PUBLIC = re.compile(r"^(cuda|cub/|thrust/|cooperative_groups|Eigen/|iostream$|ostream$|istream$|omp\.h$|yaml-cpp|fmt/)")
INTEROP = "include/meltsim/cuda_interop.hpp"  # the one opt-in header that names CUDA
HOST_DEVICE = "include/meltsim/physics/hd.hpp"


def strip_comments(text):
    """Comments become blanks of the same number of lines; string literals stay."""
    pattern = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*.*?\*/', re.S)
    return pattern.sub(lambda m: m[0] if m[0][0] in "\"'" else "\n" * m[0].count("\n") or " ", text)


def sources(root, *directories):
    for directory in directories:
        for path in sorted((root / directory).rglob("*")):
            if path.suffix in SOURCE_SUFFIXES and path.is_file():
                yield path


def includes_of(path):
    for number, line in enumerate(strip_comments(path.read_text()).splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*([<"])([^">]+)[>"]', line)
        if match:
            yield number, match[2]


def module_of(path, root):
    """src/sph/x.hpp -> sph, cuda/sph/x.cu -> sph; None elsewhere."""
    parts = path.relative_to(root).parts
    return parts[1] if parts[0] in ("src", "cuda") and len(parts) > 2 else None


def check_includes(root):
    for path in sources(root, "src", "cuda"):
        module = module_of(path, root)
        if module is None:
            continue
        if module not in ROOMS:
            yield f"{path.relative_to(root)}: no rule says what {module} may include"
        for number, target in includes_of(path):
            parts = [p for p in target.split("/") if p not in (".", "..", "src", "cuda")]
            other = parts[0] if len(parts) > 1 else module
            if module in MODULES and other in MODULES and other != module:
                yield f"{path.relative_to(root)}:{number}: module {module} includes {target} of module {other}"
            elif other in ROOMS and other not in ROOMS.get(module, set()) and path.relative_to(root).parts[0] == "src":
                yield f"{path.relative_to(root)}:{number}: {module} includes {target} of {other}"
            if path.relative_to(root).parts[0] == "src" and re.match(r"(cuda|cub/|thrust/)", target):
                yield f"{path.relative_to(root)}:{number}: {target} belongs under cuda/"
            if target.startswith("Eigen/"):
                yield f"{path.relative_to(root)}:{number}: {target}: Eigen is for tests"
    for path in sources(root, "include"):
        name = path.relative_to(root).as_posix()
        for number, target in includes_of(path):
            if FORBIDDEN_IN_PUBLIC.match(target) and name != INTEROP:
                yield f"{name}:{number}: public header includes {target}"
            if not target.startswith("meltsim/") and "/" in target:
                if not (name == INTEROP or FORBIDDEN_IN_PUBLIC.match(target)):
                    yield f"{name}:{number}: public header includes {target}, which is not public"


def check_macros(root):
    for path in sources(root, "include", "src", "cuda"):
        name = path.relative_to(root).as_posix()
        if name == HOST_DEVICE:
            continue
        for number, line in enumerate(strip_comments(path.read_text()).splitlines(), 1):
            if re.match(r"\s*#\s*(el)?if.*(CUDA|NVCC)", line):
                yield f"{name}:{number}: {line.strip()}: backends are chosen by CMake and at run time"


# What an instantiation file may consist of, statement by statement.
ALLOWED_STATEMENTS = (
    re.compile(r"^(inline )?namespace( [\w:]+)? ?\{$"),
    re.compile(r"^\}$"),
    re.compile(r"^(extern )?template (?!<)[^{}]*;$"),       # explicit instantiation, not a template
    re.compile(r"^using [\w:, <>=]+;$"),
    re.compile(r"^[A-Z][A-Z0-9_]* ?\([\w:, <>]*\);?$"),     # a macro that lists instantiations
    re.compile(r"^;$"),
)


def check_instantiations(root):
    cuda = root / "cuda"
    for path in sorted(cuda.rglob("*.cu")):
        if module_of(path, root) in (None, "exec", "engine"):
            continue  # cuda/exec implements the verbs, cuda/engine makes the backend
        name = path.relative_to(root).as_posix()
        text = strip_comments(path.read_text()).replace("\\\n", " ")
        # Preprocessor: includes, and macros that instantiate.
        lines = []
        for number, line in enumerate(text.splitlines(), 1):
            if line.lstrip().startswith("#"):
                directive = line.lstrip()[1:].split()[0]
                if directive not in ("include", "pragma", "define", "undef"):
                    yield f"{name}:{number}: #{directive} in an instantiation file"
                if directive == "define":
                    body = re.sub(r"^\s*#\s*define\s+\w+(\([^)]*\))?", "", line)
                    lines.append((number, body))
            else:
                lines.append((number, line))
        statement, start = "", None
        for number, line in lines:
            for token in re.split(r"(?<=[;{}])", line):
                if token.strip() and start is None:
                    start = number
                statement = f"{statement} {token.strip()}".strip()
                if not statement:
                    continue
                macro = ALLOWED_STATEMENTS[4].match(statement)
                if statement[-1] in ";{}" or macro:
                    text_of = re.sub(r"\s+", " ", statement)
                    if not any(p.match(text_of) for p in ALLOWED_STATEMENTS):
                        yield (f"{name}:{start}: \"{text_of[:80]}\": only includes, namespaces and explicit "
                               "instantiations; formulas go to include/meltsim/physics, bodies to src/<module>")
                    statement, start = "", None
        if statement:
            yield f"{name}:{start}: \"{statement[:80]}\" is not an explicit instantiation"


def definitions(text):
    """name -> text of every struct and function at the left margin."""
    found = {}
    for pattern in (r"^(?:struct|class) (\w+)[^;\n]*\{\n(.*?)^\};",
                    r"^(?=\S)(?!struct|class|namespace|inline namespace|#)[^\n;{}]*?\b(\w+)\([^;{}]*\)\s*(?:const )?\{\n(.*?)^\}"):
        for match in re.finditer(pattern, text, re.M | re.S):
            found[match[1]] = found.get(match[1], "") + match[0]
    return found


def check_channels(root):
    """Stages run side by side where the table says that they may (pipeline/schedule.hpp), so it has to be complete."""
    fields = set(re.findall(r"^MELTSIM_(?:FIELD|PARTICLE_STATE|VERTEX_STATE)\((\w+),", (root / "include/meltsim/fields.def").read_text(), re.M))
    table = root / "src/pipeline/pipeline.def"
    # Parts of channels; that a row names the right one, the tests of permuted orders show.
    parts = root / "src/pipeline/pipeline.hpp"
    wholes = dict(re.findall(r"\{field_(\w+), field_(\w+)\}", parts.read_text() if parts.is_file() else ""))
    rows = re.findall(r'^MELTSIM_STAGE\((\w+), (\w+), [^,]+, (.*?), "', table.read_text(), re.M)
    if not rows:
        yield "no stage found: the pattern is broken"
    schedule = root / "src/pipeline/schedule.hpp"
    found = re.search(r"\bmodest_stages\s*=([^;]*);", schedule.read_text() if schedule.is_file() else "")
    modest = set(re.findall(r"\bstage_bit\((\w+)\)", found[1])) if found else set()
    for module, stage, sets in rows:
        known = {}
        for path in sorted({*(root / "src" / module).glob("*.hpp"), root / "src/spatial/neighbours.hpp",
                            root / "src/shared/pair_forces.hpp", root / "src/shared/tension_forces.hpp"}):
            if path.is_file():
                for name, text in definitions(strip_comments(path.read_text())).items():
                    known[name] = known.get(name, "") + text
        stages = {other for m, other, _ in rows if m == module}
        todo, seen, text = [stage], set(), ""
        while todo:
            name = todo.pop()
            if name in seen or name not in known:
                continue
            seen.add(name)
            text += known[name]
            todo += [word for word in re.findall(r"\b([A-Za-z_]\w+)\b(?=[<({])", known[name])
                     if word not in stages]
        if not text:
            yield f"{module}.{stage}: no function found in src/{module}/stages.hpp"
        # What every kernel asks, pipeline/schedule.hpp knows.
        text = text.replace("w_.f.status->halted", "")
        touched = (set(re.findall(r"\bf\.(\w+)", text)) | set(re.findall(r"\bbefore\.(\w+)", text))) & fields
        named = {wholes.get(name, name) for name in re.findall(r"F\((\w+)\)", sets)}
        for name in sorted(touched - named):
            yield f"{table.relative_to(root)}: {module}.{stage} touches {name}, which its row does not name"
        # Stages that step aside (pipeline/schedule.hpp) run on few threads only where their bodies say so, too.
        aside = f"stage_{module}_{stage}" in modest
        for body in re.findall(r"\bfor_each\([^;]*?\b(\w+Body)<", known.get(stage, "")):
            if ("bool modest = true" in known.get(body, "")) != aside:
                yield (f"src/{module}: {body} is {'not ' if aside else ''}modest, its stage {module}.{stage} is "
                       f"{'' if aside else 'not '}one of modest_stages")


MOST_OF_A_FOLDER = 0.15   # of all lines of include/, src/ and cuda/: a larger one hides rooms
MOST_OF_A_FUNCTION = 40   # lines in src/ and cuda/: one screen


def functions(text):
    """(first line, lines, name) of every function definition, found by its braces; inner ones belong to the outer one."""
    text = re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', '""', strip_comments(text))
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda m: "\n" * m[0].count("\n"), text, flags=re.M)
    head, begin, line, open_blocks = "", 1, 1, []
    for c in text:
        if c == "{":
            name = re.search(r"([~\w]+|operator\W+)\s*\([^{}]*\)\s*(const|noexcept|override|\s)*(->[^{}]*|:[^{}]*)?$", head.strip())
            inside = any(b[0] for b in open_blocks)
            open_blocks.append((name[1] if name and not inside and "=" not in head.split("(")[0] else "", begin))
            head = ""
        elif c == "}" and open_blocks:
            name, first = open_blocks.pop()
            if name:
                yield first, line - first + 1, name
            head = ""
        elif c == ";":
            head = ""
        else:
            if not head.strip() and not c.isspace():
                begin = line
            head += c
        line += c == "\n"


def check_sizes(root):
    lines = {}
    for path in sources(root, "include", "src", "cuda"):
        lines[path.parent] = lines.get(path.parent, 0) + path.read_text().count("\n")
    total = sum(lines.values())
    for folder, count in lines.items():
        if count > MOST_OF_A_FOLDER * total:
            yield f"{folder.relative_to(root)}: {count} of {total} lines, more than {MOST_OF_A_FOLDER:.0%}: find the rooms in it"
    found = 0
    for path in sources(root, "src", "cuda"):
        for first, count, name in functions(path.read_text()):
            found += 1
            if count > MOST_OF_A_FUNCTION:
                yield f"{path.relative_to(root)}:{first}: {name} has {count} lines, more than {MOST_OF_A_FUNCTION}"
    if found == 0:
        yield "no function found: the pattern is broken"


def check_names(root):
    seen = {}
    for path in sources(root, "src", "cuda"):
        for name in re.findall(r"\bstruct (\w+Body)\b(?!\s*[;<])", strip_comments(path.read_text())):
            where = path.relative_to(root)
            if name in seen:
                yield f"{where}: {name} is also a body of {seen[name]}: whoever searches for it finds two"
            seen[name] = where


# Functions of C that read and write numbers as the locale of the process says, with a comma in many; std::to_string(double) is one of
# them, and cannot be told from that of a whole number here.
OF_THE_LOCALE = re.compile(r"\bstd::(?:stod|stof|stold|strtod|strtof|atof|sscanf|localeconv)\b|\bimbue\b|"
                           r"printf\([^;]*%[-+ #0-9.*]*[aefgAEFG]")


def check_locale(root):
    """A host may have set any locale: what is read, written and said must not depend on it."""
    for path in sources(root, "include", "src", "cuda", "examples/runner", "python/src"):
        text = strip_comments(path.read_text())
        for found in OF_THE_LOCALE.finditer(text):
            line = text.count("\n", 0, found.start()) + 1
            yield f"{path.relative_to(root)}:{line}: {found.group(0)[:40]!r} reads or writes numbers by the locale of the host: use std::from_chars or std::to_chars"


def check_uses(root):
    """Files are compiled eight at a time (cmake/MeltsimPrecompile.cmake): one that leans on what another included fails in a
    build that groups them in another way."""
    where = {}
    for path in sources(root, "src"):
        text = strip_comments(path.read_text())
        if path.suffix == ".hpp" and "namespace core" in text:
            for name in definitions(text):
                where.setdefault(name, set()).add(path.resolve())
    reached = {}

    def reach(path):
        if path not in reached:
            reached[path] = {path}  # first, for headers that include each other
            for _, target in includes_of(path):
                for base in (path.parent, root / "src"):
                    if (base / target).is_file():
                        reached[path] |= reach((base / target).resolve())
                        break
        return reached[path]

    if not where:
        yield "no function found: the pattern is broken"
    for path in sources(root, "src"):
        if path.suffix == ".cpp":
            for name in sorted(set(re.findall(r"\bcore::(\w+)[(<]", strip_comments(path.read_text()))) & set(where)):
                if not where[name] & reach(path.resolve()):
                    yield f"{path.relative_to(root)}: calls core::{name} and does not include {min(where[name]).relative_to(root.resolve())}"


def check_symbols(library):
    listing = subprocess.run(["nm", "-D", "--defined-only", "-C", str(library)], check=True,
                             capture_output=True, text=True).stdout
    count = 0
    for line in listing.splitlines():
        # "address type name"; version nodes ("name@@VERS") do not occur: the script has no version name
        parts = line.split(maxsplit=2)
        if len(parts) < 3 or parts[1] == "A":
            continue
        name = parts[2]
        count += 1
        if not re.match(r"((vtable|typeinfo|typeinfo name|VTT) for )?meltsim::|meltsim_\w+$", name):
            yield f"exports {name}"
        elif re.search(r"meltsim_cub|\b(cub|thrust)::|cuda[A-Z]", name):
            yield f"exports {name}: CUDA plumbing"
    if count == 0:
        yield "exports nothing: the version script matches no name"
    for forbidden in ("libcudart", "libcuda.so"):
        dynamic = subprocess.run(["readelf", "-d", str(library)], check=True, capture_output=True, text=True).stdout
        if forbidden in dynamic:
            yield f"needs {forbidden} at run time"


def check_c_names(archive):
    listing = subprocess.run(["nm", "-g", "--defined-only", str(archive)], check=True, capture_output=True,
                             text=True).stdout
    # Weak ones are no clash: the linker keeps one of them, as headers that hosts include too (NVTX) mean it.
    names = {parts[2] for parts in (line.split() for line in listing.splitlines()) if len(parts) == 3 and parts[1] not in "VWu"}
    ours = {name for name in names if name.startswith("meltsim_")}
    for name in sorted(names - ours):
        if not re.match(r"_Z|DW\.ref\._|__|_GLOBAL_", name):  # C++, and what compilers make for it
            yield f"defines {name}"
    if not ours:
        yield "defines no name of C: not the library's archive"


def check_headers(root, command):
    """command is a compiler with flags; a file with #includes is appended. nvcc takes a second for each file: it compiles its
    own header alone, and all others, which a host's compiler takes alone, together."""
    headers = [p.relative_to(root / "include").as_posix() for p in sources(root, "include") if p.suffix == ".hpp"]
    cuda = "nvcc" in Path(command[0]).name
    own = INTEROP[len("include/"):]
    others = [h for h in headers if h != own]
    units = [[own], others] if cuda and own in headers else [others] if cuda else [[h] for h in others]

    def compile_unit(names):
        with tempfile.TemporaryDirectory() as directory:
            unit = Path(directory) / ("alone.cu" if cuda else "alone.cpp")
            # Twice: an include guard that is missing shows up too.
            unit.write_text("".join(f'#include "{name}"\n' for name in names * 2))
            done = subprocess.run([*command, "-I", str(root / "include"), str(unit)], cwd=directory,
                                  capture_output=True, text=True)
            return names, done

    with concurrent.futures.ThreadPoolExecutor(max_workers=len(os.sched_getaffinity(0))) as pool:
        for names, done in pool.map(compile_unit, units):
            if done.returncode:
                what = f"{names[0]} does not compile alone" if len(names) == 1 else "the public headers do not compile together"
                yield f"{what}:\n{done.stdout}{done.stderr}"
    print(f"{len(headers)} headers, {' '.join(command)}")


def documents(root):
    return [*sorted(root.glob("*.md")), *sorted((root / "docs").rglob("*.md"))]


def without_code(text):
    """Fenced blocks become blank lines; spans of code stay."""
    return re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), text, flags=re.S | re.M)


def anchors_of(text):
    """The anchors that GitHub and myst give to headings."""
    found = set()
    for title in re.findall(r"^#{1,6} +(.*?) *$", without_code(text), re.M):
        anchor = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title).lower()).replace(" ", "-")
        while anchor in found:
            anchor += "-1"
        found.add(anchor)
    return found


def check_links(root):
    count = 0
    for document in documents(root):
        name = document.relative_to(root)
        for number, line in enumerate(without_code(document.read_text()).splitlines(), 1):
            for target in re.findall(r"\]\(([^()\s]+)\)", re.sub(r"`[^`]*`", "", line)):
                if re.match(r"\w+:", target):
                    continue  # elsewhere in the world
                count += 1
                path, _, anchor = target.partition("#")
                file = document.parent / path if path else document
                if not file.exists():
                    yield f"{name}:{number}: {target} leads to no file"
                elif anchor and file.suffix == ".md" and anchor not in anchors_of(file.read_text()):
                    yield f"{name}:{number}: {target} leads to no heading"
            if name.as_posix() != "ARCHITECTURE.md":
                continue
            for path in re.findall(r"`((?:src|include|cuda|tests|examples|docs|benchmarks|cmake)/[\w./-]+)`", line):
                count += 1
                if not (root / path).exists():
                    yield f"{name}:{number}: there is no {path}"
    if count == 0:
        yield "no link found: the pattern is broken"


LINES_OF_THE_MAP = 150  # as much as a reader takes in at once


def check_map(root):
    text = (root / "ARCHITECTURE.md").read_text()
    if text.count("\n") > LINES_OF_THE_MAP:
        yield f"ARCHITECTURE.md: {text.count(chr(10))} lines, more than {LINES_OF_THE_MAP}"
    for path in sources(root, "include/meltsim/physics"):
        if f"`{path.name}`" not in text and path.name not in ("hd.hpp", "math.hpp", "elementary.hpp", "material_table.hpp"):
            yield f"ARCHITECTURE.md: does not say what {path.name} is for"
    count = 0
    for file, names in re.findall(r"`([\w/]+\.[ch]pp)`(?::|,) ((?:`\w+`(?:, )?)+)", text):
        path = root / file if "/" in file else root / "include/meltsim/physics" / file
        for name in re.findall(r"\w+", names) if path.exists() else []:
            count += 1
            if not re.search(rf"\b{name}\b *[(<{{]", strip_comments(path.read_text())):
                yield f"ARCHITECTURE.md: there is no {name} in {file}"
    table = root / "src/pipeline/pipeline.def"
    for module, stage in re.findall(r"^MELTSIM_STAGE\((\w+), (\w+)", table.read_text() if table.exists() else "", re.M):
        if module != "spatial" and f"`{stage}`" not in text and f"`{module}.{stage}`" not in text:
            yield f"ARCHITECTURE.md: does not name the stage {module}.{stage}"
    if count == 0:
        yield "no function found in ARCHITECTURE.md: the pattern is broken"


def check_snippets(root, command):
    count = 0
    for document in documents(root):
        for block in re.finditer(r"^```cpp\n(.*?)^```", document.read_text(), re.S | re.M):
            if not block[1].startswith("#include"):
                continue  # a fragment
            count += 1
            with tempfile.TemporaryDirectory() as directory:
                unit = Path(directory) / "snippet.cpp"
                unit.write_text(block[1])
                done = subprocess.run([*command, "-I", str(root / "include"), str(unit)], capture_output=True, text=True)
                if done.returncode:
                    yield f"{document.relative_to(root)}: this does not compile:\n{block[1]}\n{done.stderr}"
    print(f"{count} snippets")
    if count == 0:
        yield "no snippet found: the pattern is broken"


def selftest():
    """A tree with one violation of each kind: a rule that finds nothing is broken."""
    with tempfile.TemporaryDirectory() as directory:
        root = Path(directory)

        def write(name, text):
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

        def findings(check, name, text):
            write(name, text)
            found = list(check(root))
            (root / name).unlink()
            return len(found)

        good = ('// F = m a; fine in a comment\n#include "sph/stages.hpp"\nnamespace meltsim {\ninline namespace v0 {\n'
                'template class Stage<CudaExec, float>;\ntemplate void run<double>(int,\n    int);\n}\n}\n')
        cases = [
            (check_includes, "src/sph/a.hpp", '#include "lsm/bodies.hpp"\n', 1),
            (check_includes, "src/sph/a.hpp", '#include "../lsm/bodies.hpp"\n', 1),
            (check_includes, "src/sph/a.hpp", '// #include "lsm/bodies.hpp"\n', 0),
            (check_includes, "src/sph/a.hpp", '#include "exec/exec_cpu.hpp"\n#include "spatial/grid.hpp"\n', 0),
            (check_includes, "src/spatial/a.hpp", '#include "sph/bodies.hpp"\n', 1),
            (check_includes, "cuda/thermal/a.cu", '#include "topology/stages.hpp"\n', 1),
            (check_includes, "src/engine/a.cpp", '#include <cuda_runtime.h>\n', 1),
            (check_includes, "src/engine/a.cpp", '#include "world/world_impl.hpp"\n', 1),
            (check_includes, "src/shape/a.cpp", '#include "frame/frame.hpp"\n', 1),
            (check_includes, "src/world/a.cpp", '#include "frame/frame.hpp"\n#include <vector>\n', 0),
            (check_includes, "include/meltsim/a.hpp", '#include <iostream>\n', 1),
            (check_includes, "include/meltsim/a.hpp", '#include <cub/device/device_scan.cuh>\n', 1),
            (check_includes, "include/meltsim/a.hpp", '#include <vector>\n#include "meltsim/b.hpp"\n', 0),
            (check_includes, INTEROP, '#include <cuda_runtime_api.h>\n', 0),
            (check_macros, "src/engine/a.cpp", "#ifdef MELTSIM_HAVE_CUDA\n#endif\n", 1),
            (check_macros, "include/meltsim/a.hpp", "#if defined(__CUDACC__)\n#endif\n", 1),
            (check_macros, HOST_DEVICE, "#if defined(__CUDACC__)\n#endif\n", 0),
            (check_links, "docs/a/b.md", "# A title\n[here](b.md#a-title) [up](../../include/meltsim/fields.def)\n", 0),
            (check_links, "docs/a/b.md", "[gone](c.md)\n", 1),
            (check_links, "docs/a/b.md", "# A title\n```sh\n# no title\n```\n[here](#no-title)\n", 1),
            (check_links, "ARCHITECTURE.md", "`src/sph/gone.hpp`\n", 1),
            (check_instantiations, "cuda/sph/a.cu", good, 0),
            (check_instantiations, "cuda/sph/a.cu", good + "__global__ void k(float* a) { a[0] *= 2; }\n", 3),
            (check_instantiations, "cuda/sph/a.cu", "template <class T> T f(T a) { return a * a; }\n", 3),
            (check_instantiations, "cuda/sph/a.cu", "constexpr float g = 9.81f;\n", 1),
            (check_instantiations, "cuda/exec/a.cu", "__global__ void k() {}\n", 0),
        ]
        write("include/meltsim/fields.def", "MELTSIM_FIELD(mass, T, particle, State, \"kg\", \"\")\n"
                                            "MELTSIM_FIELD(tag, T, particle, State, \"-\", \"\")\n")
        write("src/pipeline/pipeline.def", 'MELTSIM_STAGE(sph, density, 0, F(tag), 0, 0, "", "")\n')
        write("src/sph/stages.hpp", "void density(E& ex) {\n  ex.for_each(1, DensityBody<T>{w});\n}\n")
        body = "struct DensityBody {\n  void part() {\n    weigh(w);\n  }\n};\nT weigh(F w) {\n  return w.f.%s[0];\n}\n"
        modest = body.replace("{\n", "{\n  static constexpr bool modest = true;\n", 1)
        cases += [(check_channels, "src/sph/bodies.hpp", body % "tag", 0),
                  (check_channels, "src/sph/bodies.hpp", body % "mass", 1),
                  (check_channels, "src/sph/bodies.hpp", modest % "tag", 1)]
        # Seven folders of the same size are each below 15 %, one twice as large is not.
        for k in range(7):
            write(f"include/room{k}/a.hpp", "int f(int a) {\n  return a;\n}\n" * 100)
        short, long = "int g(int a) {\n" + "  ++a;\n" * 38 + "}\n", "int g(int a) {\n" + "  ++a;\n" * 39 + "}\n"
        cases += [(check_sizes, "src/engine/a.hpp", short, 0), (check_sizes, "src/engine/a.hpp", long, 1),
                  (check_sizes, "src/engine/a.hpp", "struct A {\n" + "  int b;\n" * 50 + short.replace("g(", "A::g(") + "};\n", 0),
                  (check_sizes, "src/engine/a.hpp", short + "// a line\n" * 600, 1)]
        write("include/meltsim/physics/force.hpp", "int force(int a) {\n  return a;\n}\n")
        cases += [(check_map, "ARCHITECTURE.md", "`force.hpp`: `force`; `sph.density`\n", 0),
                  (check_map, "ARCHITECTURE.md", "`force.hpp`: `forces`; `sph.density`\n", 1),
                  (check_map, "ARCHITECTURE.md", "`force.hpp`: `force`\n", 1),
                  (check_map, "ARCHITECTURE.md", "`src/engine/a.hpp`: `f`\n" + "a line\n" * 150, 4)]
        write("src/sph/other.hpp", "struct OneBody {};\nstruct OtherBody;\n")
        cases += [(check_names, "src/engine/a.hpp", "struct OtherBody {};\n", 0),
                  (check_names, "src/engine/a.hpp", "// struct OneBody {};\nstruct OneBody {};\n", 1)]
        cases += [(check_locale, "src/engine/b.cpp", 'auto x = std::stod(text);\n', 1),
                  (check_locale, "src/engine/b.cpp", 'std::snprintf(text, sizeof text, "%s %.6g",\n a, b);\n', 1),
                  (check_locale, "src/engine/b.cpp", '// std::stod\nstd::snprintf(text, sizeof text, "%-22s %5d", a, b);\n', 0)]
        write("src/engine/held.hpp", "namespace core {\nint held(int a) {\n  return a;\n}\n}\n")
        write("src/engine/all.hpp", '#include "engine/held.hpp"\n')
        cases += [(check_uses, "src/engine/b.cpp", "int b = core::held(1);\n", 1),
                  (check_uses, "src/engine/b.cpp", '#include "all.hpp"\nint b = core::held(1) + core::other(2);\n', 0)]
        broken = 0
        for check, name, text, expected in cases:
            found = findings(check, name, text)
            if (found > 0) != (expected > 0):
                broken += 1
                print(f"{check.__name__} found {found} in {name}, expected {expected}:\n{text}")
        print(f"{len(cases)} cases, {broken} wrong")
        return 1 if broken else 0


def main(arguments):
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 2
    rule, rest = arguments[0], arguments[1:]
    if rule == "selftest":
        return selftest()
    if rule in ("headers", "snippets"):
        check = check_headers if rule == "headers" else check_snippets
        found = list(check(Path(rest[0]).resolve(), rest[rest.index("--") + 1:]))
    else:
        checks = {"includes": check_includes, "macros": check_macros, "instantiations": check_instantiations,
                  "channels": check_channels, "links": check_links, "map": check_map, "sizes": check_sizes,
                  "names": check_names, "locale": check_locale, "uses": check_uses, "symbols": check_symbols, "c_names": check_c_names}
        found = list(checks[rule](Path(rest[0]).resolve()))
    for line in found:
        print(line)
    print(f"{rule}: {len(found)} finding(s)")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
