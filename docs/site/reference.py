"""One Markdown page per public header, from Doxygen's XML, and the table of names by which other pages link to them."""

import re
import subprocess
import xml.etree.ElementTree as xml
from pathlib import Path

GROUPS = (
    ("Core", "core/include/pliant", "pliant"),
    ("Bridge to Bullet", "bullet_bridge/include/pliant_bullet", "pliant_bullet"),
)
NOT_PAGES = {"pliant.h"}  # includes all others


def prepare_header(text):
    """What Doxygen has to see otherwise than the compiler."""
    text = re.sub(r"^(///.*[ (])(#|::)(?=\w)", r"\1\\\2", text, flags=re.M)  # no request for a link
    # The comment after the guard is that of the file.
    text = re.sub(r"^///", "/// @file\n///", text, count=1, flags=re.M)
    text = re.sub(r"^(\s*///) Cost: ", r"\1 @par Cost\n\1 ", text, flags=re.M)
    # A list ends with a blank line: what follows would be a part of its last item.
    text = re.sub(r"^(\s*///)(( - |   ).*)\n(?=\s*/// [^ -])", r"\1\2\n\1\n", text, flags=re.M)
    # Status codes come out of a list of X(name, value, "text").
    codes = re.findall(r'^ +X\((\w+), (\d+), "([^"]*)"\)', text, flags=re.M)
    enumerators = "".join(f"    {name} = {value}, ///< {meaning}\n" for name, value, meaning in codes)
    text = re.sub(r"#define PLI_STATUS_ENUM.*?#undef PLI_STATUS_ENUM\n", lambda _: enumerators, text, flags=re.S)
    return text


def run_doxygen(root, work):
    for _, folder, prefix in GROUPS:
        target = work / "headers" / prefix
        target.mkdir(parents=True, exist_ok=True)
        for old in target.iterdir():
            old.unlink()
        for header in sorted((root / folder).glob("*.h")):
            (target / header.name).write_text(prepare_header(header.read_text()))
    subprocess.run(["doxygen", str(root / "docs/site/Doxyfile")], cwd=work, check=True)


def plain(node):
    return re.sub(r"\s+", " ", "".join(node.itertext())).strip() if node is not None else ""


class Page:
    """The page of one header."""

    def __init__(self, header, prefix, path):
        self.header, self.prefix, self.path = header, prefix, path
        self.about = ""
        self.entries = []  # (line, name, markdown)


class Reference:
    def __init__(self, root, work):
        self.pages = []
        self.names = {}  # name -> (path of the page, anchor)
        self.compounds = {}
        index = xml.parse(work / "xml/index.xml")
        for compound in index.iter("compound"):
            if compound.get("kind") in ("file", "struct", "class", "namespace"):
                refid = compound.get("refid")
                self.compounds[refid] = xml.parse(work / f"xml/{refid}.xml").find("compounddef")
        self.groups = []
        for title, folder, prefix in GROUPS:
            pages = []
            for header in sorted((root / folder).glob("*.h")):
                if header.name in NOT_PAGES:
                    continue
                path = f"reference/{'bullet_' if prefix != 'pliant' else ''}{header.stem}.md"
                page = Page(header.name, prefix, path)
                self.names[f"{prefix}/{header.name}"] = (path, None)
                self.names.setdefault(header.name, (path, None))
                pages.append(page)
            self.groups.append((title, pages))
            self.pages += pages
        self.by_file = {f"{page.prefix}/{page.header}": page for page in self.pages}
        self.found = []  # (page, line, kind, element)
        for compound in self.compounds.values():
            kind = compound.get("kind")
            if kind == "file":
                page = self.page_of(compound)
                if page is not None:
                    page.element = compound
            elif kind in ("struct", "class") and compound.get("prot") != "private":
                page = self.page_of(compound)
                if "::" not in plain(compound.find("compoundname")).removeprefix("pliant::"):
                    self.found.append((page, self.line_of(compound), kind, compound))
                    self.name(page, plain(compound.find("compoundname")).removeprefix("pliant::"))
                    for member in compound.iter("memberdef"):
                        if member.get("prot") == "public":
                            self.name_member(page, compound, member)
            if kind in ("file", "namespace"):
                for member in compound.iter("memberdef"):
                    page = self.page_of(member)
                    if page is None:
                        continue
                    if kind == "file" and member.get("kind") == "function" and page.prefix != "pliant":
                        continue  # of a namespace
                    name = plain(member.find("name"))
                    if member.get("kind") == "define" and not has_comment(member):
                        continue  # helpers of the headers themselves
                    if member.get("kind") == "typedef" and not has_comment(member) and \
                            name not in (f"pli_{page.header.removesuffix('.h')}", "pli_context"):
                        continue  # a handle of another header
                    if member.get("kind") == "function" and not has_comment(member) and page.header != "math.h":
                        raise SystemExit(f"{page.header}: {name} has no comment")
                    self.found.append((page, self.line_of(member), member.get("kind"), member))
                    self.name(page, name if not name.startswith("@") else None)
                    for value in member.iter("enumvalue"):
                        anchor = name if not name.startswith("@") else enum_title(member)
                        self.names[plain(value.find("name"))] = (page.path, anchor)

    def page_of(self, element):
        file = element.find("location").get("file")
        return self.by_file.get(file.removeprefix("headers/"))

    def line_of(self, element):
        return int(element.find("location").get("line"))

    def name(self, page, name):
        if name:
            self.names[name] = (page.path, name)

    def name_member(self, page, compound, member):
        name = plain(member.find("name"))
        owner = plain(compound.find("compoundname")).removeprefix("pliant::")
        anchor = f"{owner}::{name}" if member.get("kind") == "function" else owner
        self.names.setdefault(f"{owner}::{name}", (page.path, anchor))

    # ------------------------------------------------------------------------------------------------- Markdown

    def link(self, name, page):
        target, anchor = self.names[name]
        address = target.removeprefix("reference/") if target != page.path else ""
        return f"[`{name}`]({address}{'#' + anchor if anchor else ''})" if (anchor or address) else f"`{name}`"

    def text(self, text, page, own):
        """Text with its special characters escaped, and with links from names."""
        parts = re.split(r"(\bPLI_[A-Z0-9_]+\b|\bpli_\w+\b|\bdocs/\w+\.md\b|\b\w+\.h\b)", text or "")
        out = []
        for i, part in enumerate(parts):
            if i % 2 == 0:
                out.append(re.sub(r"([*_`\[\]<>|\\#])", r"\\\1", part))
            elif part.startswith("docs/"):
                out.append(f"[{part}](../{part.removeprefix('docs/')})")
            elif part in self.names and part != own:
                out.append(self.link(part, page))
            else:
                out.append(f"`{part}`")
        return "".join(out)

    def flow(self, node, page, own):
        """The text of a paragraph, without the blocks in it."""
        out = [self.text(node.text, page, own)]
        for child in node:
            if child.tag in ("simplesect", "parameterlist", "verbatim", "itemizedlist", "programlisting", "preformatted"):
                pass
            elif child.tag == "computeroutput":
                name = plain(child)
                out.append(self.link(name, page) if name in self.names and name != own else f"`{name}`")
            elif child.tag in ("ndash", "mdash"):
                out.append("–" if child.tag == "ndash" else "—")
            elif child.tag == "sp":
                out.append(" ")
            else:
                out.append(self.flow(child, page, own))
            out.append(self.text(child.tail, page, own))
        return "".join(out)

    def block(self, node, page, own, fields=None):
        """A description as Markdown; a field of a table has it in one line."""
        out = []
        for para in node.findall("para") if node is not None else []:
            text = re.sub(r"\s+", " ", self.flow(para, page, own)).strip()
            if text:
                out.append(text)
            for child in para:
                if child.tag in ("verbatim", "preformatted"):
                    out.append("```text\n" + "".join(child.itertext()).strip("\n") + "\n```")
                elif child.tag == "programlisting":
                    lines = ["".join(line.itertext()) if not line.findall(".//sp") else spaced(line)
                             for line in child.iter("codeline")]
                    out.append("```text\n" + "\n".join(lines) + "\n```")
                elif child.tag == "itemizedlist":
                    items = [re.sub(r"\s+", " ", self.block(item, page, own)) for item in child.findall("listitem")]
                    out.append("\n".join(f"- {item}" for item in items))
                elif child.tag == "parameterlist":
                    if out and out[-1].startswith("- "):
                        out.append("**Parameters:**")  # apart from the list before
                    for item in child.findall("parameteritem"):
                        names = ", ".join(f"`{plain(name)}`" for name in item.iter("parametername"))
                        about = re.sub(r"\s+", " ", self.block(item.find("parameterdescription"), page, own))
                        out.append(f"- {names}: {about}")
                elif child.tag == "simplesect":
                    title = {"return": "Returns", "par": plain(child.find("title"))}.get(child.get("kind"), "Note")
                    about = re.sub(r"\s+", " ", self.block(child, page, own))
                    out.append(f"**{title}:** {about}")
        if fields:
            return " ".join(out)
        joined = ""
        for part in out:  # items of one list follow each other
            if joined:
                joined += "\n" if part.startswith("- ") and joined.rsplit("\n", 1)[-1].startswith("- ") else "\n\n"
            joined += part
        return joined

    def description(self, element, page, own, fields=None):
        both = [self.block(element.find(tag), page, own, fields) for tag in ("briefdescription", "detaileddescription")]
        return (" " if fields else "\n\n").join(part for part in both if part)

    def signature(self, member):
        kind = member.get("kind")
        result = plain(member.find("type")).replace(" *", "*").replace(" &", "&").replace("PLI_API ", "")
        name = plain(member.find("name"))
        if kind == "typedef":
            return f"typedef {result} {name}{plain(member.find('argsstring'))};".replace("( *", "(*")
        if kind == "define":
            parameters = [plain(p) for p in member.findall("param")]
            value = re.sub(r"\s*\\\s", r" \\\n    ", plain(member.find("initializer"))) # one line each, as in the header
            return f"#define {name}{'(' + ', '.join(parameters) + ')' if parameters else ''} {value}".strip()
        if kind == "variable":
            declared = f"{result} {name}{plain(member.find('argsstring'))} {plain(member.find('initializer'))}"
            return declared.strip() + ";"
        arguments = []
        for param in member.findall("param"):
            spelled = plain(param.find("type")).replace(" *", "*").replace(" &", "&")
            argument = f"{spelled} {plain(param.find('declname'))}{plain(param.find('array'))}".strip()
            default = plain(param.find("defval"))
            arguments.append(argument + (f" = {default}" if default else ""))
        head = f"{result} {name}(".strip()
        tail = ")" + (" const" if member.get("const") == "yes" else "") + ";"
        line = head + ", ".join(arguments) + tail
        if len(line) > 78 and len(arguments) > 1:
            line = head + "\n    " + ",\n    ".join(arguments) + tail
        return line

    def entry(self, page, kind, element):
        name = plain(element.find("name")) if kind not in ("struct", "class") else \
            plain(element.find("compoundname")).removeprefix("pliant::")
        if kind in ("struct", "class"):
            out = [f"## {name} {{#{name}}}", self.description(element, page, name)]
            rows, functions = [], []
            for member in element.iter("memberdef"):
                if member.get("prot") != "public":
                    continue
                if member.get("kind") == "variable":
                    spelled = plain(member.find("type")).replace(" *", "*")
                    arguments = plain(member.find("argsstring"))
                    field = plain(member.find("name"))
                    about = self.description(member, page, name, True)
                    rows.append(f"| `{field}` | `{spelled}{arguments}` | {about} |")
                elif member.get("kind") == "function" and has_comment(member):
                    own = f"{name}::{plain(member.find('name'))}"
                    heading = f"### {own} {{#{own}}}\n\n"
                    if any(function.startswith(heading) for function in functions):
                        heading = ""  # overloads share one
                    functions.append(f"{heading}```cpp\n{self.signature(member)}\n```\n\n" +
                                     self.description(member, page, own))
            if rows:
                out.append("| field | type | |\n|---|---|---|\n" + "\n".join(rows))
            return "\n\n".join(part for part in out + functions if part)
        if kind == "enum":
            title = name if name and not name.startswith("@") else enum_title(element)
            out = [f"## {title} {{#{title}}}", self.description(element, page, title)]
            rows = []
            for value in element.iter("enumvalue"):
                number = plain(value.find("initializer")).removeprefix("=").strip()
                own = plain(value.find("name"))
                rows.append(f"| `{own}` | {number} | {self.description(value, page, own, True)} |")
            out.append("| value | | |\n|---|---|---|\n" + "\n".join(rows))
            return "\n\n".join(part for part in out if part)
        language = "cpp" if page.prefix != "pliant" else "c"
        about = self.description(element, page, name)
        if kind == "typedef" and not about:
            about = "A handle; see [objects](../guide.md#objects)."
        parts = (f"## {name} {{#{name}}}", f"```{language}\n{self.signature(element)}\n```", about)
        return "\n\n".join(part for part in parts if part)

    def write(self, target):
        (target / "reference").mkdir(parents=True, exist_ok=True)
        for page in self.pages:
            entries, seen = [], set()
            for owner, line, kind, element in sorted((f for f in self.found if f[0] is page), key=lambda f: f[1]):
                text = self.entry(page, kind, element)
                anchor = text.split("\n", 1)[0]
                if anchor in seen:  # overloads share a heading
                    text = text.split("\n", 1)[1].strip()
                seen.add(anchor)
                entries.append(text)
            about = self.description(page.element, page, page.header)
            include = f"```c\n#include <{page.prefix}/{page.header}>\n```"
            (target / page.path).write_text("\n\n".join([f"# {page.header}", about, include, *entries]) + "\n")
        rows = []
        for title, pages in self.groups:
            rows.append(f"\n## {title}\n\n| header | about |\n|---|---|")
            for page in pages:
                about = self.description(page.element, page, page.header).split("\n\n")[0]
                first = re.split(r"(?<=\.)\s", about)[0].rstrip(":")
                rows.append(f"| [`{page.header}`]({page.path.removeprefix('reference/')}) | {first} |")
        count = sum(1 for _, _, kind, _ in self.found if kind == "function")
        (target / "reference/index.md").write_text(
            "# Reference\n\nEvery type and function, by header, made from the comments of the headers. What holds for "
            "all calls (errors, definitions, handles, callbacks) stands in [`base.h`](base.md); `pliant/pliant.h` "
            "includes all headers of the core.\n" + "\n".join(rows) + f"\n\n{count} functions.\n")


def has_comment(element):
    return bool(plain(element.find("briefdescription")) or plain(element.find("detaileddescription")))


def spaced(line):
    out = []
    for node in line.iter():
        if node.tag == "sp":
            out.append(" ")
        elif node.text:
            out.append(node.text)
        if node.tail:
            out.append(node.tail)
    return "".join(out)


def enum_title(element):
    """What the values of an enumeration without a name have in common."""
    names = [plain(value.find("name")) for value in element.iter("enumvalue")]
    common = names[0]
    for name in names:
        while not name.startswith(common):
            common = common[:-1]
    return common if len(names) > 1 else names[0]
