"""What the site has to be: every link and picture leads somewhere, nothing is loaded from elsewhere, all Markdown is
rendered, and the search knows every function and leads to it."""

import json
import os
import re
from html.parser import HTMLParser
from urllib.parse import unquote


CODE = ("code", "script", "style")


class Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.anchors, self.links, self.loads, self.raw = set(), [], [], []
        self.code = 0

    def handle_data(self, data):
        if not self.code:
            self.raw += re.findall(r"^- .*|.*\|---.*|.*\]\(.*", data, flags=re.M)

    def handle_endtag(self, tag):
        self.code -= tag in CODE

    def handle_starttag(self, tag, attributes):
        self.code += tag in CODE
        values = dict(attributes)
        for key in ("id", "name"):
            if values.get(key):
                self.anchors.add(values[key])
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in ("img", "script", "iframe", "source") and values.get("src"):
            self.loads.append(values["src"])
        if tag == "link" and values.get("href") and values.get("rel") != "canonical":
            self.loads.append(values["href"])


def check_site(site):
    pages = {}
    for path in site.rglob("*.html"):
        parser = Links()
        parser.feed(path.read_text())
        pages[path] = parser
    problems = []
    count = 0
    for path, page in pages.items():
        where = path.relative_to(site)
        problems += [f"{where}: Markdown that is not rendered: {line[:60]}" for line in page.raw]
        for link in page.links + page.loads:
            count += 1
            if re.match(r"(https?:)?//", link):
                if link in page.loads:
                    problems.append(f"{where}: loads {link}")
                continue
            if link.startswith(("mailto:", "javascript:")) or where.name == "404.html":
                continue
            file, _, anchor = link.partition("#")
            target = os.path.normpath(path.parent / unquote(file.split("?")[0])) if file else str(path)
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            if not os.path.exists(target):
                problems.append(f"{where}: {link} leads nowhere")
            elif anchor and not anchor.startswith("__") and target.endswith(".html"):
                if unquote(anchor) not in pages[type(path)(target)].anchors:
                    problems.append(f"{where}: no {link}")
    if count < 1000:
        problems.append(f"only {count} links were seen")
    for path in [*site.rglob("*.css")]:
        for address in re.findall(r"url\(['\"]?(https?:[^)'\"]*)", path.read_text()):
            problems.append(f"{path.relative_to(site)}: loads {address}")
    problems += check_search(site, pages)
    return problems


def check_search(site, pages):
    entries = {entry["location"] for entry in json.loads((site / "search/search_index.json").read_text())["docs"]}
    if "reference/tether.html#pli_body_enable_tethers" not in entries:
        return ["the search does not know pli_body_enable_tethers"]
    functions = 0
    problems = []
    for path, page in pages.items():
        where = path.relative_to(site).as_posix()
        if where.startswith("reference/"):
            for anchor in page.anchors:
                if re.match(r"(pli|PLI)_|Bridge::", anchor):
                    functions += 1
                    if f"{where}#{anchor}" not in entries:
                        problems.append(f"the search does not know {anchor}")
    if functions < 300:
        problems.append(f"the reference has {functions} names only")
    return problems
