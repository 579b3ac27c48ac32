"""Arranges the pages of the manual for MkDocs: stage.py ROOT WORK

Pages stay where they are, in docs/ and docs/manual/, and read well there too. In WORK/pages

- names of the library in the text lead to their place in the reference, which is made from the headers;
- links to files of the project that are no pages lead to listings of them;
- a line "Program: [name](file)" is followed by the file;
- lists, tables and indents are as Python-Markdown wants them.
"""

import os
import re
import shutil
import sys
from pathlib import Path

from reference import Reference, run_doxygen

LANGUAGES = {".c": "c", ".h": "c", ".cpp": "cpp", ".py": "python", ".sh": "sh", ".cmake": "cmake", ".txt": "text",
             ".js": "js", ".css": "css", ".ini": "ini"}


class Stage:
    def __init__(self, root, work):
        self.root, self.work, self.pages = root, work, work / "pages"
        self.listings = set()

    def target(self, path):
        """Where a file of the project is in the manual; None: nowhere."""
        relative = path.relative_to(self.root).as_posix()
        if relative in ("README.md", "docs/manual/index.md"):
            return "index.md"
        if relative == "CHANGELOG.md":
            return "changelog.md"
        if relative.startswith("docs/") and path.suffix in (".md", ".png", ".svg"):
            return relative.removeprefix("docs/")
        for prefix in ("core/include/", "bullet_bridge/include/"):
            if relative.startswith(prefix):
                name = relative.removeprefix(prefix)
                if name in self.reference.names:
                    return self.reference.names[name][0]
                return "reference/index.md"
        if path.is_dir():
            for name in ("main.c", "main.cpp", "README.md"):
                if (path / name).exists():
                    return self.target(path / name)
            return None
        if relative.endswith(".md"):
            self.listings.add(relative)
            return f"files/{relative}"
        self.listings.add(relative)
        return f"files/{relative}.md"

    def address(self, address, source):
        """A link of the file `source`, as it is in the manual."""
        if re.match(r"[a-z]+:", address) or address.startswith("#"):
            return address
        file, hash_sign, anchor = address.partition("#")
        path = Path(os.path.normpath(source.parent / file))
        if not path.exists():
            raise SystemExit(f"{source}: {address} does not exist")
        target = self.target(path)
        if target is None:
            raise SystemExit(f"{source}: {address} is no part of the manual; link to a file")
        here = self.target(source)
        relative = os.path.relpath(target, os.path.dirname(here) or ".")
        return relative + (hash_sign + anchor if target.endswith(".md") else "")

    def name_link(self, code, source):
        """`code` with a link to its place in the reference, where it has one."""
        names = self.reference.names
        match = re.match(r"(?:pliant::)?((?:PLI_|pli_)\w+|[A-Z]\w+::\w+|\w+(?:/\w+)?\.h|"
                         r"Bridge(?:Def|Snapshot)?\b|import_soft_body)", code)
        if not match or match.group(1) not in names:
            return f"`{code}`"
        if match.group(1).endswith(".h") and match.group(1) != code:
            return f"`{code}`"
        target, anchor = names[match.group(1)]
        relative = os.path.relpath(target, os.path.dirname(self.target(source)) or ".")
        return f"[`{code}`]({relative}{'#' + anchor if anchor else ''})"

    def prose(self, text, source):
        def replace(match):
            if match.group(1):
                label, address = re.match(r"(.*\])\((\S+?)\)$", match.group(1), re.S).groups()
                return f"{label}({self.address(address, source)})"
            return self.name_link(match.group(2), source)

        return re.sub(r"(!?\[(?:`[^`]*`|[^\]`])*\]\([^)\s]+\))|`([^`]+)`", replace, text)

    def convert(self, text, source):
        out, buffer = [], []
        is_code = False
        marker = 0  # width of the list marker above, 0 outside of lists
        is_loose = False  # the item above has more than one paragraph

        def flush():
            out.append(self.prose("\n".join(buffer), source))
            buffer.clear()

        last = ""
        for line in text.split("\n"):
            indent = len(line) - len(line.lstrip(" "))
            if re.match(r" *```", line):
                if buffer:
                    flush()
                is_code = not is_code
                out.append(line)
            elif is_code:
                out.append(line)
            else:
                item = re.match(r"( *)([-*]|\d+\.) ", line)
                is_table = line.lstrip().startswith("|")
                is_wrapped = bool(last.strip()) and not re.match(r" *([-*]|\d+\.) |#", last)
                if item and indent == 0:
                    if last.strip() and (is_loose or (is_wrapped and marker == 0)):
                        buffer.append("")
                    marker = len(item.group(2)) + 1
                    is_loose = False
                elif line.strip() and indent == 0:
                    marker = 0
                    is_loose = False
                elif not line.strip() and marker:
                    is_loose = True
                if is_table and last.strip() and not last.lstrip().startswith("|"):
                    buffer.append("")
                if marker and indent >= marker:
                    line = " " * (4 * (indent // marker) + indent % marker) + line.lstrip(" ")
                if re.match(r"#+ ", line):
                    if buffer:
                        flush()
                    out.append(line)
                    out.append("")
                elif re.match(r"    ", line) and not marker:  # code
                    if buffer:
                        flush()
                    out.append(line)
                else:
                    buffer.append(line)
                    program = re.match(r"Program: \[.*\]\((\S+)\)$", line)
                    if program:
                        flush()
                        path = (source.parent / program.group(1)).resolve()
                        out.append("\n" + self.listing(path))
            last = line
        if buffer:
            flush()
        return "\n".join(out)

    def listing(self, path):
        return f"```{LANGUAGES.get(path.suffix, 'text')}\n{path.read_text().rstrip()}\n```\n"

    def write(self, name, text):
        path = self.pages / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def run(self):
        shutil.rmtree(self.pages, ignore_errors=True)
        self.pages.mkdir(parents=True)
        run_doxygen(self.root, self.work)
        self.reference = Reference(self.root, self.work)
        self.reference.write(self.pages)
        docs = self.root / "docs"
        for source in sorted([*docs.glob("*.md"), *docs.glob("manual/*.md"), self.root / "CHANGELOG.md"]):
            self.write(self.target(source), self.convert(source.read_text(), source))
        done = set()
        while self.listings - done:
            for relative in sorted(self.listings - done):
                path = self.root / relative
                if path.suffix == ".md":
                    self.write(f"files/{relative}", self.convert(path.read_text(), path))
                else:
                    self.write(f"files/{relative}.md", f"# {relative}\n\n{self.listing(path)}")
                done.add(relative)
        shutil.copytree(docs / "pictures", self.pages / "pictures")
        extra = self.pages / "katex"
        extra.mkdir()
        katex = Path("/usr/share/javascript/katex")
        for name in ("katex.min.css", "katex.min.js", "contrib/auto-render.js"):
            shutil.copy(katex / name, extra)
        (extra / "fonts").mkdir()
        for font in (katex / "fonts").glob("*.woff2"):
            shutil.copy(font, extra / "fonts")
        for name in ("manual.css", "page.js", "file_search.js"):
            shutil.copy(docs / "site" / name, self.pages)
        theme = self.work / "theme"
        shutil.rmtree(theme, ignore_errors=True)
        shutil.copytree(docs / "site/theme", theme)
        settings = (docs / "site/mkdocs.yml").read_text()
        for title, pages in self.reference.groups:
            rows = "".join(f"          - {page.header}: {page.path}\n" for page in pages)
            settings = settings.replace(f"      - {title}: []\n", f"      - {title}:\n{rows}")
        (self.work / "mkdocs.yml").write_text(settings)


if __name__ == "__main__":
    Stage(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()).run()
