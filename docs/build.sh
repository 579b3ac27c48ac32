#!/bin/sh
# The manual: installs what is missing (Debian, with apt), makes the reference from the headers with Doxygen and the
# site with MkDocs, without a request to the network. The last line of the output is its first page, which opens in any
# browser, from a server or from the disk. A warning of Doxygen or MkDocs is an error.
#
#   usage: sh docs/build.sh [--test]
#
# With --test links, pictures and the search are checked, also in headless Chromium, at the widths of a desk and of a
# phone.
set -eu
cd "$(dirname "$0")/.."
. cmake/bootstrap.sh

packages="python3         command python3
doxygen         command doxygen
mkdocs          command mkdocs
mkdocs-material file    /usr/share/mkdocs/themes/material/base.html
python3-pymdownx file   /usr/lib/python3/dist-packages/pymdownx/__init__.py
libjs-katex     file    /usr/share/javascript/katex/katex.min.js"
if [ "${1-}" = --test ]; then
    packages="$packages
chromium        command chromium
chromium-driver command chromedriver
python3-selenium file   /usr/lib/python3/dist-packages/selenium/__init__.py"
fi
install_missing

export PYTHONDONTWRITEBYTECODE=1
/usr/bin/python3 docs/site/build.py "$PWD" "$PWD/build/manual"
if [ "${1-}" = --test ]; then
    say "searching in the browser"
    /usr/bin/python3 docs/site/test_site.py build/manual/site build/manual/shots
else
    echo "$PWD/build/manual/site/index.html"
fi
