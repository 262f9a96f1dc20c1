"""Sentences that are too long for reading aloud: of more than 35 words, in the pages of the project, in the
help of the programs, and in the comments of headers that are installed.

    check_sentences.py ROOT BIN [HEADER...]     prints them; exit status 1 when there are any

Left out is code; text between backticks is one word. A sentence ends with . ! ? at the end of a
word, with an empty line, or where an entry of a list or a cell of a table does."""
import pathlib
import re
import subprocess
import sys

LONGEST = 35
PAGES = ["README.md", "configs/**/*.md", "tools/bench/README.md", "tools/site/pages/*.md",
         "CONTRIBUTING.md", "CHANGELOG.md", "autodiff/README.md", "tools/python/README.md"]
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|et al|cf|Fig|vs|approx)\.")


def paragraphs_of_page(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)      # code
    text = re.sub(r"^(?:    ).*$", "", text, flags=re.M)             # indented code
    text = re.sub(r"<[^>]*>", "", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)           # links
    text = re.sub(r"`[^`]*`", "code", text)
    text = re.sub(r"^\s*(?:[-*]|\d+\.|#+) ", "\n\n", text, flags=re.M)
    text = re.sub(r"^\|.*$", lambda row: "\n\n" + row[0].replace("|", "\n\n"), text, flags=re.M)
    return re.split(r"\n\s*\n", text)


def paragraphs_of_help(text):
    """Entries of options and keys, and paragraphs; lines of examples and of tables are apart."""
    text = re.sub(r"^(  \S+: .*)\n(?= {6}\S)", r"\1\n\n", text, flags=re.M)       # keys
    text = re.sub(r"^( {2,}\S.*?)(?: {2,}|: )(?=\S)", r"\1\n\n", text, flags=re.M)
    text = re.sub(r"\n(?= {2}\S)", "\n\n", text)
    text = re.sub(r"^( {2}.*)\n(?=\S)", r"\1\n\n", text, flags=re.M)
    text = re.sub(r"\{[^{}]*\}|\[[^\[\]]*\]|\"[^\"]*\"", "code", text)
    return re.split(r"\n\s*\n", text)


def paragraphs_of_header(text):
    for comment in re.findall(r"/\*(.*?)\*/", text, flags=re.S):
        comment = re.sub(r"^\s*\*", "", comment, flags=re.M)
        comment = re.sub(r"\n {3,}(?=\S)", "\n\n", comment)          # tables, equations
        comment = re.sub(r"\[[^\[\]]*\]", "code", comment)
        yield from re.split(r"\n\s*\n", comment)


def too_long(paragraph):
    text = ABBREVIATIONS.sub(r"\1", " ".join(paragraph.split()))
    for sentence in re.split(r"(?<=[.!?])[)\"*]*\s+", text):
        words = [word for word in sentence.split() if re.search(r"[A-Za-z0-9]", word)]
        if len(words) > LONGEST:
            yield len(words), sentence


def main(root, programs, *headers):
    root = pathlib.Path(root)
    texts = []
    for pattern in PAGES:
        for page in sorted(root.glob(pattern)):
            texts.append((page.relative_to(root), paragraphs_of_page(page.read_text())))
    for program in sorted(pathlib.Path(programs).glob("cpinn-*")):
        if program.is_file():
            said = subprocess.run([program, "--help"], check=True, capture_output=True, text=True)
            texts.append((f"{program.name} --help", paragraphs_of_help(said.stdout)))
    for header in headers:
        texts.append((header, paragraphs_of_header((root / header).read_text())))
    bad = 0
    for name, paragraphs in texts:
        for paragraph in paragraphs:
            for words, sentence in too_long(paragraph):
                print(f"{name}: {words} words: {sentence}")
                bad += 1
    print(f"{bad} sentences of more than {LONGEST} words in {len(texts)} texts")
    return bad > 0


sys.exit(main(*sys.argv[1:]))
