"""Collects the pages of the site: those that stand in the project, at their places, with the files that
they link to; and those that are generated from the programs, the examples of keys and the refusals.

    collect.py BIN DOCS        run from the root of the project
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

PAGES = ["README.md", "configs/README.md", "configs/cases/README.md", "configs/measured/README.md",
         "configs/tutorial/*.md",
         "autodiff/README.md", "tools/bench/README.md", "tools/site/pages/*.md",
         "tools/python/README.md", "CHANGELOG.md", "CONTRIBUTING.md"]
PROGRAMS = ["train", "eval", "solve", "show", "export", "control", "check", "fit", "law", "residual",
            "cases", "bench"]
LINK = re.compile(r'(\]\(|<img src=")([^)"#]+)')


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def for_mkdocs(text):
    """What GitHub and mkdocs write differently: files that blocks of code stand in."""
    return re.sub(r"^```(\w+) (\S+)$", r'```\1 title="\2"', text, flags=re.M)


def copy_file(file, docs):
    (docs / file).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(file, docs / file)


def copy_page(page, docs, generated):
    text = page.read_text()
    for name, lines in generated.items():
        text = text.replace(f"<!-- generated: {name} -->", lines)
    for _, link in LINK.findall(text):
        file = pathlib.Path(os.path.normpath(page.parent / link))
        if "://" not in link and file.is_file() and file.suffix != ".md":
            copy_file(file, docs)
    write(docs / page, for_mkdocs(text))


def help_of(program, bin_folder):
    return subprocess.run([f"{bin_folder}/{program}", "--help"], check=True, capture_output=True,
                          text=True).stdout


# ---- keys ----------------------------------------------------------------------------------------

def read_keys(text):
    """Of cpinn-train --help: {path: {type, range, unit, default, only, help}}."""
    keys = {}
    key = None
    for line in text[text.index("\nKeys of"):text.index("\nformulas\n")].split("\n"):
        row = re.match(r"  (\S+): (.*?)(?:; (required|default: .*?))?(?:; ([a-z_, ]+) only)?$", line)
        if row:
            path, allowed, default, only = row.groups()
            allowed, _, unit = allowed.partition(", in ")
            split = re.match(r"(.*?(?:numbers?|formulas?)) (-?\d.*|[<>].*|or \.inf)$", allowed)
            key = {"type": split[1] if split else allowed, "range": split[2] if split else "",
                   "unit": unit, "default": (default or "none").replace("default: ", ""),
                   "only": only or "", "help": ""}
            keys[path] = key
        elif key and line.startswith("      "):
            key["help"] += (" " if key["help"] else "") + line.strip()
    return keys


def read_examples(file):
    """{path: (scene, value, key as it is given)}, of tools/site/examples.txt."""
    examples = {}
    for line in file.read_text().split("\n"):
        if line.startswith("scene "):
            scene = shlex.split(line)[1]
        elif line and not line.startswith("#"):
            key, value = line.split(" = ", 1)
            examples[re.sub(r"\[\d+\]", "[]", key)] = (scene, value)
    return examples


def as_yaml(path, value):
    lines, indent, dash = [], 0, ""
    for part in path.replace("<name>", "load").split("."):
        lines.append(f"{' ' * indent}{dash}{part.removesuffix('[]')}:")
        indent += 2 + len(dash)
        dash = "- " if part.endswith("[]") else ""
    return "\n".join(lines) + f" {value}"


def key_pages(keys, examples, docs):
    sections = {}
    for path in keys:
        first = re.match(r"\w+", path)[0]
        sections.setdefault(first if first != path else "general", []).append(path)
    for section, paths in sections.items():
        text = [f"# Keys: {section}\n"]
        for path in paths:
            key = keys[path]
            text.append(f"## `{path}`\n\n{key['help']}\n")
            row = [key["type"], key["unit"] or "none", key["default"], key["range"] or "any"]
            text.append("| value | unit | default | range |\n|---|---|---|---|\n"
                        f"| {' | '.join(row)} |\n".replace("<", "&lt;"))
            if key["only"]:
                text.append(f"Only for {key['only']}.\n")
            example = examples.get(path) or examples.get(path.replace("segments[]", "rod"))
            if example:
                scene, value = example
                text.append(f"Example, for [{scene}](../{scene}):\n\n"
                            f"```yaml\n{as_yaml(path, value)}\n```\n")
                copy_file(pathlib.Path(scene), docs)
        write(docs / f"keys/{section}.md", "\n".join(text))
    index = ["# Keys of a scene\n", "Every key with its unit, default, range and an example. The pages are "
             "generated from the table of keys that the reader of scenes uses, and the tests check that the "
             "reader takes each example.\n", "| section | keys |\n|---|---|"]
    for section, paths in sections.items():
        names = ", ".join(f"`{path}`" for path in paths)
        index.append(f"| [{section}]({section}.md) | {names} |")
    write(docs / "keys/index.md", "\n".join(index) + "\n")


# ---- refusals ------------------------------------------------------------------------------------

# Refusals of plain mistakes, which say nothing of what the program can do.
MISTAKES = re.compile(r"missing|is (?:a |not |-?\d|\.inf|circle|solve|zero|too|farther)|column|unknown key|"
                      r"must be|no such|depends on|.* beyond|given beside|the list is|neither|it ends|"
                      r".* out of range|/nothing")


def refusals():
    """The lines with which tests/helpers/config_refusals_*.h expects scenes to be refused, by section."""
    rows = {}
    for name in ["scene", "beam", "lists"]:
        source = pathlib.Path(f"tests/helpers/config_refusals_{name}.h").read_text()
        for parts in re.findall(r'(?:"(?:[^"\\]|\\.)*"\s*)+', source):
            line = "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', parts)).replace('\\"', '"')
            found = re.match(r"(?:scene\.yaml(?::\d+)*|--set [^:]*): (\S+): (.*)", line)
            if found and "\\n" not in line and not MISTAKES.match(found[2]):
                rows.setdefault(re.match(r"\w*", found[1])[0], {})[found[1] + found[2]] = found.groups()
    text = []
    for section in sorted(rows):
        text.append(f"### {section}\n\n| key | refusal |\n|---|---|")
        for key, line in rows[section].values():
            text.append(f"| `{key}` | {line} |".replace("<", "&lt;"))
        text.append("")
    return "\n".join(text)


def main(bin_folder, docs):
    docs = pathlib.Path(docs)
    help_texts = {name: help_of(f"cpinn-{name}", bin_folder) for name in PROGRAMS}
    generated = {"refusals": refusals()}
    for pattern in PAGES:
        for page in sorted(pathlib.Path().glob(pattern)):
            copy_page(page, docs, generated)
    key_pages(read_keys(help_texts["train"]), read_examples(pathlib.Path("tools/site/examples.txt")), docs)
    for name, text in help_texts.items():
        text = text.split("\nKeys of")[0]
        write(docs / f"programs/cpinn-{name}.md",
              f"# cpinn-{name}\n\nThe output of `cpinn-{name} --help`"
              f"{', without the [keys](../keys/index.md)' if name == 'train' else ''}:\n\n"
              f"```text\n{text.rstrip()}\n```\n")
    modules = ["cpinn"] + [f"cpinn.{module.stem}" for module in
                           sorted(pathlib.Path("tools/python/cpinn").glob("[a-z]*.py"))]
    write(docs / "python.md", "# Python reference\n\n" +
          "".join(f"::: {module}\n\n" for module in modules))
    configuration = pathlib.Path("tools/site/mkdocs.yml").read_text()
    for folder in ["keys", "programs"]:
        pages = sorted((docs / folder).glob("*.md"), key=lambda page: (page.stem != "index", page))
        configuration = configuration.replace(
            f" {folder}/\n", "\n" + "".join(f"          - {folder}/{page.name}\n" for page in pages))
    write(docs.parent / "mkdocs.yml", configuration)


main(*sys.argv[1:])
