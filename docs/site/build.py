"""Builds the manual and checks it: build.py ROOT WORK"""

import subprocess
import sys
from pathlib import Path

from check_site import check_site
from stage import Stage

root, work = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
work.mkdir(parents=True, exist_ok=True)
Stage(root, work).run()
subprocess.run(["mkdocs", "build", "--strict", "--quiet", "--clean", "-f", str(work / "mkdocs.yml")], check=True)
site = work / "site"
index = (site / "search/search_index.json").read_text()
(site / "search/search_index.js").write_text(f"var __search = {{ index: Promise.resolve({index}) }};\n")
problems = check_site(site)
for problem in problems:
    print(problem, file=sys.stderr)
sys.exit(bool(problems))
