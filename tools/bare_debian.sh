#!/usr/bin/env bash
# A bare Debian 12, which has only make, git and certificates, with a copy of this repository in /srv/project.
# Usage: tools/bare_debian.sh make FOLDER           make it in a folder
#        tools/bare_debian.sh run FOLDER COMMAND    run a shell command in its /srv/project
#        tools/bare_debian.sh remove FOLDER
# Needs root: the system is a folder made by mmdebstrap, and commands run in it by chroot, with mounts of their own.
# The indexes of pip that this machine is configured for serve there too. Exit status of make: 69 where it cannot run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'bare-debian: %s\n' "$*" >&2; }
cannot_run() { say "$*"; exit 69; }

make_system() {
  [ "$(id -u)" = 0 ] && unshare --mount true 2>/dev/null ||
    cannot_run "needs root and the right to mount, for a Debian 12 of its own. Run it as root, or the same commands on a fresh machine."
  if ! command -v mmdebstrap >/dev/null; then
    command -v apt-get >/dev/null || cannot_run "needs mmdebstrap, and there is no apt to install it. Install it, then run this again."
    say "installing mmdebstrap"
    { apt-get update -qq && apt-get install -y -qq mmdebstrap >/dev/null; } ||
      cannot_run "could not install mmdebstrap with apt-get (its message stands above)."
  fi

  sources=()
  if grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; then # by the same mirrors
    for file in /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list; do
      if [ -s "$file" ] && [ ${#sources[@]} = 0 ]; then sources=("$file"); fi
    done
  fi
  say "making a bare Debian 12 (about 20 s)"
  mmdebstrap --quiet --variant=apt --include=make,git,ca-certificates bookworm "$root" "${sources[@]}"
  cp -L /etc/resolv.conf /etc/hosts "$root/etc/"

  # What pip is configured for here. Files and folders that it names are copied or mounted; an index
  # refers to files next to its folder.
  { python3 -m pip config list 2>/dev/null || true; } | python3 -c '
import ast, os, pathlib, shutil, sys
root = pathlib.Path(sys.argv[1])
settings = {}
for line in sys.stdin:
    name, _, value = line.rstrip("\n").partition("=")
    section, _, option = name.rpartition(".")
    if section in ("global", "install", ":env:"):
        settings[option] = " ".join(ast.literal_eval(value).split())
(root / "etc/pip.conf").write_text("[global]\n" + "".join(f"{k} = {v}\n" for k, v in settings.items()))
folders = set()
for word in " ".join(settings.values()).split():
    if word.startswith("file://"):
        folders.add(str(pathlib.Path(word.removeprefix("file://")).parent))
    elif os.path.isdir(word):
        folders.add(word)
    elif os.path.isabs(word) and os.path.isfile(word):
        (root / word[1:]).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(word, root / word[1:])
print(*sorted(folder for folder in folders if os.path.isdir(folder) and folder != "/"), sep="\n")
' "$root" >"$mounts"

  tools/copy_sources.sh "$root/srv/project"
  chown -R 0:0 "$root/srv/project" # git refuses repositories of others
}

run_command() {
  local begin=$SECONDS
  say "$*"
  # The mounts are in a namespace of their own, which ends with the command.
  # shellcheck disable=SC2016
  unshare --mount bash -euc '
    root=$1 mounts=$2 command=$3
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    while read -r folder; do
      if [ -n "$folder" ]; then mkdir -p "$root$folder" && mount --rbind "$folder" "$root$folder"; fi
    done <"$mounts"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/srv LANG=C.UTF-8 TERM=dumb ${CI:+CI=$CI} \
      chroot "$root" bash -c "cd /srv/project && $command"
  ' run "$root" "$mounts" "$*" </dev/null
  say "$* took $((SECONDS - begin)) s"
}

usage() { echo "usage: tools/bare_debian.sh make|remove FOLDER, or run FOLDER COMMAND" >&2; exit 2; }
[ $# -ge 2 ] || usage
action=$1
root=$(realpath "$2")
mounts=$root.mounts
shift 2
case $action in
  make) make_system ;;
  run) run_command "$*" ;;
  remove) rm -rf --one-file-system "$root" "$mounts" ;;
  *) usage ;;
esac
