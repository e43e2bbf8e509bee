#!/usr/bin/env bash
# Fetches the scripts that vendor.json lists with npm, writes them beside it, and their hashes to SHA256SUMS.
# With --check it compares the files that are here with SHA256SUMS and fetches nothing.
set -euo pipefail
cd "$(dirname "$0")"
if [ "${1-}" = --check ]; then exec sha256sum --check --quiet SHA256SUMS; fi
here=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
packages=$(node -p 'Object.entries(require("./vendor.json")).map(([name, p]) => `${name}@${p.version}`).join(" ")')
# shellcheck disable=SC2086
(cd "$work" && npm init -y >/dev/null && npm install --ignore-scripts --no-audit --no-fund $packages >/dev/null)
node -e '
  const fs = require("fs"), path = require("path");
  const [work, here] = process.argv.slice(1);
  for (const [name, { files }] of Object.entries(require(path.join(here, "vendor.json"))))
    for (const [to, from] of Object.entries(files)) {
      let text = fs.readFileSync(path.join(work, "node_modules", name, from), "utf8");
      // A browser without an import map finds a module by its path alone.
      text = text.replace(/from \x27three\x27/g, "from \x27./three.module.min.js\x27");
      fs.writeFileSync(path.join(here, to), text);
    }' "$work" "$here"
sha256sum -- *.js *.css *.LICENSE > SHA256SUMS
